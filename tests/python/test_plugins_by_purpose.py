"""The page of plugins by purpose has a row for each shipped plugin, and for no other."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/plugins_by_purpose.md"
KINDS = {
    "controllers": "controller",
    "sensors": "sensor",
    "effects": "effect",
    "randomization": "randomizer",
    "tasks": "task",
}
ROW = re.compile(r"^\| (.+) \| \[(\w+)\]\(\.\./(\w+)/(\w+)/README\.md\) \| (\w+) \|$")


def rows() -> list[tuple[str, str, str, str, str]]:
    """Purpose, name, folder of the kind, folder of the plugin, kind."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    matches = {line: ROW.match(line) for line in lines if line.startswith("| ")}
    heads = {"| I want to | plugin | kind |", "| --- | --- | --- |"}
    assert [line for line, match in matches.items() if not match and line not in heads] == []
    return [match.groups() for match in matches.values() if match]  # type: ignore[misc]


def test_each_shipped_plugin_has_a_row() -> None:
    folders = [folder for kind in KINDS for folder in (ROOT / kind).iterdir()]
    shipped = {
        (folder.parent.name, folder.name)
        for folder in folders
        if (folder / f"{folder.name}.cpp").is_file()
    }
    assert {(kind, folder) for _, _, kind, folder, _ in rows()} == shipped


def test_rows_name_the_plugin_and_the_kind_that_they_link() -> None:
    for _, name, kind, folder, word in rows():
        assert (name, word) == (folder, KINDS[kind])


def test_no_purpose_is_listed_twice() -> None:
    purposes = [purpose for purpose, *_ in rows()]
    assert len(purposes) == len(set(purposes))
