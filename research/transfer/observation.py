"""The rows of task `trajectory` for many vehicles, from their motion and references.

Built from the columns of tasks/trajectory/README.md: 20 past entries of height, velocity, attitude,
rates and actions, newest first, and 20 moments of the path, 10 ms apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from research.transfer.references import Figures

Reals = NDArray[np.float64]
HISTORY, WINDOW, SPACING = 20, 20, 0.01


@dataclass
class Motion:
    """N vehicles."""

    position: Reals  # of the base's origin, W (N, 3) [m]
    velocity: Reals  # W (N, 3) [m/s]
    attitude: Reals  # W from B (N, 3, 3)
    rates: Reals  # B (N, 3) [rad/s]


class Rows:
    """Rows of N vehicles, with their histories."""

    def __init__(self, figures: Figures, actions: int) -> None:
        self.figures = figures
        self.past: list[list[Reals]] = []  # newest first: height, velocity, attitude, rates, action
        self.action = np.full((len(figures), actions), -1.0)

    def row(self, time: float, motion: Motion) -> Reals:
        """The observation at a time since the reset [s], (N, 680) or (N, 700).

        Args:
            motion: now; `self.action` is the action that led to it.
        """
        count = len(self.figures)
        entry = [
            motion.position[:, 2:],
            motion.velocity,
            motion.attitude.reshape(count, 9),
            motion.rates,
            self.action,
        ]
        entry = [part.copy() for part in entry]
        self.past = [entry, *self.past[: HISTORY - 1]] if self.past else [entry] * HISTORY
        history = [np.hstack([moment[k] for moment in self.past]) for k in range(len(entry))]
        path = self.figures.ahead(time + SPACING * np.arange(WINDOW))
        errors = [path[0] - motion.position[:, None], path[1] - motion.velocity[:, None], path[2]]
        return np.hstack([*history, *(part.reshape(count, -1) for part in errors)])
