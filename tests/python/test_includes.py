"""Includes run one way: as the table of folders in docs/architecture.md allows."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
INCLUDE = re.compile(r'^#include ["<]([\w./]+)[">]', re.MULTILINE)


def read_table() -> dict[str, set[str]]:
    """Of each folder with C++ files: the folders that its row names."""
    text = (ROOT / "docs/architecture.md").read_text()
    rows = [
        re.split(r"\s*\|\s*", line)[1:4] for line in text.splitlines() if line.startswith("| `")
    ]
    named = {
        folder: set(re.findall(r"[a-z_]+(?:/[a-z_]+)?", words))
        for folders, _, words in rows
        for folder in re.findall(r"`([\w/]+)`", folders)
        if any((ROOT / folder).rglob("*.cpp")) or any((ROOT / folder).rglob("*.h"))
    }
    return {
        folder: {name for name in named if name in words or name.removeprefix("core/") in words}
        for folder, words in named.items()
        if words
    }


TABLE = read_table()


def reach(folder: str) -> set[str]:
    """The folder, those that its row names, and whatever those may include."""
    return {folder}.union(*(reach(other) for other in TABLE.get(folder, ())))


def folder_of(path: str) -> str | None:
    """The row that a file belongs to; None where it is not one of ours."""
    if path == "core/version.h":  # made of no other part
        return "core/base"
    return next((folder for folder in TABLE if path.startswith(folder + "/")), None)


def read_order() -> list[str]:
    """The parts of core/physics: each may include itself and those before it."""
    text = (ROOT / "docs/architecture.md").read_text()
    found = re.search(r"Within `core/physics` the parts have an order[^:]*:([^.]*)", text)
    return re.findall(r"`(\w+)`", found[1]) if found else []


def test_the_table_has_the_folders_of_the_core() -> None:
    core = {f"core/{path.name}" for path in (ROOT / "core").iterdir() if path.is_dir()}
    assert core <= set(TABLE)
    assert all(folder not in reach(other) for folder in TABLE for other in TABLE[folder])
    assert reach("core/env") == {
        "core/env", "core/physics", "core/model", "core/base", "plugins/api"
    }  # fmt: skip


@pytest.mark.parametrize("folder", sorted(TABLE))
def test_a_folder_includes_only_what_its_row_allows(folder: str) -> None:
    allowed = reach(folder)
    for file in sorted((ROOT / folder).rglob("*")):
        if file.suffix not in (".h", ".cpp"):
            continue
        for include in INCLUDE.findall(file.read_text()):
            other = folder_of(include)
            assert other is None or other in allowed, f"{file.relative_to(ROOT)} includes {include}"


def test_parts_of_the_physics_include_one_way() -> None:
    physics, order = ROOT / "core/physics", read_order()
    assert sorted(order) == sorted(path.name for path in physics.iterdir() if path.is_dir())
    for k, part in enumerate(order):
        for file in sorted((physics / part).iterdir()):
            for include in INCLUDE.findall(file.read_text()):
                if include.startswith("core/physics/"):
                    other = include.split("/")[2]
                    assert other in order[: k + 1], f"{file.relative_to(ROOT)} includes {include}"
