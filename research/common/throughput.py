"""Steps per second of an asynchronous pool from Python, by the GzDRL paper's protocol.

The reference's code counts receives, where the paper's text has environment steps: 1,000 for
warm-up and 10,000 measured ones. A receive returns N_B rows, each an environment step; a row that
begins an episode counts like the others, as in the reference. Each trial has a separate pool and
seed.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import skybody

from research.common.machine import processor_seconds, processors
from research.common.trials import interval

BURST = 10  # receives between two readings of the clock
# Actions a of (a + 1) * 1150 rad/s: the reference's constant action, and the QDrone2's hover speed.
ACTIONS = {"zero": 0.0, "hold": 1391.0 / 1150.0 - 1.0}


@dataclass(frozen=True)
class Case:
    """Environments, batch and actions of a measurement."""

    scenario: str
    envs: int  # N_E
    batch: int  # N_B
    action: str  # of ACTIONS, the same for all environments and steps
    overrides: tuple[str, ...] = ()
    row: tuple[float, ...] = ()  # values of an environment's action, in place of `action`

    @property
    def threads(self) -> int:
        """N_T, as in the paper."""
        return min(self.envs, processors())


@dataclass(frozen=True)
class Length:
    """Length of a measurement: the longer of receives and seconds, limited by `most`."""

    trials: int
    warm_up: int  # [receives]
    receives: int
    seconds: float
    most: float = float("inf")  # of warm-up and measurement, each [s]


FULL = Length(trials=5, warm_up=1_000, receives=10_000, seconds=1.0)
QUICK = Length(trials=3, warm_up=100, receives=500, seconds=0.05, most=0.5)


@dataclass(frozen=True)
class Trial:
    """One measurement."""

    receives: int
    steps: int  # receives times N_B
    seconds: float
    cpu_use: float  # processor time over wall time and processors: 0 ... 1

    @property
    def rate(self) -> float:
        """[steps/s]"""
        return self.steps / self.seconds


@dataclass(frozen=True)
class Summary:
    """Mean of several trials."""

    rate: float  # [steps/s]
    interval: float  # half the width of the 95 % interval of Student's t [steps/s]
    cpu_use: float
    receives: float
    steps: float


def summary(trials: Sequence[Trial]) -> Summary:
    """Summary of two or more trials."""
    rates = [trial.rate for trial in trials]
    return Summary(
        rate=statistics.mean(rates),
        interval=interval(rates),
        cpu_use=statistics.mean(trial.cpu_use for trial in trials),
        receives=statistics.mean(trial.receives for trial in trials),
        steps=statistics.mean(trial.steps for trial in trials),
    )


def measure(case: Case, length: Length) -> list[Trial]:
    """All trials of one case."""
    compiled = skybody.CompiledScenario(case.scenario, overrides=list(case.overrides))
    return [_trial(compiled, case, length, seed) for seed in range(length.trials)]


def _trial(compiled: skybody.CompiledScenario, case: Case, length: Length, seed: int) -> Trial:
    with skybody.make_pool(
        compiled,
        case.envs,
        batch_size=case.batch,
        num_threads=case.threads,
        seed=seed,
        infos=False,
    ) as pool:
        pool.async_reset()
        receive = _receiver(pool, case)
        _receive_for(receive, length.warm_up, 0.0, length.most)
        computed = processor_seconds()
        receives, seconds = _receive_for(receive, length.receives, length.seconds, length.most)
        computed = processor_seconds() - computed
    return Trial(receives, receives * case.batch, seconds, computed / (seconds * processors()))


def _receiver(pool: skybody.Pool, case: Case) -> Callable[[], None]:
    """Receives a batch and sends those environments again."""
    shape = (case.batch, pool.compiled.action_size)
    rows = np.full(shape, case.row or ACTIONS[case.action], np.float32)
    recv, send = pool.recv, pool.send

    def receive_all() -> None:
        recv()
        send(rows)

    def receive_some() -> None:
        send(rows, recv()[4]["env_id"])

    return receive_all if case.batch == case.envs else receive_some


def _receive_for(
    receive: Callable[[], None], receives: int, seconds: float, most: float
) -> tuple[int, float]:
    """Receives so many and for so long, at most `most`; returns number and time [s]."""
    done, start = 0, time.perf_counter()
    while True:
        for _ in range(BURST):
            receive()
        done += BURST
        taken = time.perf_counter() - start
        if (done >= receives and taken >= seconds) or taken >= most:
            return done, taken
