"""Includes go in one direction, as tests/python/includes.yaml allows."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
INCLUDE = re.compile(r'^#include ["<]([\w./]+)[">]', re.MULTILINE)

ALLOWED = yaml.safe_load((Path(__file__).parent / "includes.yaml").read_text())
LAYERS: dict[str, list[str]] = ALLOWED["layers"]
PUBLIC: dict[str, str] = ALLOWED["public"]
PARTS: dict[str, list[str]] = ALLOWED["parts"]


def reach(folder: str) -> set[str]:
    """The folder, the folders of its row, and recursively those that they may include."""
    return {folder}.union(*(reach(other) for other in LAYERS[folder]))


def folder_of(path: str) -> str | None:
    """The layer that a header belongs to; None for other headers."""
    if path == "core/version.h":  # includes no other part
        return "core/base"
    if path in PUBLIC:
        return PUBLIC[path]
    return next((folder for folder in LAYERS if path.startswith(folder + "/")), None)


def sources(folder: Path) -> list[Path]:
    return sorted(file for file in folder.rglob("*") if file.suffix in (".h", ".cpp"))


def test_the_rows_are_all_layers_without_circles() -> None:
    below = [path for top in ("core", "plugins") for path in (ROOT / top).iterdir()]
    tops = [ROOT / top for top in ("controllers", "sensors", "effects", "randomization", "tasks")]
    tops += [ROOT / top for top in ("learn", "onboard", "app", "python", "render")]
    folders = {str(p.relative_to(ROOT)) for p in below + tops if p.is_dir() and sources(p)}
    assert folders - {"plugins/template"} == set(LAYERS)
    assert all(folder not in reach(other) for folder in LAYERS for other in LAYERS[folder])
    assert reach("core/env") == {
        "core/env", "core/physics", "core/model", "core/base", "core/plugin_abi"
    }  # fmt: skip


def test_the_core_includes_nothing_of_the_kit() -> None:
    """The kit is built on the core: an include the other way would be a circle."""
    core = set().union(*(reach(folder) for folder in LAYERS if folder.startswith("core/")))
    assert [folder for folder in core if not folder.startswith("core/")] == []


@pytest.mark.parametrize("folder", sorted(LAYERS))
def test_the_map_lists_the_layer(folder: str) -> None:
    assert f"`{folder}`" in (ROOT / "docs/architecture.md").read_text()


@pytest.mark.parametrize("folder", sorted(LAYERS))
def test_a_folder_includes_only_what_its_row_allows(folder: str) -> None:
    allowed = reach(folder)
    for file in sources(ROOT / folder):
        for include in INCLUDE.findall(file.read_text()):
            other = folder_of(include)
            assert other is None or other in allowed, f"{file.relative_to(ROOT)} includes {include}"


@pytest.mark.parametrize("folder", sorted(PARTS))
def test_parts_of_a_folder_include_one_way(folder: str) -> None:
    top, order = ROOT / folder, PARTS[folder]
    assert sorted(order) == sorted(path.name for path in top.iterdir() if path.is_dir())
    for k, part in enumerate(order):
        for file in sources(top / part):
            for include in INCLUDE.findall(file.read_text()):
                if include.startswith(folder + "/"):
                    other = include.removeprefix(folder + "/").split("/")[0]
                    assert other in order[: k + 1], f"{file.relative_to(ROOT)} includes {include}"
