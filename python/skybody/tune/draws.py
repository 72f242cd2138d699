"""Random draws of a flight: masses, rotors, lags and wind."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skybody._native import CompiledScenario

from .vehicle import ROBOT, TuneError

Rows = NDArray[np.float64]

LEAST_LIFT = 1.15  # thrust of all rotors over weight: with less a vehicle cannot steer


@dataclass(frozen=True)
class DrawRanges:
    """Ranges of the draws about the nominal vehicle."""

    mass: float = 0.2
    """Relative range of the base's mass; its inertia scales with it."""
    inertia: float = 0.15
    """Additional relative range of the inertia."""
    thrust: float = 0.08
    """Relative range of the rotors' thrust and moment constants: batteries, propellers."""
    lag: float = 0.25
    """Relative range of the rotors' time constants."""
    wind: float = 3.0
    """Largest speed of the steady wind, from any direction [m/s]."""


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
    1979), so that few draws cover the whole range.
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


MARGIN = 2.0  # 6 dB: the usual requirement

# Powers of the factors that scale a loop's gain. TURNING: torques turn the body more.
# MOVING: thrusts accelerate it more, while hover needs the same commands (gravity) and turning is
# unchanged (inertia).
TURNING = {"inertia": -1}
MOVING = {"thrust": 1, "inertia": 1, "gravity": 1}


def scaled(paths: list[str], values: Rows, loop: dict[str, int], factor: float) -> Rows:
    """Values (paths,) of a vehicle whose loop TURNING or MOVING has `factor` times the gain."""
    powers = np.array([loop.get(_kind(path), 0) for path in paths])
    return np.asarray(values * factor**powers)


def with_margin_flights(draws: Draws) -> Draws:
    """Adds four flights to `draws`: the first one with half and twice the gain of each loop.

    Gains that fly all of them have gain margins of 6 dB up and down.
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
    """Factors on nominal values, by kind. The mass is limited so that rotors can still steer."""
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
    """Thrust of all rotors at their largest speeds, divided by the weight of the vehicle."""

    def values(end: str) -> Rows:
        prefix = f"robots.{ROBOT}."
        paths = [p for p in compiled.param_paths if p.startswith(prefix) and p.endswith(end)]
        return nominal(compiled, paths)

    thrust = np.sum(values(".thrust_constant") * values(".max_speed") ** 2)
    weight = np.sum(values(".mass")) * np.linalg.norm(compiled.gravity)
    return float(thrust / weight)


def margin_paths(compiled: CompiledScenario) -> list[str]:
    """The paths that `scaled` multiplies."""
    return [path for path in compiled.param_paths if _kind(path) in {*TURNING, *MOVING}]


def _kind(path: str) -> str:
    """The kind of draw of a path; "" if it is not drawn. `gravity` is changed for margins only."""
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
