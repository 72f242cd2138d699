"""Fastest lines through the gates of a race, for comparison with learned laps.

    python -m research run race_lines [--quick] [--out DIR]

Each line begins at rest at the initial position of the scenario's robot, leads through all gates of
all laps at their nominal positions, and ends at rest behind the last one. Writes race_lines.md and
its JSON, whose lap times learning_courses.py compares with learned races.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from skybody import CompiledScenario

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page
from research.common.programs import RunError, run_skybody

PAGE = "race_lines"

Reals = NDArray[np.float64]
SCENARIOS = ("racing", "racing_figure", "racing_split_s")
VEHICLE = "qdrone2"
LINES, QUICK_LINES = 20_000, 200
SEEDS = 5  # of the search, whose results differ by up to a tenth
BEHIND = 0.5  # distance of the line's end from the last gate [m]
TOLERANCE = 0.01  # of a position on the line, which has a point every 0.02 s [m]
FOUND = re.compile(r"^ *\d+ +[\d.]+ +([\d.]+) +([\d.]+) *$", re.MULTILINE)


class LineError(RunError):
    """A line that is not found, or misses a gate; the text is the whole message."""


@dataclass(frozen=True)
class Gate:
    """An opening at its nominal position."""

    centre: Reals  # W [m]
    direction: Reals  # direction of passage, W
    reach: float  # largest distance of a robot's centre from its centre [m]

    def course(self) -> dict[str, Any]:
        """A gate of the input of `skybody plan`."""
        place = {"position": self.centre.tolist(), "direction": self.direction.tolist()}
        return {**place, "reach": self.reach}


@dataclass(frozen=True)
class Race:
    """The course of a race."""

    start: Reals  # W [m]
    gates: tuple[Gate, ...]  # of one lap
    laps: int

    @property
    def order(self) -> tuple[Gate, ...]:
        """All gates of all laps."""
        return self.gates * self.laps

    def course(self) -> dict[str, Any]:
        """The input of `skybody plan`."""
        last = self.gates[-1]
        return {
            "start": self.start.tolist(),
            "gates": [gate.course() for gate in self.order],
            "finish": (last.centre + BEHIND * last.direction).tolist(),
        }


def race_of(scenario: str) -> Race:
    """A scenario's race, without its draws."""
    found = yaml.safe_load(CompiledScenario(scenario).scenario_text)
    parameters = found["task"]["parameters"]
    shapes = [shape for shape in found["obstacles"] if "gate" in shape]
    return Race(
        start=np.array(found["robots"][0]["pose"]["position"], float),
        gates=tuple(_gate(shape, parameters.get("radius", 0.2)) for shape in shapes),
        laps=parameters["laps"],
    )


def _gate(shape: dict[str, Any], radius: float) -> Gate:
    turn = Rotation.from_euler("xyz", shape.get("rpy", [0.0, 0.0, 0.0]))
    return Gate(
        centre=np.array(shape["position"], float),
        direction=turn.apply([1.0, 0.0, 0.0]),
        reach=round(min(shape["gate"][:2]) / 2 - radius, 6),
    )


def check(race: Race, line: Reals) -> None:
    """Raises LineError unless the line leads through all gates in their direction.

    Args:
        line: positions on it, one per row.
    """
    begin = 0
    for k, gate in enumerate(race.order):
        depth = (line[begin:] - gate.centre) @ gate.direction
        crossings = np.flatnonzero((depth[:-1] < 0.0) & (depth[1:] >= 0.0))
        for at in crossings:
            share = -depth[at] / (depth[at + 1] - depth[at])
            place = (1.0 - share) * line[begin + at] + share * line[begin + at + 1]
            if np.linalg.norm(place - gate.centre) <= gate.reach + TOLERANCE:
                begin += int(at) + 1
                break
        else:
            raise LineError(f"the line does not lead through gate {k + 1} in its direction")


def plan(race: Race, lines: int, seed: int) -> dict[str, float]:
    """The fastest of `lines` lines: its seconds and peak speed."""
    with tempfile.TemporaryDirectory() as name:
        gates, table = Path(name) / "gates.yaml", Path(name) / "line.csv"
        gates.write_text(yaml.safe_dump(race.course()))
        words = ("--out", table, "--samples", str(lines), "--seed", str(seed))
        found = FOUND.search(run_skybody("plan", gates, VEHICLE, *words))
        if found is None:
            raise LineError("`skybody plan` printed no line")
        check(race, np.loadtxt(table, delimiter=",", skiprows=2)[:, 1:4])
    return {"seconds": float(found[1]), "peak_speed": float(found[2])}


def row_of(scenario: str, lines: int) -> dict[str, Any]:
    """A scenario's line."""
    race = race_of(scenario)
    found = [plan(race, lines, seed) for seed in range(SEEDS)]
    quickest = min(found, key=lambda line: line["seconds"])
    return {
        "scenario": scenario,
        "gates": len(race.order),
        "laps": race.laps,
        "reach": race.gates[0].reach,
        **quickest,
        "seconds_by_seed": [line["seconds"] for line in found],
    }


def page(content: dict[str, Any]) -> str:
    """The page."""
    table = [head("scenario | gates | all laps [s] | a lap [s] | peak speed [m/s] | by seed [s]")]
    for row in content["rows"]:
        times = [f"{row['seconds']:.2f}", f"{row['seconds'] / row['laps']:.2f}"]
        by_seed = ", ".join(f"{seconds:.2f}" for seconds in row["seconds_by_seed"])
        start = [f"`{row['scenario']}`", str(row["gates"])]
        table.append([*start, *times, f"{row['peak_speed']:.1f}", by_seed])
    return f"""# Race lines

    python -m research run {PAGE}

on {machine_line(content)}.

The quickest line that `skybody plan` finds ([references.md](../references.md#race-lines)) with
{SEEDS} seeds of {content["lines"]:,} lines each, for a QDrone2 through all gates of all laps, at
their nominal places and within {content["rows"][0]["reach"]:g} m of their middles: that is as much
as an opening leaves for a robot's radius. A line begins at rest where the scenario's robot stands
and ends at rest {BEHIND:g} m behind the last gate. A lap is the time of the line divided by the
number of laps.

{markdown_table(table)}

The script refuses a line that does not lead through each gate in its direction. The lines keep
15 % of the rotors' thrust in reserve and are paths of least snap: good ones, not the quickest that
there are. A policy that begins with some speed, or does not brake at the end, may be quicker.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Plans, writes; returns the exit code."""
    options = Options(__doc__, __name__).given(arguments)
    lines = QUICK_LINES if options.quick else LINES
    rows = [row_of(scenario, lines) for scenario in SCENARIOS]
    content = {**facts(), "lines": lines, "rows": rows}
    write_page(options.out, PAGE, page(content), content)
    return 0
