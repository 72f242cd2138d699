"""A recorded flight, as the identification takes it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skybody.imports.channels import Samples
from skybody.look.flight import Array

Rows = NDArray[np.int64]  # indices
Mask = NDArray[np.bool_]
SHARE, SPEED = "share", "speed"  # kinds of commands


@dataclass(frozen=True)
class CommandLaw:
    """Speeds of rotors by the commands of a log, as its map has it for the nominal vehicle."""

    kind: str
    """`share`: commands are parts of a range, such as PWM; `speed`: they are rotor speeds."""
    low: float = 0.0
    high: float = 1.0
    """Ends of the range, in the unit of the log."""
    shares: Array = field(default_factory=lambda: np.zeros(0))
    speeds: Array = field(default_factory=lambda: np.zeros(0))
    """Nominal speeds [rad/s] at shares."""

    def nominal(self, share: Array) -> Array:
        """Nominal speeds [rad/s]."""
        return np.interp(share, self.shares, self.speeds)


@dataclass(frozen=True)
class Record:
    """Values of one flight, W east-north-up and B forward-left-up; each with its own times [s]."""

    path: Path
    law: CommandLaw
    command: Samples
    """(n, rotors), in the order of the model: shares in 0 ... 1, or rotor speeds [rad/s]."""
    voltage: Samples | None = None
    """(n, 1) [V]"""
    position: Samples | None = None
    """(n, 3), W [m]"""
    quaternion: Samples | None = None
    """(n, 4), w x y z, W from B"""
    velocity: Samples | None = None
    """(n, 3), W [m/s]"""
    gyro: Samples | None = None
    """(n, 3), B [rad/s]"""
    force: Samples | None = None
    """(n, 3), specific force by the accelerometer, B [m/s^2]"""
    bad: tuple[tuple[float, float, str], ...] = ()
    """Stretches that are not used: begin, end [s], and the reason."""

    @property
    def name(self) -> str:
        """Name of the flight."""
        return self.path.name.partition(".")[0]

    @property
    def has_pose(self) -> bool:
        """Whether position and attitude were recorded."""
        return self.position is not None

    def span(self) -> tuple[float, float]:
        """Times in which all values are known [s]."""
        known = [s for s in (self.command, self.position, self.gyro, self.force) if s is not None]
        return max(float(s.time[0]) for s in known), min(float(s.time[-1]) for s in known)

    def without(self, more: list[tuple[float, float, str]]) -> Record:
        """The same with further stretches that are not used."""
        return replace(self, bad=(*self.bad, *more))


class Mean:
    """Means of samples over intervals of time, linear between the samples, or held."""

    def __init__(self, samples: Samples, *, held: bool = False) -> None:
        steps = np.diff(samples.time)[:, None]
        ends = samples.values[:-1] if held else samples.values[1:]
        areas = 0.5 * steps * (ends + samples.values[:-1])
        self._held = held
        self._time, self._values = samples.time, samples.values
        self._sums = np.concatenate([np.zeros((1, areas.shape[1])), np.cumsum(areas, axis=0)])

    def __call__(self, begin: Array, length: float) -> Array:
        """Means over [begin, begin + length] with begin of any shape; (..., columns)."""
        return np.asarray((self._sum(begin + length) - self._sum(begin)) / length)

    def at(self, times: Array) -> Array:
        """Values at times of any shape; (..., columns)."""
        rows, part = self._places(times)
        return np.asarray((1.0 - part) * self._values[rows] + part * self._values[rows + 1])

    def _places(self, times: Array) -> tuple[Rows, Array]:
        times = np.clip(times, self._time[0], self._time[-1])
        rows = np.clip(np.searchsorted(self._time, times, side="right") - 1, 0, len(self._time) - 2)
        steps = self._time[rows + 1] - self._time[rows]
        return rows, ((times - self._time[rows]) / steps)[..., None]

    def _sum(self, times: Array) -> Array:
        rows, part = self._places(times)
        first, last = self._values[rows], self._values[rows + 1]
        step = (self._time[rows + 1] - self._time[rows])[..., None]
        rise = 0.0 if self._held else 0.5 * part * (last - first)
        inside = step * part * (first + rise)
        return np.asarray(self._sums[rows] + inside)
