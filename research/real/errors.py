"""Errors of predicted states, and their intervals by blocks of flights."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from research.real.recorded_flights import Reals

QUANTITIES = ("position", "attitude", "velocity", "rates")
UNITS = {"position": "cm", "attitude": "deg", "velocity": "m/s", "rates": "rad/s"}
DRAWS, SEED = 1000, 1
BLOCK = 20  # windows in a row that are drawn together


def errors(predicted: Reals, recorded: Reals) -> Reals:
    """Errors of states, (..., 13) each: in the order and units of QUANTITIES, (..., 4)."""
    turn = np.abs((predicted[..., 3:7] * recorded[..., 3:7]).sum(axis=-1)).clip(max=1.0)
    parts = [
        100.0 * np.linalg.norm(predicted[..., :3] - recorded[..., :3], axis=-1),
        np.degrees(2.0 * np.arccos(turn)),
        np.linalg.norm(predicted[..., 7:10] - recorded[..., 7:10], axis=-1),
        np.linalg.norm(predicted[..., 10:] - recorded[..., 10:], axis=-1),
    ]
    return np.stack(parts, axis=-1)


@dataclass(frozen=True)
class Figure:
    """A figure of all windows with its 95 % interval."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        digits = 1 if self.value >= 9.95 else 2
        return f"{self.value:.{digits}f} ({self.low:.{digits}f} to {self.high:.{digits}f})"


def figures(flights: Sequence[Reals], of: Callable[..., Reals]) -> Reals:
    """Figures of the windows of all flights with their intervals, (3, ...): value, low, high.

    The interval is the percentiles of draws of flights with replacement, and in each flight of
    blocks of BLOCK consecutive windows.

    Args:
        flights: values of the windows of each flight, in their order, (windows, ...).
        of: such as np.median, with `axis`.
    """
    random = np.random.default_rng(SEED)
    drawn = [of(drawn_windows(flights, random), axis=0) for _ in range(DRAWS)]
    low, high = np.percentile(drawn, [2.5, 97.5], axis=0)
    return np.stack([of(np.concatenate(flights), axis=0), low, high])


def drawn_windows(flights: Sequence[Reals], random: np.random.Generator) -> Reals:
    """Values of drawn blocks of drawn flights."""
    parts: list[Reals] = []
    for k in random.integers(len(flights), size=len(flights)):
        values = flights[k]
        first = np.arange(0, len(values), BLOCK)
        parts += [values[b : b + BLOCK] for b in random.choice(first, size=len(first))]
    return np.concatenate(parts)
