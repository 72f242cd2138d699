"""The flights of integrators.py: commands of the robots, and their initial states."""

from __future__ import annotations

import math
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray
from skybody._native import shipped_scenarios

from research.common.programs import RunError, run_skybody

SEED = 0  # as in `skybody run`
FLIGHT = 1.0  # [s]
STEPS_US = (250, 500, 1000, 2000, 4000)  # dt [us]
POLICIES = {"hard_landing": "zero"}  # carries two thirds of the weight: it falls
DASH = 0.2  # a rotor's command is multiplied by 1 - DASH to 1 + DASH
DASH_TIME = 0.1  # for so long [s]
MOST_COMMANDS = 16  # of a robot
UNDASHED = ("hard_landing", "collision")  # flown as they are: they are to touch something
CLOSING = ("collision",)  # begins LEAD before the first contact of the baseline flight
LEAD = 0.3  # [s]
APPROACH = 2.0  # longest time until then [s]
DEFAULTS = {"cvode": "cvode adams", "arkode": "arkode erk"}  # `method: auto`
Reals = NDArray[np.float64]


@dataclass(frozen=True)
class Flight:
    """A baseline flight: commands of robots, each held for `interval` [s]."""

    scenario: str
    own: str  # name of the scenario's integrator
    own_dt: float
    interval: float
    commands: dict[str, Reals]  # of each robot with commands: (intervals, size); rotors in rad/s
    start: Reals  # (bodies, 13) as in the flight log

    @property
    def count(self) -> int:
        return len(next(iter(self.commands.values())))


def shipped() -> list[str]:
    """All scenarios, except those whose robots follow references and have no commands."""
    return [name for name in shipped_scenarios() if not name.startswith("trajectory_")]


def stepping_of(scenario: str) -> tuple[float, int, str]:
    """Its dt [s], action_repeat and integrator, by the name in tables."""
    log = fly_and_log(scenario, 1, [])
    block = re.search(r"^stepping:\n((?: .*\n)+)", log["text"], re.MULTILINE)
    values = dict(re.findall(r"^ +(\w+): (\S+)$", block[1] if block else "", re.MULTILINE))
    own = values.get("integrator", "midpoint")
    method = values.get("method", "auto")
    name = DEFAULTS.get(own, own) if method == "auto" else f"{own} {method}"
    return log["dt"], log["action_repeat"], name


def fly_and_log(scenario: str, steps: int, overrides: list[str]) -> dict[str, Any]:
    """Makes one episode of `skybody run`; returns the data of its log."""
    with tempfile.TemporaryDirectory() as folder:
        words = ["run", scenario, "--policy", POLICIES.get(scenario, "hold"), "--no-picture"]
        words += ["--seed", str(SEED), "--steps", str(steps), "--out", folder]
        run_skybody(*words, overrides=overrides)
        with h5py.File(Path(folder) / "flight.h5") as log:
            episode = log["episodes/0001"]
            return {
                "dt": float(log.attrs["dt"]),
                "action_repeat": int(log.attrs["action_repeat"]),
                "text": str(log.attrs["scenario_text"]),
                "commands": of_robots(episode, "command") | of_robots(episode, "rotor_command"),
                "bodies": episode["bodies"][:],
                "touching": episode["touching"][:],
            }


def of_robots(episode: h5py.Group, name: str) -> dict[str, Reals]:
    """A dataset of the log by robot, from the first action on. Column names are ROBOT.NAME."""
    if name not in episode:  # of width 0
        return {}
    dataset = episode[name]
    owners = [str(column).split(".", 1)[0] for column in dataset.attrs["columns"]]
    return {
        robot: dataset[1:][:, [i for i, owner in enumerate(owners) if owner == robot]]
        for robot in dict.fromkeys(owners)
    }


def baseline(scenario: str) -> Flight:
    dt, repeat, own = stepping_of(scenario)
    interval_us = math.lcm(round(1e6 * dt * repeat), max(STEPS_US))
    held = round(interval_us / (1e6 * dt))
    count = math.ceil(1e6 * FLIGHT / interval_us)
    changes = [f"stepping.action_repeat={held}", "stepping.horizon=0"]
    extra = math.ceil(1e6 * APPROACH / interval_us) if scenario in CLOSING else 0
    log = fly_and_log(scenario, count + extra, changes)
    begin = 0
    if scenario in CLOSING:
        begin = max(
            int(np.flatnonzero(log["touching"])[0]) - math.ceil(1e6 * LEAD / interval_us), 0
        )
    commands = {robot: rows[begin : begin + count] for robot, rows in log["commands"].items()}
    if any(len(rows) < count for rows in commands.values()):
        raise RunError(f"{scenario}: the baseline flight ends before {FLIGHT:g} s")
    if scenario not in UNDASHED:
        factors = dashes(count, 1e-6 * interval_us)
        commands = {r: rows * factors[:, : rows.shape[1]] for r, rows in commands.items()}
    return Flight(scenario, own, dt, 1e-6 * interval_us, commands, log["bodies"][begin])


def dashes(count: int, interval: float) -> Reals:
    """Factors of commands, (intervals, MOST_COMMANDS), the first of which apply to every robot.

    So a formation keeps its shape.
    """
    random = np.random.default_rng(SEED)
    held = max(1, round(DASH_TIME / interval))
    shape = (math.ceil(count / held), MOST_COMMANDS)
    return np.repeat(random.uniform(1.0 - DASH, 1.0 + DASH, shape), held, axis=0)[:count]
