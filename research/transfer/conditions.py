"""Conditions that a policy does not know: errors of the model, sensors, delay, wind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from research.transfer import quadrotor

Reals = NDArray[np.float64]


@dataclass(frozen=True)
class Condition:
    """Sizes of everything that is drawn, the same for all flights."""

    errors: float = 0.0  # largest relative error of mass, inertia, thrust and lag
    unequal: float = 0.0  # largest relative difference of a rotor from the four's error
    wind: float = 0.0  # steady, level [m/s]
    gust: float = 0.0  # peak of a gust [m/s]
    delay: float = 0.0  # from exposure of a pose to its use [s]
    position_noise: float = 0.0  # standard deviation of each axis [m]
    attitude_noise: float = 0.0  # likewise [rad]
    rate_noise: float = 0.0  # of a sample of the gyroscope [rad/s]
    rate_bias: float = 0.0  # largest bias of it [rad/s]
    filtered: bool = True  # estimates from measurements; false: the engine's own motion


PLAIN = Condition(filtered=False)
HIDDEN = Condition(
    errors=0.1,
    unequal=0.02,
    wind=2.0,
    gust=2.0,
    delay=0.015,
    position_noise=0.001,
    attitude_noise=0.005,
    rate_noise=0.02,
    rate_bias=0.01,
)
GUST_EVERY, GUST_LASTS = 5.0, 1.0  # [s]


@dataclass(frozen=True)
class Truth:
    """Factors of the true constants of N vehicles, and their wind."""

    mass: Reals  # (N)
    inertia: Reals  # of each axis (N, 3)
    thrust: Reals  # of each rotor, its moment included (N, 4)
    lag: Reals  # (N)
    wind: Reals  # W (N, 3) [m/s]
    gust: Reals  # W (N, 3), at a gust's peak [m/s]
    first_gust: Reals  # (N) [s]

    def air(self, time: float) -> Reals:
        """Wind at a time since the start, W (N, 3) [m/s]."""
        since = np.mod(time - self.first_gust, GUST_EVERY)
        blows = (time > self.first_gust) & (since < GUST_LASTS)
        share = np.where(blows, 0.5 - 0.5 * np.cos(2.0 * np.pi * since / GUST_LASTS), 0.0)
        return self.wind + share[:, None] * self.gust


def draw(condition: Condition, seeds: list[int], flights: int) -> Truth:
    """Truths of `flights` references for each seed: seed by seed."""
    found = [
        _draw(condition, np.random.default_rng([seed, k])) for seed in seeds for k in range(flights)
    ]
    return Truth(**{name: np.array([one[name] for one in found]) for name in found[0]})


def _draw(condition: Condition, random: np.random.Generator) -> dict[str, Reals]:
    def factors(*shape: int) -> Reals:
        return np.asarray(1.0 + condition.errors * random.uniform(-1.0, 1.0, shape))

    def level(speed: float) -> Reals:
        heading = random.uniform(0.0, 2.0 * np.pi)
        return speed * np.array([np.cos(heading), np.sin(heading), 0.0])

    nominal = quadrotor.read().inertia
    inertia = factors(3)
    while 2.01 * (nominal * inertia).max() > (nominal * inertia).sum():  # hardly a rigid body
        inertia = factors(3)
    return {
        "mass": factors(),
        "inertia": inertia,
        "thrust": factors() * (1.0 + condition.unequal * random.uniform(-1.0, 1.0, 4)),
        "lag": factors(),
        "wind": level(condition.wind),
        "gust": level(condition.gust),
        "first_gust": np.array(random.uniform(0.0, GUST_EVERY)),
    }
