"""Open-loop replays in the engine: many windows and many vehicles in one pool."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skybody._native import SimulationPool
from skybody.look.flight import Array

from . import rotation
from .vehicle import DT, Vehicle

STEP = 0.0025  # a command is held for this time [s]
WARM = 0.4  # rotors follow the commands for this time before a window begins [s]
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
                for STEP. The first ones set the rotors' speeds at the start, by the engine's lag.
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
        count = len(values)
        pool = self._pool_of(count)
        envs = np.arange(count, dtype=np.int32)
        rotors = commands.shape[2]
        first = [f"robots.vehicle.start.rotors[{k}].speed" for k in range(rotors)]
        begin = spun(commands[:, :WARM_STEPS], *lags(paths, values, rotors))
        names = [*paths, *first]
        for env, row in enumerate(np.concatenate([values, begin], axis=1).tolist()):
            for path, value in zip(names, row, strict=True):
                pool.set_param(env, path, value)
        pool.reset(envs)
        self._put(pool, starts)
        held = np.ascontiguousarray(np.swapaxes(commands[:, WARM_STEPS:], 0, 1))
        substeps = round(STEP / DT)
        states, forces, push = [], [], np.zeros((count, 3))
        now = motion(pool, count)
        for step, speeds in enumerate(held, start=1):
            pool.command(speeds, envs=envs)
            pool.advance(substeps, envs)
            before, now = now, motion(pool, count)
            push = push + self._force(before, now)
            if step % SAMPLE_STEPS == 0:
                states.append(now)
                forces.append(push / SAMPLE_STEPS)
                push = np.zeros((count, 3))
        made = np.stack(states, axis=1)
        return Prediction(made[..., :3], made[..., 3:7], made[..., 10:13], np.stack(forces, axis=1))

    def _force(self, before: Array, now: Array) -> Array:
        """Mean specific force over a STEP, B [m/s^2]."""
        push = (now[:, 7:10] - before[:, 7:10]) / STEP
        push[:, 2] += self._vehicle.gravity
        turns = (rotation.into_body(state[:, 3:7], push) for state in (before, now))
        return np.asarray(0.5 * sum(turns))

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


def lags(paths: Sequence[str], values: Array, rotors: int) -> tuple[Array, Array]:
    """Time constants of the rotors, up and down, (n, rotors) [s]."""
    places = list(paths)
    up, down = (
        [places.index(Vehicle.rotor_path(k, name)) for k in range(rotors)]
        for name in ("tau_up", "tau_down")
    )
    return values[:, up], values[:, down]


def spun(commands: Array, up: Array, down: Array) -> Array:
    """Speeds of rotors (n, rotors) [rad/s] after commands (n, steps, rotors), docs/rotors.md."""
    speed = np.maximum(commands[:, 0], 0.0)
    keep_up, keep_down = (np.exp(-STEP / np.maximum(tau, 1e-9)) for tau in (up, down))
    for step in range(commands.shape[1]):
        wanted = np.maximum(commands[:, step], 0.0)
        speed = wanted + (speed - wanted) * np.where(wanted > speed, keep_up, keep_down)
    return np.asarray(speed)


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
