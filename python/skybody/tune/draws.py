"""What is drawn for a flight: masses, rotors, lags and wind."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skybody._native import CompiledScenario

from .vehicle import ROBOT


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
    values: NDArray[np.float64]
    """(draws, paths)"""

    def __len__(self) -> int:
        return len(self.values)


def nominal(compiled: CompiledScenario, paths: list[str]) -> NDArray[np.float64]:
    return np.array([compiled.param_info(path)[0] for path in paths])


def make_draws(
    compiled: CompiledScenario, count: int, generator: np.random.Generator, ranges: DrawRanges
) -> Draws:
    """`count` vehicles, the first of them the nominal one in still air.

    Each quantity is spread over its range by Latin hypercube sampling (McKay, Beckman, Conover
    1979): few draws then cover it all.
    """
    paths = [path for path in compiled.param_paths if _kind(path)]
    values = np.tile(nominal(compiled, paths), (count, 1))
    spread = {
        kind: 2.0 * _latin(generator, count) - 1.0
        for kind in ("mass", "inertia", "thrust", "lag", "speed", "side")
    }
    for column, path in enumerate(paths):
        kind = _kind(path)
        low, high = compiled.param_info(path)[1:3]
        if kind.startswith("wind"):
            speed = 0.5 * (spread["speed"] + 1.0) * ranges.wind
            side = np.pi * spread["side"]
            drawn = speed * (np.cos(side) if kind == "wind_x" else np.sin(side))
        else:
            drawn = values[:, column] * _factor(kind, spread, ranges)
        drawn[0] = values[0, column]
        values[:, column] = np.clip(drawn, low, high)
    return Draws(paths, values)


MARGIN = 2.0  # 6 dB: the usual demand on a loop


def with_margin_flights(draws: Draws) -> Draws:
    """The same and two more: the first of them with half and with twice its inertia.

    Torques then do twice and half of what the controllers expect of them. Gains that bear both have
    a gain margin of 6 dB up and down.
    """
    rows = np.tile(draws.values[0], (2, 1))
    turning = [column for column, path in enumerate(draws.paths) if _kind(path) == "inertia"]
    rows[0, turning] /= MARGIN
    rows[1, turning] *= MARGIN
    return Draws(draws.paths, np.vstack([draws.values, rows]))


def _latin(generator: np.random.Generator, count: int) -> NDArray[np.float64]:
    """One value in each of `count` equal parts of [0, 1), in random order."""
    return (generator.permutation(count) + generator.random(count)) / count


def _factor(
    kind: str, spread: dict[str, NDArray[np.float64]], ranges: DrawRanges
) -> NDArray[np.float64]:
    mass = 1.0 + ranges.mass * spread["mass"]
    if kind == "mass":
        return mass
    if kind == "inertia":
        return mass * (1.0 + ranges.inertia * spread["inertia"])
    if kind == "lag":
        return 1.0 + ranges.lag * spread["lag"]
    return 1.0 + ranges.thrust * spread["thrust"]


def _kind(path: str) -> str:
    """What a path is drawn as; "" for what is not drawn."""
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
