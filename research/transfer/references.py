"""Nine Lissajous figures like those of the GzDRL paper's flights, drawn by a seed.

A figure is p = centre + amplitude sin(cycles a + phase), where the angle a starts at rest and
reaches in `RAMP` seconds the rate of the figure's peak speed. The heading is zero.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from research.transfer.quadrotor import GRAVITY
from research.transfer.rotation import matrix, tilted

Reals = NDArray[np.float64]
SEED, COUNT = 2026, 9
TRIAL_COUNT = 2  # figures of a trial
RAMP = 2.0  # [s]
RATIOS = ((1, 1, 1), (2, 2, 1), (1, 1, 2), (2, 1, 1), (1, 2, 1))
PEAK_SPEED = (0.41, 1.03)  # of the paper's nine flights, 0.72 m/s on average [m/s]


@dataclass(frozen=True)
class Figures:
    """Numbers of N figures: (N, 3), except `peak` (N) [m/s]."""

    centre: Reals  # [m]
    amplitude: Reals  # [m]
    cycles: Reals
    phase: Reals  # [rad]
    peak: Reals

    def __len__(self) -> int:
        return len(self.peak)

    def repeated(self, times: int) -> Figures:
        """All figures, `times` times."""
        parts = (getattr(self, field.name) for field in fields(self))
        return Figures(*(np.concatenate([part] * times) for part in parts))

    @functools.cached_property
    def rate(self) -> Reals:
        """Rate of the angle at full pace (N) [rad/s]."""
        angle = 2.0 * np.pi * np.arange(256)[:, None, None] / 256
        speed = self.amplitude * self.cycles * np.cos(self.cycles * angle + self.phase)
        return np.asarray(self.peak / np.linalg.norm(speed, axis=-1).max(axis=0))

    def begin(self) -> Reals:
        """Positions at time 0 (N, 3) [m]."""
        return self.at(np.zeros(1))[0][:, 0]

    def at(self, time: Reals) -> tuple[Reals, Reals, Reals]:
        """Position, velocity and acceleration, W, at M times: each (N, M, 3)."""
        rate = self.rate[:, None]
        s, pace, change = (rate * part for part in path_time(time))
        inner = self.cycles[:, None] * s[..., None] + self.phase[:, None]
        sine, cosine = (self.amplitude[:, None] * f(inner) for f in (np.sin, np.cos))
        slope = self.cycles[:, None] * pace[..., None]
        bend = self.cycles[:, None] * change[..., None]
        return self.centre[:, None] + sine, cosine * slope, cosine * bend - sine * slope**2

    def ahead(self, time: Reals) -> tuple[Reals, Reals, Reals]:
        """Position, velocity (N, M, 3) and attitude (N, M, 3, 3) of a vehicle on the path."""
        position, velocity, acceleration = self.at(time)
        push = acceleration + np.array([0.0, 0.0, GRAVITY])
        up = push / np.linalg.norm(push, axis=-1, keepdims=True)
        return position, velocity, matrix(tilted(up, np.zeros(up.shape[:-1])))


def path_time(time: Reals) -> tuple[Reals, Reals, Reals]:
    """Path time [s], its pace, and the pace's rate [1/s]; the pace rises from 0 to 1."""
    x = np.minimum(time / RAMP, 1.0)
    s = RAMP * (7 * x**5 - 14 * x**6 + 10 * x**7 - 2.5 * x**8) + np.maximum(time - RAMP, 0.0)
    pace = 35 * x**4 - 84 * x**5 + 70 * x**6 - 20 * x**7
    return s, pace, (140 * x**3 - 420 * x**4 + 420 * x**5 - 140 * x**6) / RAMP


def draw(count: int = COUNT, seed: int = SEED) -> Figures:
    """The references: sizes, heights, ratios and phases of the paper's public code."""
    random = np.random.default_rng(seed)
    side = random.uniform(1.35, 1.75, (count, 2))
    up = random.uniform(0.3, 0.4, (count, 1))
    nothing = np.zeros((count, 2))
    phase = np.radians(random.uniform(70.0, 110.0, (count, 1)))
    return Figures(
        centre=np.hstack([nothing, random.uniform(0.7, 1.0, (count, 1))]),
        amplitude=np.hstack([side, up]),
        cycles=np.array(RATIOS, float)[np.arange(count) % len(RATIOS)],
        phase=np.hstack([phase, nothing]),
        peak=random.uniform(*PEAK_SPEED, count),
    )
