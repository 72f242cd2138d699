"""Open-loop replays in the engine: many windows and many vehicles in one pool."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skybody._native import SimulationPool
from skybody.look.flight import Array

from . import rotation
from .vehicle import DT, Vehicle

STEP = 0.005  # a command is held for this time [s]
WARM = 0.15  # rotors follow the commands for this time before a window begins [s]
SAMPLE = 0.025  # time between samples of a replay [s]
MOST = 6000  # environments of a pool
WARM_STEPS, SAMPLE_STEPS = round(WARM / STEP), round(SAMPLE / STEP)


@dataclass(frozen=True)
class Prediction:
    """Motion of n replays at the samples after their starts."""

    position: Array  # (n, samples, 3), W [m]
    quaternion: Array  # (n, samples, 4), W from B
    rate: Array  # (n, samples, 3), B [rad/s]
    force: Array  # (n, samples, 3): means of the specific force since the last sample, B [m/s^2]


class Replayer:
    """Flies environments with given parameters, starts and commands."""

    def __init__(self, vehicle: Vehicle, threads: int = 0) -> None:
        self._vehicle, self._threads = vehicle, threads
        self._pool: SimulationPool | None = None

    def run(
        self, paths: Sequence[str], values: Array, starts: Array, commands: Array
    ) -> Prediction:
        """Replays.

        Args:
            paths: of the parameters.
            values: (n, paths).
            starts: (n, 13): position, quaternion, velocity (W), angular velocity (B).
            commands: (n, WARM_STEPS + samples SAMPLE_STEPS, rotors): speeds [rad/s], each held
                for STEP. The first ones spin up the rotors before the start.
        """
        parts = [
            self._run(paths, values[k : k + MOST], starts[k : k + MOST], commands[k : k + MOST])
            for k in range(0, len(values), MOST)
        ]
        names = ("position", "quaternion", "rate", "force")
        return Prediction(*(np.concatenate([getattr(p, name) for p in parts]) for name in names))

    def _run(
        self, paths: Sequence[str], values: Array, starts: Array, commands: Array
    ) -> Prediction:
        count, steps = len(values), commands.shape[1]
        pool = self._pool_of(count)
        envs = np.arange(count, dtype=np.int32)
        first = [f"robots.vehicle.start.rotors[{k}].speed" for k in range(commands.shape[2])]
        names = [*paths, *first]
        numbers = np.concatenate([values, np.maximum(commands[:, 0], 0.0)], axis=1).tolist()
        for env, row in enumerate(numbers):
            for path, value in zip(names, row, strict=True):
                pool.set_param(env, path, value)
        pool.reset(envs)
        held = np.ascontiguousarray(np.swapaxes(commands, 0, 1))
        substeps = round(STEP / DT)
        samples = (steps - WARM_STEPS) // SAMPLE_STEPS
        made = np.empty((samples + 1, count, 13))
        for step in range(steps + 1):
            if step == WARM_STEPS:
                self._put(pool, starts)
            if step >= WARM_STEPS and (step - WARM_STEPS) % SAMPLE_STEPS == 0:
                made[(step - WARM_STEPS) // SAMPLE_STEPS] = motion(pool, count)
            if step < steps:
                pool.command(held[step], envs=envs)
                pool.advance(substeps, envs)
        return self._prediction(made)

    def _prediction(self, made: Array) -> Prediction:
        """Of the motion (samples + 1, n, 13)."""
        made = np.swapaxes(made, 0, 1)
        turn, velocity = made[..., 3:7], made[..., 7:10]
        push = np.diff(velocity, axis=1) / SAMPLE
        push[..., 2] += self._vehicle.gravity
        force = 0.5 * (
            rotation.into_body(turn[:, 1:], push) + rotation.into_body(turn[:, :-1], push)
        )
        return Prediction(made[:, 1:, :3], turn[:, 1:], made[:, 1:, 10:13], force)

    @staticmethod
    def _put(pool: SimulationPool, starts: Array) -> None:
        for env, row in enumerate(starts):
            pool.teleport(env, row[:3], row[3:7], row[7:10], row[10:13])

    def _pool_of(self, count: int) -> SimulationPool:
        """A pool with at least so many environments, whose rotors have no nominal limit."""
        if self._pool is None or self._pool.num_envs < count:
            if self._pool is not None:
                self._pool.close()
            compiled = self._vehicle.compiled
            self._pool = SimulationPool(compiled, count, num_threads=self._threads)
            self._pool.reset()
        return self._pool


def motion(pool: SimulationPool, count: int) -> Array:
    """Motion of the only body of the first environments, (count, 13)."""
    return np.concatenate(
        [
            pool.positions[:count, 0],
            pool.rotations[:count, 0],
            pool.velocities[:count, 0],
            pool.angular_velocities[:count, 0],
        ],
        axis=1,
    )
