"""Prediction errors of open-loop replays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skybody.look.flight import Array

from .replay import SAMPLE, Prediction
from .residuals import KINDS, differences
from .windows import Measured, Windows

TIMES = (0.1, 0.5)  # after the start of a window [s]
UNITS = {"position": "m", "attitude": "rad", "rate": "rad/s"}


@dataclass(frozen=True)
class Errors:
    """Lengths of the errors of n windows, (n, samples) by kind; NaN: not measured."""

    of: dict[str, Array]

    def at(self, kind: str, time: float) -> Array:
        """Errors of all windows at a time [s]; empty if not measured."""
        column = self.of[kind][:, round(time / SAMPLE) - 1]
        return np.asarray(column[np.isfinite(column)])

    def mean(self, kind: str, time: float) -> float | None:
        """Mean error; None: not measured."""
        found = self.at(kind, time)
        return float(found.mean()) if len(found) else None

    def curve(self, kind: str) -> Array:
        """Means by sample."""
        rows = self.of[kind]
        rows = rows[np.isfinite(rows).all(axis=1)]
        return np.asarray(rows.mean(axis=0)) if len(rows) else np.full(rows.shape[1], np.nan)


def errors_of(found: tuple[Prediction, Measured], windows: Windows) -> Errors:
    """Errors of predicted against measured motion."""
    rows = differences(*found, windows).reshape(len(windows), -1, 4, 3)
    lengths = np.linalg.norm(rows, axis=3)
    made = {kind: lengths[:, :, k] for k, kind in enumerate(KINDS)}
    made["position"] = np.where(windows.has_pose[:, None], made["position"], np.nan)
    made["force"] = np.where(windows.has_force[:, None], made["force"], np.nan)
    return Errors(made)
