"""What is drawn for a flight: masses, rotors, lags and wind."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skybody._native import CompiledScenario

from .vehicle import ROBOT, TuneError

Rows = NDArray[np.float64]

LEAST_LIFT = 1.15  # thrust of all rotors over weight: a vehicle with less cannot steer


@dataclass(frozen=True)
class DrawRanges:
    """How far draws go from the nominal vehicle."""

    mass: float = 0.2
    """Share of the mass by which the base may be lighter or heavier; its inertia goes along."""
    inertia: float = 0.15
    """The same for the inertia, on top."""
    thrust: float = 0.08
    """Share of the rotors' thrust and moment constants: batteries, propellers."""
    lag: float = 0.25
    """Share of the rotors' time constants."""
    wind: float = 3.0
    """Greatest speed of the steady wind, from any side [m/s]."""


@dataclass(frozen=True)
class Draws:
    """A row of values for each flight."""

    paths: list[str]
    values: Rows
    """(draws, paths)"""

    def __len__(self) -> int:
        return len(self.values)


def nominal(compiled: CompiledScenario, paths: list[str]) -> Rows:
    return np.array([compiled.param_info(path)[0] for path in paths])


def make_draws(
    compiled: CompiledScenario, count: int, generator: np.random.Generator, ranges: DrawRanges
) -> Draws:
    """`count` vehicles, the first of them the nominal one in still air.

    Each quantity is spread over its range by Latin hypercube sampling (McKay, Beckman, Conover
    1979): few draws then cover it all.
    """
    lift = lift_of(compiled)
    if lift < LEAST_LIFT:
        raise TuneError(
            f"the rotors lift {lift:.3g} times the vehicle's weight at their largest speeds; at "
            f"least {LEAST_LIFT:g} are needed to fly and steer: look at masses in the URDF, and at "
            "thrust_constant and max_speed in the rotors file"
        )
    paths = [path for path in compiled.param_paths if _kind(path)]
    values = np.tile(nominal(compiled, paths), (count, 1))
    spread = {
        kind: 2.0 * _latin(generator, count) - 1.0
        for kind in ("mass", "inertia", "thrust", "lag", "speed", "side")
    }
    factors = _factors(spread, ranges, lift)
    for column, path in enumerate(paths):
        kind = _kind(path)
        low, high = compiled.param_info(path)[1:3]
        if kind.startswith("wind"):
            speed = 0.5 * (spread["speed"] + 1.0) * ranges.wind
            side = np.pi * spread["side"]
            drawn = speed * (np.cos(side) if kind == "wind_x" else np.sin(side))
        else:
            drawn = values[:, column] * factors[kind]
        drawn[0] = values[0, column]
        values[:, column] = np.clip(drawn, low, high)
    return Draws(paths, values)


MARGIN = 2.0  # 6 dB: the usual demand on a loop

# What is multiplied so that a loop's gain is: torques turn the body more, or thrusts move it more
# while hover needs the same commands (gravity) and turning stays as it is (inertia).
TURNING = {"inertia": -1}
MOVING = {"thrust": 1, "inertia": 1, "gravity": 1}


def scaled(paths: list[str], values: Rows, loop: dict[str, int], factor: float) -> Rows:
    """Values (paths,) of a vehicle whose loop TURNING or MOVING has `factor` times the gain."""
    powers = np.array([loop.get(_kind(path), 0) for path in paths])
    return np.asarray(values * factor**powers)


def with_margin_flights(draws: Draws) -> Draws:
    """The same and four more: the first with half and twice the gain of each loop.

    Gains that bear all of them have gain margins of 6 dB up and down.
    """
    rows = [
        scaled(draws.paths, draws.values[0], loop, factor)
        for loop in (TURNING, MOVING)
        for factor in (MARGIN, 1.0 / MARGIN)
    ]
    return Draws(draws.paths, np.vstack([draws.values, *rows]))


def _latin(generator: np.random.Generator, count: int) -> Rows:
    """One value in each of `count` equal parts of [0, 1), in random order."""
    return (generator.permutation(count) + generator.random(count)) / count


def _factors(spread: dict[str, Rows], ranges: DrawRanges, lift: float) -> dict[str, Rows]:
    """On nominal values, by kind. No vehicle is heavier than what its rotors can steer with."""
    thrust = 1.0 + ranges.thrust * spread["thrust"]
    heaviest = np.maximum(lift * thrust / LEAST_LIFT, 1.0 - ranges.mass)
    mass = np.minimum(1.0 + ranges.mass * spread["mass"], heaviest)
    return {
        "mass": mass,
        "inertia": mass * (1.0 + ranges.inertia * spread["inertia"]),
        "thrust": thrust,
        "lag": 1.0 + ranges.lag * spread["lag"],
        "gravity": np.ones_like(mass),
    }


def lift_of(compiled: CompiledScenario) -> float:
    """Thrust of all rotors at their largest speeds, in weights of the vehicle."""

    def values(end: str) -> Rows:
        prefix = f"robots.{ROBOT}."
        paths = [p for p in compiled.param_paths if p.startswith(prefix) and p.endswith(end)]
        return nominal(compiled, paths)

    thrust = np.sum(values(".thrust_constant") * values(".max_speed") ** 2)
    weight = np.sum(values(".mass")) * np.linalg.norm(compiled.gravity)
    return float(thrust / weight)


def margin_paths(compiled: CompiledScenario) -> list[str]:
    """Those that `scaled` multiplies."""
    return [path for path in compiled.param_paths if _kind(path) in {*TURNING, *MOVING}]


def _kind(path: str) -> str:
    """What a path is drawn as; "" for what is not drawn. `gravity` stays, but for margins."""
    if path == "gravity[2]":
        return "gravity"
    if path == "effects.wind.velocity[0]":
        return "wind_x"
    if path == "effects.wind.velocity[1]":
        return "wind_y"
    if re.fullmatch(rf"robots\.{ROBOT}\.links\..+\.mass", path):
        return "mass"
    if re.fullmatch(rf"robots\.{ROBOT}\.links\..+\.inertia\[\d\]", path):
        return "inertia"
    if re.fullmatch(rf"robots\.{ROBOT}\.rotors\[\d+\]\.tau_(up|down)", path):
        return "lag"
    if re.fullmatch(rf"robots\.{ROBOT}\.rotors\[\d+\]\.(thrust|moment)_constant", path):
        return "thrust"
    return ""
