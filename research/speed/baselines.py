"""Steps per second of several ways to step N environments, as in the paper's Table III.

scalability.py compares them with the asynchronous pool and the paper's own figures.

Hover (one physics step per action), constant zero action, ended episodes reset; N environments:

* loop: one Python thread, one Simulation after the other;
* threads: Python threads, one per processor, each with its share of the Simulations;
* processes: the same with processes (spawn); they answer by pipe with all observations, rewards and
  ends of their share;
* pool: SimulationPool, C++ threads, one per processor, one call for all;
* vec: make_vec, C++ threads, one per processor.

All of them wait for all environments in every step, and return observations, rewards and ends.
Each figure is the mean of several trials in one process, with the 95 % interval of Student's t, and
the share of all processors that the process and its children used.
"""

from __future__ import annotations

import itertools
import multiprocessing
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Protocol

import numpy as np
import skybody
from numpy.typing import NDArray
from skybody._native import CompiledScenario
from skybody._native import Simulation as NativeSimulation
from skybody.program import ignoring_interrupts
from skybody.simulation import SimulationPool

from research.common.machine import processor_seconds, processors
from research.common.trials import rounds_a_second

Rows = tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]


class Environments(Protocol):
    """N environments: each call steps all of them once; returns observations, rewards and ends."""

    def step(self) -> Rows: ...
    def close(self) -> None: ...


class Share:
    """Some Simulations, stepped one after the other by the caller."""

    def __init__(self, compiled: CompiledScenario, first: int, count: int) -> None:
        self.envs = [NativeSimulation(compiled, 0, first + i) for i in range(count)]
        for sim in self.envs:
            sim.reset()
        self.action = np.zeros(compiled.action_size, np.float32)
        self.observations = np.zeros((count, compiled.observation_size), np.float32)
        self.rewards = np.zeros(count, np.float32)
        self.ends = np.zeros(count, np.bool_)

    def step(self) -> Rows:
        for i, sim in enumerate(self.envs):
            sim.step(self.action)
            self.rewards[i] = sim.reward
            self.ends[i] = sim.status != 0
            if self.ends[i]:
                sim.reset()
            self.observations[i] = sim.observation
        return self.observations, self.rewards, self.ends

    def close(self) -> None:
        self.envs.clear()


def joined(parts: list[Rows]) -> Rows:
    observations, rewards, ends = zip(*parts, strict=True)
    return np.concatenate(observations), np.concatenate(rewards), np.concatenate(ends)


def shares(count: int) -> list[tuple[int, int]]:
    """First environment and number for each thread or process: at most one per processor."""
    workers = min(count, processors())
    edges = [count * k // workers for k in range(workers + 1)]
    return [(a, b - a) for a, b in itertools.pairwise(edges)]


class Loop(Share):
    def __init__(self, count: int) -> None:
        super().__init__(CompiledScenario("hover"), 0, count)


class Threads:
    def __init__(self, count: int) -> None:
        compiled = CompiledScenario("hover")
        self.shares = [Share(compiled, first, size) for first, size in shares(count)]
        self.threads = ThreadPoolExecutor(len(self.shares))

    def step(self) -> Rows:
        return joined(list(self.threads.map(Share.step, self.shares)))

    def close(self) -> None:
        self.threads.shutdown()


def serve(pipe: Connection, first: int, count: int) -> None:
    """A process: steps its share at each request, until the pipe closes."""
    share = Share(CompiledScenario("hover"), first, count)
    pipe.send(None)
    while pipe.recv():
        pipe.send(share.step())


class Processes:
    def __init__(self, count: int) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipes, self.processes = [], []
        for first, size in shares(count):
            mine, other = context.Pipe()
            process = context.Process(target=serve, args=(other, first, size), daemon=True)
            with ignoring_interrupts():
                process.start()
            other.close()
            self.pipes.append(mine)
            self.processes.append(process)
        for pipe in self.pipes:
            pipe.recv()

    def step(self) -> Rows:
        for pipe in self.pipes:
            pipe.send(True)
        return joined([pipe.recv() for pipe in self.pipes])

    def close(self) -> None:
        for pipe in self.pipes:
            pipe.send(False)
        for process in self.processes:
            process.join()


class Pool:
    def __init__(self, count: int) -> None:
        self.pool = SimulationPool("hover", count, pin_threads=True)
        self.pool.reset()
        self.actions = np.zeros((count, self.pool.compiled.action_size), np.float32)

    def step(self) -> Rows:
        self.pool.step(self.actions)
        rewards, ends = self.pool.rewards, self.pool.status != 0
        if ends.any():
            self.pool.reset(ends)
        return self.pool.observations, rewards, ends

    def close(self) -> None:
        self.pool.close()


class Vec:
    def __init__(self, count: int) -> None:
        self.envs = skybody.make_vec("hover", count, autoreset="same_step")
        self.envs.reset()
        self.actions = np.zeros((count, self.envs.compiled.action_size), np.float32)

    def step(self) -> Rows:
        observations, rewards, terminated, truncated, _ = self.envs.step(self.actions)
        return observations, rewards, terminated | truncated

    def close(self) -> None:
        self.envs.close()


WAYS: dict[str, Callable[[int], Environments]] = {
    "loop": Loop,
    "threads": Threads,
    "processes": Processes,
    "pool": Pool,
    "vec": Vec,
}


@dataclass(frozen=True)
class Trials:
    """Results of several trials of one way."""

    rates: list[float]  # [steps/s], one per trial
    cpu_use: float  # processor time over wall time and processors: 0 ... 1


def rate(envs: Environments, count: int, seconds: float) -> float:
    """Environment steps per second, measured over about that long."""
    return count * rounds_a_second(envs.step, seconds)


def measure(way: Callable[[int], Environments], count: int, trials: int, seconds: float) -> Trials:
    """Runs some trials one after another, after an unmeasured warm-up of a fifth of a trial."""
    envs = way(count)
    try:
        rate(envs, count, 0.2 * seconds)  # the first steps include one-time initialization
        computed, start = processor_seconds(), time.perf_counter()
        rates = [rate(envs, count, seconds) for _ in range(trials)]
        available = processors() * (time.perf_counter() - start)
        return Trials(rates, (processor_seconds() - computed) / available)
    finally:
        envs.close()
