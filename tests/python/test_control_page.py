"""docs/control-modes.md: its tables and its figure match the declarations of the built plugins."""

from __future__ import annotations

import itertools
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from measurements import module

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def load():
    """Imports a module of research/."""
    return module


@pytest.fixture
def script(load) -> ModuleType:
    return load("control_page")


@pytest.fixture
def modes(script: ModuleType) -> dict[str, Any]:
    if not script.PROGRAM.exists():
        pytest.skip("the program is not built")
    return script.declared()


def mode(plugin: str, takes: str, gives: str, **more: Any) -> dict[str, Any]:
    return {
        "plugin": plugin,
        "options": [],
        "takes": {"signal": takes, "size": 4},
        "gives": {"signal": gives, "size": 4},
        "passes_on": False,
        **more,
    }


def signal(name: str, acts: bool = False) -> dict[str, Any]:
    return {"signal": name, "meaning": name, "acts": acts}


def test_tables_and_figure_are_current(script: ModuleType, modes: dict[str, Any]) -> None:
    assert script.page(modes) == script.TARGET.read_text(), "scripts/update_docs.sh writes it anew"
    assert script.figure(modes) == script.FIGURE.read_text(), "scripts/update_docs.sh"


def test_every_shipped_controller_is_on_the_page_and_in_the_figure(
    script: ModuleType, modes: dict[str, Any]
) -> None:
    folders = {f.parent.name for f in (ROOT / "controllers").glob("*/README.md")}
    page = script.controller_table(modes)
    assert [name for name in sorted(folders) if f"controllers/{name}/README.md" not in page] == []
    drawn = script.figure(modes)
    moving = {m["plugin"] for m in modes["controllers"] if not m["passes_on"]}
    assert [name for name in sorted(moving) if f">{name}</text>" not in drawn] == []


def test_every_signal_has_a_size(script: ModuleType, modes: dict[str, Any]) -> None:
    names = {s["signal"] for s in modes["signals"]} - {"none"}
    assert names <= set(script.sizes())


def test_levels_stand_above_what_their_controllers_lead_to(load) -> None:
    figure = load("control_figure")
    declared = {
        "signals": [signal("low", acts=True), signal("middle"), signal("high"), signal("alone")],
        "controllers": [
            mode("one", "high", "middle"),
            mode("two", "middle", "low"),
            mode("last", "low", "low"),
        ],
    }
    assert figure.ranked(declared) == ["alone", "high", "middle", "low"]


def test_a_level_that_leads_back_up_is_no_endless_loop(load) -> None:
    figure = load("control_figure")
    declared = {
        "signals": [signal("a"), signal("b"), signal("c", acts=True)],
        "controllers": [mode("x", "a", "b"), mode("y", "b", "a"), mode("z", "b", "c")],
    }
    assert set(figure.ranked(declared)) == {"a", "b", "c"}


def test_arrows_in_one_column_do_not_overlap(load, modes: dict[str, Any]) -> None:
    figure = load("control_figure")
    rows = figure.ranked(modes)
    spans: dict[int, list[tuple[int, int]]] = {}
    for arrow in figure.arrows(modes, rows):
        spans.setdefault(arrow.column, []).append(tuple(sorted((arrow.begin, arrow.end))))
    for taken in spans.values():
        taken.sort()
        assert all(a[1] <= b[0] for a, b in itertools.pairwise(taken))
