"""Motion from delayed poses of a motion capture at 120 Hz, and from a gyroscope.

As users of such systems do it: the velocity is the slope of a line through the latest positions,
brought to the present by the acceleration of attitude and commanded thrust. The attitude is that
of the latest poses, turned on by the gyroscope.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from research.transfer import rotation
from research.transfer.conditions import Condition
from research.transfer.observation import Motion
from research.transfer.quadrotor import GRAVITY

Reals = NDArray[np.float64]
RATE = 120.0  # of poses [Hz]
POINTS = 8  # of the line
FORGET = 0.1  # share of a pose's attitude in the estimate


class Estimator:
    """N vehicles. Times are since the start [s]."""

    def __init__(self, condition: Condition, start: Motion, dt: float, seed: int) -> None:
        self.condition, self.dt = condition, dt
        self.random = np.random.default_rng([seed, 1])
        count = len(start.position)
        self.bias = condition.rate_bias * self.random.uniform(-1.0, 1.0, (count, 3))
        self.exposed = -1  # number of the latest pose
        self.on_the_way: list[tuple[float, Reals, Reals]] = []  # stamp, position, quaternion
        self.times = [-k / RATE for k in range(1, POINTS + 1)]  # newest first
        self.positions = [start.position.copy() for _ in self.times]
        self.quaternion = rotation.of_matrix(start.attitude)
        self.turns: list[tuple[float, Reals]] = []  # end of a period, its turn as a quaternion
        self.rates = np.zeros((count, 3))

    def update(self, time: float, truth: Motion) -> None:
        """Measures; call it every dt, before estimate()."""
        if not self.condition.filtered:
            self.truth = truth
            return
        self._turn(time, truth.rates)
        number = int(np.floor(time * RATE + 1e-9))
        if number > self.exposed:
            self.exposed = number
            self.on_the_way.append((time, *self._pose(truth)))
        while self.on_the_way and time >= self.on_the_way[0][0] + self.condition.delay - 1e-9:
            self._take(*self.on_the_way.pop(0))

    def estimate(self, time: float, thrust: Reals) -> Motion:
        """The motion now.

        Args:
            thrust: commanded, per mass (N) [m/s^2].
        """
        if not self.condition.filtered:
            return self.truth
        times = np.array(self.times)
        middle = times.mean()
        weights = (times - middle) / ((times - middle) ** 2).sum()
        stack = np.array(self.positions)
        attitude = rotation.matrix(self.quaternion)
        push = thrust[:, None] * attitude[:, :, 2] - [0.0, 0.0, GRAVITY]
        age = time - middle
        slope = np.tensordot(weights, stack, 1)
        position = stack.mean(axis=0) + age * slope + 0.5 * age**2 * push
        return Motion(position, slope + age * push, attitude, self.rates)

    def attitude(self) -> tuple[Reals, Reals]:
        """Attitude (N, 3, 3) and rates (N, 3) now: for an attitude loop on board."""
        if not self.condition.filtered:
            return self.truth.attitude, self.truth.rates
        return rotation.matrix(self.quaternion), self.rates

    def _pose(self, truth: Motion) -> tuple[Reals, Reals]:
        count = len(truth.position)
        noise = self.condition.position_noise * self.random.standard_normal((count, 3))
        turn = self.condition.attitude_noise * self.random.standard_normal((count, 3))
        return truth.position + noise, rotation.product(
            rotation.of_matrix(truth.attitude), rotation.of_vector(turn)
        )

    def _turn(self, time: float, rates: Reals) -> None:
        """Turns the attitude on by a sample of the gyroscope."""
        noise = self.condition.rate_noise * self.random.standard_normal(rates.shape)
        self.rates = rates + self.bias + noise
        if time > 0.0:
            turn = rotation.of_vector(self.dt * self.rates)
            self.turns.append((time, turn))
            self.quaternion = rotation.product(self.quaternion, turn)

    def _take(self, stamp: float, position: Reals, quaternion: Reals) -> None:
        """Takes a pose of an earlier time into the estimate of now."""
        self.times = [stamp, *self.times[:-1]]
        self.positions = [position, *self.positions[:-1]]
        self.turns = [turn for turn in self.turns if turn[0] > stamp + 1e-9]
        for _, turn in self.turns:
            quaternion = rotation.product(quaternion, turn)
        sign = np.sign((quaternion * self.quaternion).sum(axis=1, keepdims=True))
        mixed = self.quaternion + FORGET * (sign * quaternion - self.quaternion)
        self.quaternion = mixed / np.linalg.norm(mixed, axis=1, keepdims=True)
