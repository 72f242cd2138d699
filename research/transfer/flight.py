"""Flights along references in any engine: policy at 100 Hz, rotors' commands at every step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from research.transfer.conditions import Condition, Truth
from research.transfer.estimator import Estimator
from research.transfer.observation import Motion, Rows
from research.transfer.quadrotor import GRAVITY, Quadrotor
from research.transfer.references import Figures

Reals = NDArray[np.float64]
DT, REPEAT = 0.002, 5  # a physics step [s], steps of an action
SETTLE = 3.0  # errors count from here on [s]
START_WITHIN = np.array([0.5, 0.5, 0.25])  # of the path's beginning [m]
SIDE_FORCE = 9.0  # of an action of 1 [N]
BOX, FLOOR = 9.0, 0.05  # a flight has failed beyond [m], below [m]


class Engine(Protocol):
    """N vehicles."""

    name: str
    motion: Motion

    def start(self, position: Reals) -> None: ...
    def step(self, commands: Reals, wind: Reals) -> None: ...
    def inner_loop(self, force: Reals, attitude: Reals, rates: Reals) -> Reals: ...
    def close(self) -> None: ...


@dataclass(frozen=True)
class Form:
    """A policy's interface."""

    name: str
    actions: int

    def thrust(self, quad: Quadrotor, command: Reals, attitude: Reals) -> Reals:
        """Commanded thrust per mass, by nominal constants (N) [m/s^2]."""
        if self.actions == 4:
            return np.asarray(quad.thrust * (command**2).sum(axis=1) / quad.mass)
        return np.asarray((command * attitude[:, :, 2]).sum(axis=1) / quad.mass)

    def command(self, quad: Quadrotor, action: Reals) -> Reals:
        """Rotor speeds (N, 4) [rad/s], or the rotors' force, W (N, 3) [N]."""
        if self.actions == 4:
            return 0.5 * (action + 1.0) * quad.max_speed
        weight = quad.mass * GRAVITY
        return action * [SIDE_FORCE, SIDE_FORCE, weight] + [0.0, 0.0, weight]


FORMS = {form.name: form for form in (Form("rotor_speed", 4), Form("modular", 3))}


@dataclass(frozen=True)
class Flights:
    """Paths of N flights, at each action: (N, M, 3) [m], and failures (N)."""

    flown: Reals
    wanted: Reals
    failed: NDArray[np.bool_]

    def errors(self, settle: float = SETTLE) -> Reals:
        """Distances after `settle` seconds (N, M') [m]."""
        rows = slice(round(settle / (DT * REPEAT)), None)
        return np.asarray(np.linalg.norm(self.flown - self.wanted, axis=2)[:, rows])


def starts(figures: Figures, seed: int) -> Reals:
    """Positions near the beginning of each path (N, 3) [m]."""
    random = np.random.default_rng([seed, 2])
    begin = figures.begin()
    return np.asarray(begin + START_WITHIN * random.uniform(-1.0, 1.0, begin.shape))


def fly(
    engine: Engine,
    quad: Quadrotor,
    policy: Callable[[Reals], Reals],
    form: Form,
    figures: Figures,
    truth: Truth,
    condition: Condition,
    seconds: float,
    seed: int = 0,
) -> Flights:
    """Flies all figures at once."""
    engine.start(starts(figures, seed))
    estimator = Estimator(condition, engine.motion, DT, seed)
    rows = Rows(figures, form.actions)
    flown = []
    command: Any = None
    thrust = np.full(len(figures), GRAVITY)
    for k in range(round(seconds / DT)):
        time = k * DT
        estimator.update(time, engine.motion)
        if k % REPEAT == 0:
            flown.append(engine.motion.position.copy())
            rows.action = policy(rows.row(time, estimator.estimate(time, thrust)))
            command = form.command(quad, rows.action)
            thrust = form.thrust(quad, command, estimator.attitude()[0])
        speeds = command
        if form.actions == 3:
            known = estimator.attitude()
            speeds = engine.inner_loop(command, *known)
        engine.step(speeds, truth.air(time))
    path = np.stack(flown, 1)
    wanted = figures.at(DT * REPEAT * np.arange(path.shape[1]))[0]
    inside = (np.abs(path[:, :, :2]).max(axis=2) < BOX) & (path[:, :, 2] > FLOOR)
    return Flights(path, wanted, ~inside.all(axis=1))
