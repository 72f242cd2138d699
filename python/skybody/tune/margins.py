"""How far from trouble a tuned vehicle is: by simulation, with its rotors, limits and lags."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skybody.pool import Pool

from .commands import STEP_TIME, WAIT, Program, make_program, normalized
from .gains import Gains
from .vehicle import COMMAND_PERIOD, ROBOT, Vehicle

Rows = NDArray[np.float64]

MOST_GAIN = 32.0
GAIN_STEPS = 64
MOST_DELAY = 0.32  # [s]
DELAY_STEP = 0.001  # [s]
SMALL = 0.2  # of the step that the tuning flies: margins are about small motions
REST = 0.05  # [rad/s] RMS of rates in the last second of a vehicle that has come to rest
LAST = 1.0  # [s]


@dataclass(frozen=True)
class Margins:
    """What the chain bears until a small step no longer dies out.

    At a level whose step does not end at rest (`attitude`, `ctbr`) they are about its rates alone.
    """

    gain_up: float
    """Factor on the torque that the rotors' commands give; inf: more than 32."""
    gain_down: float
    """The same, below 1; 0: less than 1/32."""
    delay: float
    """More of it between controller and rotors [s]; inf: more than 0.32 s."""


def margins_of(vehicle: Vehicle, gains: Gains, point: Rows) -> Margins:
    """Of the nominal vehicle in still air, beyond the latency that it has."""
    values = gains.values(point)
    factors = np.exp(np.linspace(0.0, np.log(MOST_GAIN), GAIN_STEPS))
    up = _come_to_rest(vehicle, gains.paths, values, factors)
    down = _come_to_rest(vehicle, gains.paths, values, 1.0 / factors)
    delay = _first_failure(
        lambda more: bool(
            _come_to_rest(
                vehicle, gains.paths, values, np.ones(1), vehicle.latency + more * DELAY_STEP
            )[0]
        ),
        round(MOST_DELAY / DELAY_STEP),
    )
    return Margins(
        gain_up=float(_first(factors, up, np.inf)),
        gain_down=float(_first(1.0 / factors, down, 0.0)),
        delay=np.inf if delay is None else delay * DELAY_STEP,
    )


def _first(factors: Rows, rests: NDArray[np.bool_], otherwise: float) -> float:
    """The first factor at which it does not come to rest."""
    failed = np.flatnonzero(~rests)
    return otherwise if failed.size == 0 else float(factors[failed[0]])


def _first_failure(rests: Callable[[int], bool], most: int) -> int | None:
    """The least number that fails, by bisection; None: `most` does not."""
    if rests(most):
        return None
    low, high = -1, most
    while high - low > 1:
        middle = (low + high) // 2
        if rests(middle):
            low = middle
        else:
            high = middle
    return high


def _come_to_rest(
    vehicle: Vehicle, paths: list[str], values: Rows, factors: Rows, latency: float | None = None
) -> NDArray[np.bool_]:
    """Whether vehicles whose torques are so many times the nominal ones rest after a small step."""
    compiled = vehicle.compile(latency)
    program = make_program(compiled)
    inertias = [
        path
        for path in compiled.param_paths
        if re.fullmatch(rf"robots\.{ROBOT}\.links\..+\.inertia\[\d\]", path)
    ]
    nominal = np.array([compiled.param_info(path)[0] for path in inertias])
    with Pool(compiled, len(factors), infos=False) as pool:
        pool.reset()
        for env, factor in enumerate(factors):
            for path, value in zip(paths, values, strict=True):
                pool.set_param(env, path, float(value))
            for path, value in zip(inertias, nominal, strict=True):
                pool.set_param(env, path, float(value / factor))
        return _rests(pool, normalized(compiled, _small_step(program)))


def _small_step(program: Program) -> Rows:
    """The commands with a step of a fifth of the size, and nothing behind it."""
    before = program.commands[program.step_begin - 1]
    after = program.commands[program.step_begin]
    count = round((WAIT + STEP_TIME + LAST) / COMMAND_PERIOD)
    stepped = np.arange(count) >= program.step_begin
    commands: Rows = before + np.where(stepped[:, None], SMALL * (after - before), 0.0)
    if program.level == "attitude":  # the mean of two attitudes is none yet
        commands[:, 1:5] /= np.linalg.norm(commands[:, 1:5], axis=1)[:, None]
    if program.level in ("ctbr", "velocity_tracking"):  # a pulse, so that it can come to rest
        commands[program.step_begin + round(0.5 / COMMAND_PERIOD) :] = before
    return commands


def _rests(pool: Pool, actions: NDArray[np.float32]) -> NDArray[np.bool_]:
    lost = np.zeros(pool.num_envs, bool)
    last = round(LAST / COMMAND_PERIOD)
    rates = []
    for k, action in enumerate(actions):
        *_, info = pool.step(np.tile(action, (pool.num_envs, 1)))
        lost |= info["fault"]
        if k >= len(actions) - last:
            rates.append(pool.state(f"robots.{ROBOT}.base.angular_velocity"))
    shaking = np.sqrt(np.mean(np.square(rates), axis=(0, 2)))
    return np.asarray(~lost & (shaking < REST))
