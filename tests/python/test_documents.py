"""Links and paths in the Markdown pages of the repository."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
# A path that a page names in backticks, as in `docs/python.md`. Only whole files of these folders.
NAMED = re.compile(r"`((?:docs|examples|research|scripts|scenarios)/[\w./-]+\.\w+)`")
HEADING = re.compile(r"^#+\s+(.*)$", re.MULTILINE)
# Heads that scripts/update_docs.sh puts before the pages that it generates in docs/.
HEAD = "_head.md"


def pages() -> list[Path]:
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.md"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return [
        ROOT / name
        for name in listed.stdout.splitlines()
        if (ROOT / name).is_file() and not name.endswith(HEAD)
    ]


def without_code(text: str) -> str:
    """The text without fenced blocks, because brackets in them are not links."""
    return re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)


def anchors(page: Path) -> set[str]:
    """Anchors of the page's headings, as GitHub generates them."""
    headings = HEADING.findall(without_code(page.read_text()))
    plain = [re.sub(r"[^\w\- ]", "", heading.strip().lower()) for heading in headings]
    return {heading.replace(" ", "-") for heading in plain}


def problem(page: Path, link: str) -> str | None:
    """The reason why a link of `page` is broken, or None."""
    target, _, anchor = link.partition("#")
    file = (page.parent / target).resolve() if target else page
    if not file.exists():
        return f"{link}: no such file"
    if anchor and file.suffix == ".md" and anchor not in anchors(file):
        return f"{link}: no such heading"
    return None


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_no_relative_link_is_broken(page: Path) -> None:
    links = LINK.findall(without_code(page.read_text()))
    relative = [link for link in links if not re.match(r"[a-z]+:", link)]
    assert [found for link in relative if (found := problem(page, link))] == []


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_files_that_a_page_names_exist(page: Path) -> None:
    names = NAMED.findall(without_code(page.read_text()))
    assert [name for name in names if not (ROOT / name).exists()] == []


def test_the_page_of_results_lists_every_result() -> None:
    folder = ROOT / "docs/results"
    listed = LINK.findall((folder / "README.md").read_text())
    assert {page.name for page in folder.glob("*.md")} - {"README.md"} <= set(listed)


def test_a_broken_link_is_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("# A heading\n")
    assert problem(page, "page.md#a-heading") is None
    assert problem(page, "#a-heading") is None
    assert problem(page, "gone.md") == "gone.md: no such file"
    assert problem(page, "page.md#another") == "page.md#another: no such heading"
