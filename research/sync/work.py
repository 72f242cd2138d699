"""The work of each trial: 200 wrenches at 100 Hz, 10 physics steps each, for a QDrone2.

This module needs no Skybody: the process of the policy has it, too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]

SCENARIO, SEED = "hover", 1
ODOMETRY, WRENCH = "/quad/odometry", "/quad/wrench"  # topics
DT = 0.001  # of a physics step [s]
STEPS = 10  # physics steps of an action: K
PERIOD = DT * STEPS  # of actions [s]
WRENCHES = 200  # of a trial
WEIGHT = 1.54 * 9.82  # of the vehicle [N]
LOOPS = ("open", "closed")

ASIDE = np.array([0.6, -0.6, 0.5])  # goal of the closed loop, from where it begins [m]

RESTORE, END = "restore", "end"  # first words of messages that are no action


@dataclass(frozen=True)
class Observation:
    """An odometry message as the policy has it."""

    step: int  # physics steps of the trial before it
    state: Reals  # (13,): position in W [m], rotation w x y z, velocity [m/s], rates [rad/s] in B
    came: float  # time.perf_counter() [s]


Act = Callable[[int, Observation], Reals]  # wrench of an action: force [N], moment [N m], in W


def step_of(time: float) -> int:
    """Physics steps before a time of the simulation [s]."""
    return round(time / DT)


def open_loop() -> Act:
    """The same 200 wrenches in each trial, whatever is observed."""
    random = np.random.default_rng(7)
    noise = random.normal(size=(WRENCHES, 6)) * [1.0, 1.0, 1.0, 0.002, 0.002, 0.002]
    swing = 2.0 * np.sin(np.arange(WRENCHES) * PERIOD * 2.0 * np.pi)
    wrenches = noise
    wrenches[:, 0] += swing
    wrenches[:, 2] += WEIGHT
    return lambda action, _: wrenches[action]


def turned(rotation: Reals, vector: Reals) -> Reals:
    """A vector of B in W; rotation: w x y z."""
    w, axis = rotation[0], rotation[1:]
    return np.asarray(
        vector + 2.0 * np.cross(axis, np.cross(axis, vector) + w * vector), np.float64
    )


def closed_loop() -> Act:
    """Flies 1 m aside and up from where the trial begins, by a law of position and attitude."""
    goal: list[Reals] = []

    def act(action: int, seen: Observation) -> Reals:
        position, rotation = seen.state[:3], seen.state[3:7]
        if action == 0:
            goal[:] = [position + ASIDE]
        velocity, rates = (turned(rotation, part) for part in np.split(seen.state[7:], 2))
        force = 25.0 * (goal[0] - position) - 10.0 * velocity + [0.0, 0.0, WEIGHT]
        moment = -1.0 * np.sign(rotation[0]) * rotation[1:] - 0.2 * rates
        return np.concatenate([force, moment])

    return act


ACTS: dict[str, Callable[[], Act]] = {"open": open_loop, "closed": closed_loop}
