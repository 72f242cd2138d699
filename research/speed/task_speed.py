"""Steps a second of each task from Python.

    python -m research run task_speed [SCENARIO ...] [--quick] [--out DIR]

Every environment gets the same constant action: the mean action of the baseline `hold` in a
flight. So vehicles stay in the air for most of an episode, and resets are included in the
measurement, as in training. If scenarios are named, only those are measured, and the page keeps
its figures of the others.
"""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import skybody

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, plain_table, thousands, write_page
from research.common.programs import RunError, run_skybody
from research.common.throughput import QUICK, Case, Length, measure, summary

PAGE = "task_speed"

ENVS = 1024
LENGTH = Length(trials=2, warm_up=20, receives=20, seconds=0.4, most=1.5)
NAMES = """
hover hover_learn trajectory trajectory_modular trajectory_ctbr trajectory_compact
vehicles_trajectory trajectory_paper trajectory_modular_paper payload payload_learn payload_paper
payload_1khz payload_modular payload_modular_learn payload_modular_1khz payload_modular_paper
pendulum pendulum_learn pendulum_randomized pendulum_learn_randomized pendulum_paper racing
racing_drawn racing_duel racing_figure racing_split_s landing obstacles obstacles_rays chase
chase_agents formation_2 formation formation_10 formation_20 formation_learn formation_learn_2
formation_obstacles cooperative_payload cooperative_payload_learn cooperative_payload_ropes arm
"""
SCENARIOS = tuple(NAMES.split())


@dataclass(frozen=True)
class Line:
    """Measurement of one scenario."""

    robots: int
    actions: int
    observations: int
    repeat: int  # physics steps per action
    rate: float  # environment steps per second

    def cells(self, scenario: str) -> list[str]:
        """Cells of the table's row."""
        numbers = [self.robots, self.observations, self.actions, self.repeat]
        return [
            scenario,
            *map(str, numbers),
            thousands(self.rate),
            thousands(self.rate * self.repeat),
            thousands(self.rate * self.repeat * self.robots),
        ]


HEAD = head(
    "scenario | robots | observations | actions | physics steps a step | steps | physics steps"
    " | of robots"
)


def steady_action(scenario: str) -> tuple[float, ...]:
    """The mean action of a flight by `hold`."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log"
        run_skybody("run", scenario, "--episodes", "1", "--no-picture", "--out", log)
        with h5py.File(log / "flight.h5") as file:
            (episode,) = file["episodes"].values()
            return tuple(float(a) for a in np.asarray(episode["action"]).mean(axis=0))


def measure_line(scenario: str, length: Length) -> Line:
    """Measures one scenario."""
    compiled = skybody.CompiledScenario(scenario)
    row = steady_action(scenario)
    case = Case(scenario, ENVS, ENVS, "hold", row=row)
    return Line(
        robots=len(compiled.robots),
        actions=compiled.action_size,
        observations=compiled.observation_size,
        repeat=compiled.action_repeat,
        rate=summary(measure(case, length)).rate,
    )


def page(lines: dict[str, Line], found: dict[str, Any]) -> str:
    """The report."""
    rows = [HEAD, *(line.cells(f"`{scenario}`") for scenario, line in lines.items())]
    return f"""# Speed of each task from Python

    .venv/bin/python -m research run task_speed

{machine_line(found)}

{ENVS:,} environments in one batch of `make_pool`, a thread for each processor, and the last three
columns in thousands a second: environment steps, where a world counts once, physics steps, and
physics steps of single robots. Each environment gets the mean action of a flight by `hold`: no
policy is asked, and vehicles that drift beyond their limits begin anew, as in training.
Observations are float32.

{markdown_table(rows)}
"""


def main() -> int:
    options = (
        Options(__doc__, __name__)
        .add("scenarios", nargs="*", metavar="SCENARIO", help="scenarios; default: all")
        .given()
    )
    if unknown := [name for name in options.scenarios if name not in SCENARIOS]:
        raise RunError(f"no scenario `{unknown[0]}`: there are {', '.join(SCENARIOS)}")
    found = facts()
    measured = {}
    for scenario in options.scenarios or SCENARIOS:
        measured[scenario] = measure_line(scenario, QUICK if options.quick else LENGTH)
        print(plain_table([measured[scenario].cells(scenario)]), flush=True)
    data = options.out / "data/task_speed.json"
    known = json.loads(data.read_text())["lines"] if data.is_file() else {}
    known |= {name: vars(line) for name, line in measured.items()}
    lines = {name: known[name] for name in SCENARIOS if name in known}
    text = page({k: Line(**v) for k, v in lines.items()}, found)
    keeps = set(lines) != set(measured)
    write_page(options.out, PAGE, text, {"facts": found, "lines": lines}, keeps)
    return 0
