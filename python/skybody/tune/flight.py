"""Flies many candidates over many draws in one pool."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skybody._native import CompiledScenario
from skybody.pool import Pool

from .commands import Motion, Program, normalized
from .draws import Draws
from .gains import Gains
from .vehicle import ROBOT

Rows = NDArray[np.float64]


@dataclass(frozen=True)
class Flights:
    """Records of n flights of `steps` commands."""

    errors: Rows
    """(steps, n, tracked), in scales of the program"""
    rates: Rows
    """(steps, n, 3), B [rad/s]"""
    rotor_commands: Rows
    """(steps, n, rotors), relative to each rotor's largest speed"""
    limited: NDArray[np.bool_]
    """(steps, n): whether a law of the chain is cut by one of its limits"""
    lost_at: NDArray[np.int64]
    """(n,): the command at which a flight was lost, or `steps`"""

    @property
    def steps(self) -> int:
        return len(self.errors)

    def of(self, which: slice | NDArray[np.int64]) -> Flights:
        """A subset of the flights."""
        return Flights(
            self.errors[:, which],
            self.rates[:, which],
            self.rotor_commands[:, which],
            self.limited[:, which],
            self.lost_at[which],
        )


class Flyer:
    """A pool in which every candidate flies the same draws: environment = candidate x draw.

    All environments are copies of the first one, including random keys, so that two flights differ
    only in gains and drawn values.
    """

    def __init__(
        self,
        compiled: CompiledScenario,
        program: Program,
        draws: Draws,
        candidates: int = 1,
        num_threads: int = 0,
    ) -> None:
        self.program = program
        self._draws = draws
        self._actions = normalized(compiled, program.commands)
        self._pool = Pool(compiled, candidates * len(draws), num_threads=num_threads)
        self._limits = [c.name for c in compiled.info_channels if c.name.endswith(".limited")]
        self._pool.reset()
        if self._pool.num_envs > 1:
            self._pool.fork(0, list(range(1, self._pool.num_envs)))
        for env in range(self._pool.num_envs):
            self._set(env, draws.paths, draws.values[env % len(draws)])
        self._start = self._pool.save()
        rotors = [path for path in compiled.param_paths if path.endswith("].max_speed")]
        self._max_speed = np.column_stack([self._pool.state(path) for path in rotors])

    def _set(self, env: int, paths: list[str], values: Rows) -> None:
        for path, value in zip(paths, values, strict=True):
            self._pool.set_param(env, path, float(value))

    def fly(self, gains: Gains, points: Rows) -> Flights:
        """Flies the candidates `points` (k, gains), k at most the pool's size; flights k by k."""
        self._pool.restore(self._start)
        count = len(self._draws)
        for candidate, point in enumerate(points):
            values = gains.values(point)
            for env in range(candidate * count, (candidate + 1) * count):
                self._set(env, gains.paths, values)
        return self._run(len(points) * count)

    def _run(self, n: int) -> Flights:
        program, total = self.program, self._pool.num_envs
        steps = len(self._actions)
        errors = np.zeros((steps, n, len(program.names)))
        rates = np.zeros((steps, n, 3))
        commands = np.zeros((steps, n, self._max_speed.shape[1]))
        limited = np.zeros((steps, n), bool)
        lost_at = np.full(n, steps)
        for k, action in enumerate(self._actions):
            *_, info = self._pool.step(np.tile(action, (total, 1)))
            motion = self._motion(n)
            errors[k] = program.error(k, motion)
            rates[k] = motion.rates
            commands[k] = self._pool.state(f"robots.{ROBOT}.rotors.command")[:n]
            for name in self._limits:
                limited[k] |= info[name][:n].reshape(n) > 0.0
            beyond = np.any(np.abs(errors[k]) > program.lost, axis=1) | info["fault"][:n]
            lost_at[beyond & (lost_at == steps)] = k
            if np.all(lost_at < steps):
                break
        commands /= self._max_speed[:n]
        return Flights(errors, rates, commands, limited, lost_at)

    def _motion(self, n: int) -> Motion:
        base = f"robots.{ROBOT}.base."
        return Motion(
            self._pool.state(base + "position")[:n],
            self._pool.state(base + "rotation")[:n],
            self._pool.state(base + "velocity")[:n],
            self._pool.state(base + "angular_velocity")[:n],
        )

    def close(self) -> None:
        self._pool.close()

    def __enter__(self) -> Flyer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
