"""The data line of a page of docs/results: the measured code, and a note on later changes.

docs/results/versions.json has the measured subjects of pages (the step in the air, contact, ...)
with the changes of each: the number of changes is the subject's version. A page's data line has
the measured commit, the date, and the versions:

    Data: commit 1234abcd, 2026-11-26; flight 2, contact 2.

It is below the title. If a subject has changed since, the next line is a note.
"""

from __future__ import annotations

import datetime
import json
import re
import subprocess
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs/results"
VERSIONS = FOLDER / "versions.json"
GOLDEN = ROOT / "tests/golden"
NOT_MEASURED = {"README"}  # pages of the folder that have no data
DATA = re.compile(
    r"^Data: commit (?P<commit>\S+), (?P<date>[\d-]{10})(?:; (?P<versions>.+))?\.$", re.M
)
OLDER = "**Older than the code.** Since these data"
LINES = re.compile(rf"^(?:Data: commit |{re.escape(OLDER)}).*\n\n?", re.M)


def read_versions() -> dict[str, Any]:
    """Reads versions.json."""
    return dict(json.loads(VERSIONS.read_text(encoding="utf-8")))


def write_versions(versions: dict[str, Any]) -> None:
    """Writes versions.json."""
    VERSIONS.write_text(json.dumps(versions, indent=1) + "\n", encoding="utf-8")


def _git(*words: str) -> str:
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def commit() -> str:
    """Commit of the sources, with `-dirty` if they differ from it; other results may."""
    try:
        name = _git("describe", "--always", "--abbrev=8", "--exclude=*")
        changed = _git("status", "--porcelain", "--untracked-files=no", ".", ":!docs/results")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return f"{name}-dirty" if changed else name


def stamp() -> dict[str, Any]:
    """The stamp of data measured now: commit, date, and the versions of all subjects."""
    subjects = read_versions()["subjects"]
    return {
        "commit": commit(),
        "date": datetime.date.today().isoformat(),
        "versions": {name: len(subject["changes"]) for name, subject in subjects.items()},
    }


def stamp_of(text: str) -> dict[str, Any] | None:
    """The stamp of a page, or None if it has no data line."""
    found = DATA.search(text)
    if found is None:
        return None
    pairs = re.findall(r"(\w+) (\d+)", found["versions"] or "")
    versions = {name: int(version) for name, version in pairs}
    return {"commit": found["commit"], "date": found["date"], "versions": versions}


def body(text: str) -> str:
    """A page without its data line and its note."""
    return LINES.sub("", text)


def data_line(name: str, data: dict[str, Any]) -> str:
    """The line of page `name`, with the versions of its measured subjects."""
    measured = read_versions()["pages"].get(name, list(data["versions"]))
    versions = ", ".join(f"{subject} {data['versions'].get(subject, 1)}" for subject in measured)
    return f"Data: commit {data['commit']}, {data['date']}{versions and '; '}{versions}."


def note(data: dict[str, Any]) -> str | None:
    """The changes since the measurement, or None."""
    subjects = read_versions()["subjects"]
    changes = [
        f"{name}: {change['change']} ({change['date']})"
        for name, version in data["versions"].items()
        for change in subjects[name]["changes"][version:]
    ]
    return f"{OLDER}: {'; '.join(changes)}." if changes else None


def stamped(name: str, text: str, data: dict[str, Any]) -> str:
    """Page `name` with its data line, and the note if needed, below the title."""
    line = data_line(name, data)
    own = stamp_of(line)
    assert own is not None
    head, _, rest = body(text).partition("\n")
    return "\n\n".join(filter(None, [head, line, note(own), rest.lstrip("\n")]))


def write(path: Path, text: str, keeps: bool = False) -> None:
    """Writes a page whose data were measured now.

    Args:
        text: begins with the title's line.
        keeps: some of the data are older: the page keeps its data line, which is the oldest's.
    """
    data = stamp()
    if keeps and path.exists():
        data = stamp_of(path.read_text(encoding="utf-8")) or data
    path.write_text(stamped(path.stem, text, data), encoding="utf-8")


def pages() -> list[Path]:
    """All pages with data."""
    return [page for page in sorted(FOLDER.glob("*.md")) if page.stem not in NOT_MEASURED]


def motion_of(flight: str) -> str:
    """The golden hash of a flight as shipped."""
    hashes = json.loads((GOLDEN / f"{flight}.json").read_text(encoding="utf-8"))["hashes"]
    return str(hashes["as shipped"]["motion"])
