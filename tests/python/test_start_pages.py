"""docs/start: all commands, files and programs of the pages run, as `start_pages` runs them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from measurements import module

start_pages = module("start_pages")


@pytest.mark.parametrize("page", start_pages.names())
def test_all_that_a_page_prints_runs(page: str, tmp_path: Path) -> None:
    start_pages.run_page(page, tmp_path / page, quick=True)


def test_a_command_that_fails_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "wrong.md").write_text("# Wrong\n\n    skybody check no_such_scenario\n")
    monkeypatch.setattr(start_pages, "PAGES", tmp_path)
    with pytest.raises(start_pages.RunError, match="no_such_scenario"):
        start_pages.run_page("wrong", tmp_path / "run", quick=True)


def test_every_indented_line_of_a_page_is_run_or_is_output() -> None:
    for page in start_pages.PAGES.glob("*.md"):
        text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
        lines = re.findall(r"^    (\S.*)$", text, re.MULTILINE)
        known = (*start_pages.WORDS, "ok:", "episode", "1 ")
        assert [line for line in lines if not line.startswith(known)] == []


def test_every_page_has_its_pictures() -> None:
    for page in start_pages.names():
        text = (start_pages.PAGES / f"{page}.md").read_text()
        shown = re.findall(r"!\[[^\]]+\]\(images/(\w+)\.webp\)", text)
        made = [n for n, source in start_pages.PICTURES.items() if source.startswith(f"{page}/")]
        assert sorted(shown) == sorted(made)
        assert len(shown) >= 2
