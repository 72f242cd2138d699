"""Pages of docs/results name the code of their data, and the changes to it since then."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from typing import Any

import pytest
from measurements import module

ROOT = Path(__file__).resolve().parents[2]
NAMES = sorted(page.stem for page in (ROOT / "docs/results").glob("*.md") if page.stem != "README")
TITLE = "# A trial\n\nText.\n"


@pytest.fixture
def data() -> Any:
    return module("page_data")


@pytest.mark.parametrize("name", NAMES)
def test_a_page_says_of_which_code_its_data_are_and_where_that_is_older(
    data: Any, name: str
) -> None:
    text = (ROOT / f"docs/results/{name}.md").read_text()
    stamp = data.stamp_of(text)
    assert stamp is not None, f"no data line; mark_older_pages --stamp writes it: {name}"
    assert data.stamped(name, text, stamp) == text, "mark_older_pages marks it"


def test_every_page_has_its_subjects(data: Any) -> None:
    versions = data.read_versions()
    assert sorted(versions["pages"]) == NAMES
    named = {subject for subjects in versions["pages"].values() for subject in subjects}
    assert named == set(versions["subjects"])


def test_a_subject_whose_golden_flights_moved_has_a_new_version(data: Any) -> None:
    for name, subject in data.read_versions()["subjects"].items():
        found = {flight: data.motion_of(flight) for flight in subject["golden"]}
        assert found == subject["golden"], (
            f"tests/golden moved: mark_older_pages --raise {name} 'CHANGE', or --same "
            f"{name} where figures stay as they are"
        )


def test_every_script_that_writes_a_page_writes_its_data_line() -> None:
    writers = ROOT.glob("research/**/*.py")
    raw = re.compile(r"\.md\"\)\.write_text\(|markdown\)?\.write_text\(")
    assert [path.name for path in writers if raw.search(path.read_text())] == []


def versions(*changes: str) -> dict[str, Any]:
    rows = [{"date": "2026-01-01", "change": change} for change in changes]
    subjects = {"flight": {"about": "", "golden": {}, "changes": rows}}
    return {"subjects": subjects, "pages": {"trial": ["flight"]}}


def test_a_page_is_marked_when_a_version_is_raised_and_no_longer_when_made_anew(
    data: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(data, "VERSIONS", tmp_path / "versions.json")
    page = tmp_path / "trial.md"
    data.write_versions(versions("first"))
    data.write(page, TITLE)
    text = page.read_text()
    assert re.match(r"# A trial\n\nData: commit \S+, [\d-]{10}; flight 1\.\n\nText\.\n$", text)
    assert data.body(text) == TITLE

    data.write_versions(versions("first", "second", "third"))
    older = data.stamped("trial", text, data.stamp_of(text))
    said = "Since these data: flight: second (2026-01-01); flight: third (2026-01-01).\n"
    assert said in older
    assert data.stamped("trial", older, data.stamp_of(older)) == older
    assert data.body(older) == TITLE

    page.write_text(older)
    data.write(page, TITLE, keeps=True)  # some of the data are the old ones
    assert page.read_text() == older
    data.write(page, TITLE)
    assert "; flight 3.\n\nText." in page.read_text()


def test_a_page_that_measures_no_subject_says_commit_and_date(data: Any) -> None:
    stamp = {"commit": "abc", "date": "2026-01-01", "versions": {}}
    text = data.stamped("memory", TITLE, stamp)
    assert text == "# A trial\n\nData: commit abc, 2026-01-01.\n\nText.\n"
    assert data.stamp_of(text) == stamp


def test_the_index_of_pages_is_what_the_measurements_say() -> None:
    registry = importlib.import_module("research.registry")
    assert registry.page() == registry.INDEX.read_text(), "python -m research index writes it anew"


def test_every_measurement_says_its_subject_in_a_sentence() -> None:
    registry = importlib.import_module("research.registry")
    assert len(registry.measurements()) > 40
    for row in registry.measurements():
        assert row.subject and row.subject[-1] in ".?", f"{row.name}: {row.subject}"
