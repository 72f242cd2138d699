"""Stability margins of a tuned vehicle, by simulation with its rotors, limits and lags."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skybody._native import CompiledScenario
from skybody.pool import Pool

from .commands import STEP_TIME, WAIT, Program, make_program, normalized
from .draws import MOVING, TURNING, margin_paths, nominal, scaled
from .gains import Gains
from .vehicle import COMMAND_PERIOD, ROBOT, Vehicle

Rows = NDArray[np.float64]

MOST_GAIN = 32.0
GAIN_STEPS = 64
MOST_DELAY = 0.32  # [s]
DELAY_STEP = 0.001  # [s]
SMALL = 0.2  # of the step in tuning: margins are about small motions
REST = 0.05  # [rad/s] limit of the RMS rates in the last second of a vehicle at rest
LAST = 1.0  # [s]


@dataclass(frozen=True)
class GainMargin:
    """Factors on a loop's gain at which a small step no longer decays."""

    up: float
    """Above 1; inf: more than 32."""
    down: float
    """Below 1; 0: less than 1/32."""


@dataclass(frozen=True)
class Margins:
    """Margins of the chain.

    At a level whose step does not end at rest (`attitude`, `ctbr`) they are about its rates only.
    """

    turning: GainMargin
    """Of the torques due to the rotors' commands."""
    moving: GainMargin
    """Of the accelerations due to thrusts, with hover and turning unchanged."""
    delay: float
    """Additional delay between controller and rotors [s]; inf: more than 0.32 s."""


def margins_of(vehicle: Vehicle, gains: Gains, point: Rows) -> Margins:
    """Margins of the nominal vehicle in still air, beyond its own latency."""
    values = gains.values(point)
    delay = _first_failure(
        lambda more: _bears_delay(vehicle, gains, values, more * DELAY_STEP),
        round(MOST_DELAY / DELAY_STEP),
    )
    return Margins(
        turning=_gain_margin(vehicle, gains, values, TURNING),
        moving=_gain_margin(vehicle, gains, values, MOVING),
        delay=np.inf if delay is None else delay * DELAY_STEP,
    )


def _gain_margin(vehicle: Vehicle, gains: Gains, values: Rows, loop: dict[str, int]) -> GainMargin:
    factors = np.exp(np.linspace(0.0, np.log(MOST_GAIN), GAIN_STEPS))
    both = np.concatenate([factors, 1.0 / factors])
    rests = _come_to_rest(vehicle.compile(), gains.paths, values, loop, both)
    return GainMargin(
        up=_first(factors, rests[:GAIN_STEPS], np.inf),
        down=_first(1.0 / factors, rests[GAIN_STEPS:], 0.0),
    )


def _bears_delay(vehicle: Vehicle, gains: Gains, values: Rows, more: float) -> bool:
    compiled = vehicle.compile(vehicle.latency + more)
    return bool(_come_to_rest(compiled, gains.paths, values, TURNING, np.ones(1))[0])


def _first(factors: Rows, rests: NDArray[np.bool_], otherwise: float) -> float:
    """The first factor at which the vehicle does not come to rest."""
    failed = np.flatnonzero(~rests)
    return otherwise if failed.size == 0 else float(factors[failed[0]])


def _first_failure(rests: Callable[[int], bool], most: int) -> int | None:
    """The smallest number that fails, by bisection; None: `most` does not fail."""
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
    compiled: CompiledScenario,
    paths: list[str],
    values: Rows,
    loop: dict[str, int],
    factors: Rows,
) -> NDArray[np.bool_]:
    """Whether vehicles with `factors` times the gain of a loop come to rest after a small step."""
    program = make_program(compiled)
    changed = margin_paths(compiled)
    nominal_values = nominal(compiled, changed)
    with Pool(compiled, len(factors), infos=False) as pool:
        pool.reset()
        for env, factor in enumerate(factors):
            of_vehicle = scaled(changed, nominal_values, loop, float(factor))
            for path, value in zip(
                [*paths, *changed], np.concatenate([values, of_vehicle]), strict=True
            ):
                pool.set_param(env, path, float(value))
        return _rests(pool, normalized(compiled, _small_step(program)))


def _small_step(program: Program) -> Rows:
    """The commands with a step of a fifth of the size, constant afterwards."""
    before = program.commands[program.step_begin - 1]
    after = program.commands[program.step_begin]
    count = round((WAIT + STEP_TIME + LAST) / COMMAND_PERIOD)
    stepped = np.arange(count) >= program.step_begin
    commands: Rows = before + np.where(stepped[:, None], SMALL * (after - before), 0.0)
    if program.level == "attitude":  # the mean of two attitudes is not normalized
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
