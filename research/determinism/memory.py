"""Whether memory grows.

    python -m research run memory [--steps N] [--cycles N]

Four processes, one after another. Two take 10^7 environment steps of `hover` in 1,024
environments, with random actions (a few of them not finite) and random resets by mask: one through
`make_pool`, in batches of a third, one through `make_vec`. They print the resident memory ten times
during the run. The third learns from 10^8 steps of `hover_learn` by `fast-ppo`. The fourth creates,
uses and closes 1,000 pools and vector environments. Exit status 0: resident memory is constant, and
the numbers of open files and threads are unchanged; 1: they are not.
"""

from __future__ import annotations

import argparse
import gc
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import skybody
from numpy.typing import NDArray
from skybody.train.native_learners import FastPpo
from skybody.train.presets import preset

from research.common.places import command_of

PAGE = "memory"

ENVS = 1024
STEPS = 10_000_000
CYCLES = 1000
LEARNER_STEPS = 10  # times the steps of the runs without learning
REPORTS = 10
FAULT_SHARE = 1e-4  # of the actions are not finite
RESET_SHARE = 0.01  # of the environments are reset instead of being stepped
MIB = 2**20
# Memory kept by the allocators of the C library and Python varies with pages and arenas, not with
# the number of steps: below 1 MiB where measured. A leak of one byte per step would be 9 MB by the
# end of the default run, one of 5 kB per cycle 4.5 MB by the end of the cycles.
BOUND = 4 * MIB
CYCLE_ENVS = 16
CYCLE_THREADS = 3

Floats = NDArray[np.float32]


def resident() -> int:
    """Resident memory of this process [bytes]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def handles() -> tuple[int, int]:
    """Numbers of open files and threads of this process."""
    return len(os.listdir("/proc/self/fd")), len(os.listdir("/proc/self/task"))


class Memory:
    """Prints resident memory at equal intervals; the first report is the reference."""

    def __init__(self, total: int, unit: str) -> None:
        self.every = max(1, total // REPORTS)
        self.unit = unit
        self.values: list[int] = []
        self.begun = time.monotonic()

    def report(self, done: int) -> None:
        """To be called often; prints when the next report is due."""
        if done < self.every * (len(self.values) + 1):
            return
        self.values.append(resident())
        print(
            f"  {done:>10,} {self.unit}  {self.values[-1] / MIB:8.2f} MiB"
            f"  {time.monotonic() - self.begun:6.0f} s",
            flush=True,
        )

    def flat(self) -> bool:
        """Prints the growth since the first report; returns whether it is below the bound."""
        growth = self.values[-1] - self.values[0]
        verdict = "flat" if growth < BOUND else "GROWS"
        print(f"  last minus first: {growth / MIB:+.2f} MiB, bound {BOUND / MIB:g} MiB: {verdict}")
        return growth < BOUND


class Chance:
    """Random actions and resets."""

    def __init__(self, size: int) -> None:
        self.random = np.random.default_rng(1)
        self.size = size

    def actions(self, rows: int) -> Floats:
        """(rows, size) in [-1, 1], a few of them not finite."""
        values = self.random.uniform(-1.0, 1.0, (rows, self.size)).astype(np.float32)
        values[self.random.random(rows) < FAULT_SHARE] = np.nan
        return values

    def resets(self, rows: int) -> NDArray[np.bool_]:
        """A random mask of the rows to reset."""
        return self.random.random(rows) < RESET_SHARE


def step_pool(steps: int) -> bool:
    """Batches of a third, in order of arrival; some rows are reset and the others stepped."""
    memory = Memory(steps, "steps")
    done = 0
    with skybody.make_pool("hover", ENVS, batch_size=ENVS // 3, seed=1) as pool:
        chance = Chance(pool.compiled.action_size)
        pool.async_reset()
        while done < steps:
            ids = pool.recv()[-1]["env_id"].copy()
            again = chance.resets(len(ids))
            mask = np.zeros(ENVS, np.bool_)
            mask[ids[again]] = True
            pool.async_reset(mask)
            pool.send(chance.actions(int(np.sum(~again))), ids[~again])
            done += int(np.sum(~again))
            memory.report(done)
        print(f"  {pool.faults:,} faults, {pool.fresh_buffers} fresh buffers")
    return memory.flat()


def step_vector(steps: int) -> bool:
    """All environments at a time; some are reset at random steps."""
    memory = Memory(steps, "steps")
    done = 0
    envs = skybody.make_vec("hover", ENVS, seed=1)
    chance = Chance(envs.compiled.action_size)
    envs.reset()
    while done < steps:
        mask = chance.resets(ENVS)
        if mask.any():
            envs.reset(options={"reset_mask": mask})
        envs.step(chance.actions(ENVS))
        done += ENVS
        memory.report(done)
    print(f"  {envs.faults:,} faults, {envs.native.fresh_buffers} fresh buffers")
    envs.close()
    return memory.flat()


def learn(steps: int) -> bool:
    """`fast-ppo` on `hover_learn`, reading its policy after every rollout."""
    total = LEARNER_STEPS * steps
    hyper = preset("hover_learn", "fast-ppo").hyper
    compiled = skybody.CompiledScenario("hover_learn")
    learner = FastPpo(compiled, hyper, seed=1, threads=0, total_steps=total)
    memory = Memory(total, "steps")
    while learner.steps < total:
        learner.iterate()
        learner.policy()
        memory.report(learner.steps)
    return memory.flat()


def use_and_close(compiled: skybody.CompiledScenario, number: int) -> None:
    """A pool in flight and a vector environment; every second one is left to the collector."""
    actions = np.zeros((CYCLE_ENVS, compiled.action_size), np.float32)
    pool = skybody.make_pool(compiled, CYCLE_ENVS, num_threads=CYCLE_THREADS)
    pool.reset()
    pool.send(actions)
    envs = skybody.make_vec(compiled, CYCLE_ENVS, num_threads=CYCLE_THREADS)
    envs.reset()
    envs.step(actions)
    if number % 2 == 0:
        pool.close()
        envs.close()


def open_and_close(cycles: int) -> bool:
    """Loads the scenario, then creates, uses and closes both, `cycles` times."""
    memory = Memory(cycles, "cycles")
    before: tuple[int, int] | None = None
    for cycle in range(1, cycles + 1):
        use_and_close(skybody.CompiledScenario("hover"), cycle)
        if cycle % memory.every == 0:
            gc.collect()
        memory.report(cycle)
        before = before or handles()
    gc.collect()
    after = handles()
    same = after == before
    print(
        f"  open files, threads: {before} after the first cycle, {after} at the end: "
        f"{'the same' if same else 'NOT THE SAME'}"
    )
    return memory.flat() and same


PARTS = {
    "pool": (step_pool, "make_pool, batches of a third in order of arrival"),
    "vector": (step_vector, "make_vec"),
    "learner": (learn, "fast-ppo, ten times as many steps"),
    "cycles": (open_and_close, "a scenario, a pool and a vector environment, made and closed"),
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    add = parser.add_argument
    add("--steps", type=float, default=STEPS, help=f"steps of all environments; default: {STEPS:,}")
    add("--cycles", type=int, default=CYCLES, help=f"number of cycles; default: {CYCLES:,}")
    add("--part", choices=PARTS, help="run only this part, in this process; default: all")
    options = parser.parse_args()
    if options.steps < REPORTS * ENVS or options.cycles < REPORTS:
        parser.error(f"at least {REPORTS * ENVS} steps and {REPORTS} cycles")
    if options.part:
        work, title = PARTS[options.part]
        print(f"{options.part}: {title}", flush=True)
        return 0 if work(options.cycles if options.part == "cycles" else int(options.steps)) else 1
    codes = [
        subprocess.run(
            [*command_of("memory"), *sys.argv[1:], "--part", part],
            check=False,
            start_new_session=True,  # Ctrl-C at the terminal goes to this process only
        )
        for part in PARTS
    ]
    return max(abs(done.returncode) for done in codes)
