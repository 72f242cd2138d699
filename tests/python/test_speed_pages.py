"""The scripts behind first_flight.md and ray_speed.md: accepted and refused inputs."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest
from skybody._native import versions
from skybody.ray.cluster import ClusterError

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "experiments"))
first_flight = importlib.import_module("first_flight")
ray_speed = importlib.import_module("ray_speed")

PROGRAM = """#!/bin/sh
if [ "$1" = train ]; then
  mkdir -p flights/run
  echo '9000000 steps in 8.1 s, 1,111,111 steps/s: environment 30 %'
  echo 'evaluation at 9000000 steps, 20 episodes: return 1650, 100.0 % without failure'
  echo 'fly it  skybody run hover_learn --policy flights/run'
elif [ "$4" = flights/run ]; then
  FLOWN
  echo 'position_error  m  0.01  2.5  0.0123'
fi
"""
MACHINE = {
    "machine": "here",
    "processor": "some",
    "processors": 2,
    "date": "2026-01-01",
    "load": [0.0],
    "versions": {**versions(), "python": "3"},
}


def program(folder: Path, flown: str) -> Path:
    """A stand-in that prints the output of `skybody`."""
    file = folder / "skybody"
    file.write_text(PROGRAM.replace("FLOWN", flown))
    file.chmod(0o755)
    return file


def test_a_first_flight_is_what_training_says_and_ends_where_the_table_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawing = "mkdir flights/flown; touch flights/flown/flight-0001.png"
    monkeypatch.setattr(first_flight, "PROGRAM", program(tmp_path, drawing))
    row = first_flight.turn("")
    assert row["commands"][1] == "skybody run hover_learn --policy flights/run"
    assert (row["steps"], row["steps_per_second"]) == (9_000_000, 1_111_111)
    assert row["error_at_the_end"] == 0.0123
    assert row["seconds"] == row["training_seconds"] + row["flight_seconds"]
    page = first_flight.page({**MACHINE, "rows": [row, {**row, "seconds": 31.0}]})
    assert "    skybody run hover_learn --policy flights/run\n" in page
    assert "return 1650, 100.0 % without failure" in page


@pytest.mark.parametrize(("flown", "message"), [("exit 2", "failed"), (":", "drawn no picture")])
def test_a_flight_that_fails_is_no_figure(
    flown: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(first_flight, "PROGRAM", program(tmp_path, flown))
    with pytest.raises(first_flight.FlightError, match=message):
        first_flight.turn("")


def test_workers_that_learn_something_else_are_no_figure() -> None:
    work, names = ray_speed.WORKS[0], ray_speed.settings_of(2)
    same = [ray_speed.Turn(1000.0 * (k + 1), "ab") for k in range(len(names))]
    row = ray_speed.figures(work, names, [same, same])
    page = ray_speed.page({**MACHINE, "ray": "2", "turns": 2, "rows": [row]})
    assert "| as shipped | 1,000 (1.00) | 2,000 (2.00) | 3,000 (3.00) |" in page
    other = [*same[:-1], ray_speed.Turn(1.0, "cd")]
    with pytest.raises(ClusterError, match="as shipped: different parameters: ab, cd"):
        ray_speed.figures(work, names, [same, other])
