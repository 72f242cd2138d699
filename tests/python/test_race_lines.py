"""The lines that learned laps are compared with lead through the gates of the present scenarios."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from measurements import module

ROOT = Path(__file__).resolve().parents[2]
race_lines = module("race_lines")
page_data = module("page_data")

CONTENT = json.loads((ROOT / "docs/results/data/race_lines.json").read_text())
GATE = race_lines.Gate(np.array([2.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), 0.5)
RACE = race_lines.Race(np.zeros(3), (GATE,), laps=1)


def test_the_page_is_what_the_figures_make_of_it() -> None:
    text = (ROOT / "docs/results/race_lines.md").read_text()
    assert race_lines.page(CONTENT) == page_data.body(text)


@pytest.mark.parametrize("row", CONTENT["rows"], ids=lambda row: row["scenario"])
def test_the_page_is_of_the_gates_and_laps_of_today(row: dict[str, float]) -> None:
    race = race_lines.race_of(row["scenario"])
    assert (row["gates"], row["laps"]) == (len(race.order), race.laps)
    assert row["seconds"] == min(row["seconds_by_seed"])


def test_a_gate_of_a_scenario_leaves_room_for_the_robot_and_leads_along_its_normal() -> None:
    lower = race_lines.race_of("racing_split_s").gates[1]
    assert lower.reach == pytest.approx(0.5)
    assert lower.direction == pytest.approx([-1.0, 0.0, 0.0], abs=1e-4)


@pytest.mark.parametrize(
    ("places", "is_good"),
    [
        ([[1.0, 0.0, 1.0], [3.0, 0.0, 1.0]], True),
        ([[3.0, 0.0, 1.0], [1.0, 0.0, 1.0]], False),  # backwards
        ([[1.0, 1.0, 1.0], [3.0, 1.0, 1.0]], False),  # beside the gate
        ([[1.0, 1.0, 1.0], [3.0, 1.0, 1.0], [1.0, 0.0, 1.0], [3.0, 0.0, 1.0]], True),
    ],
)
def test_a_line_is_to_lead_through_the_gate(places: list[list[float]], is_good: bool) -> None:
    if is_good:
        race_lines.check(RACE, np.array(places))
        return
    with pytest.raises(race_lines.LineError, match="gate 1"):
        race_lines.check(RACE, np.array(places))
