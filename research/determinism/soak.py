"""A soak: up to 10^9 steps of all shipped scenarios, with resets, faults, restores and hashes.

    python -m research run soak [--steps 1e9] [--scenarios NAME...] [--envs 256] [--quick]

Every scenario takes the same share of the steps, through a pool with all processors, in rounds: all
pools stay open, and each takes a part of its steps in every round. Actions are random, a few of
them not finite; one environment in a hundred is reset instead of being stepped. After every round
each pool is saved, and its last steps are flown again: by the same pool after a restore, and by a
pool of one thread. All three must give the same trajectory hash. Prints the resident memory and the
number of open files after every round, and a hash over all pools at the end: it is the same on
every machine and with any number of threads, as long as --steps, --scenarios and --envs are the
same. Exit status 0: hashes are the same and memory is constant from the second round on; 1: they
are not. 10^9 steps of all scenarios take about a day of two cores; --scenarios hover a quarter of
an hour.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence

import numpy as np
import skybody
from numpy.typing import NDArray
from skybody._native import shipped_scenarios

from research.determinism.memory import BOUND, MIB, Chance, handles, resident

STEPS = 1_000_000_000
QUICK_STEPS = 30_000
QUICK_SCENARIOS = ("hover", "payload", "racing")
ENVS, QUICK_ENVS = 256, 32
ROUNDS = 10
REPEATED = 20  # last steps of a round that are flown again
FNV = (0xCBF29CE484222325, 0x100000001B3)

Mask = NDArray[np.bool_]


class Soaked:
    """A scenario's pool, and its random actions and resets."""

    def __init__(self, name: str, envs: int) -> None:
        self.name = name
        self.envs = envs
        self.compiled = skybody.CompiledScenario(name)
        self.pool = self.made(0)
        self.pool.reset()
        self.chance = Chance(self.compiled.action_size)
        self.steps = 0

    def made(self, threads: int) -> skybody.Pool:
        """A pool of the scenario; 0: one thread for each processor."""
        return skybody.make_pool(
            self.compiled, self.envs, num_threads=threads, seed=1, keep_hash=True
        )

    def fly(self, pool: skybody.Pool, chance: Chance, times: int) -> int:
        """Steps or resets every environment so many times; returns the number of steps."""
        ids, steps = np.arange(self.envs, dtype=np.int32), 0
        for _ in range(times):
            mask: Mask = chance.resets(self.envs)
            actions = chance.actions(self.envs)
            pool.async_reset(mask)
            if not mask.all():
                pool.send(actions[~mask], ids[~mask])
            while pool.in_flight > 0:
                pool.recv()
            steps += int(np.sum(~mask))
        return steps

    def soak(self, steps: int) -> bool:
        """Takes these steps, flies the last ones again; returns whether the hashes are the same."""
        wanted = self.steps + steps
        while self.steps < wanted:
            left = -(-(wanted - self.steps) // self.envs)
            self.steps += self.fly(self.pool, self.chance, min(left, 1000))
        saved, state = self.pool.save(), self.chance.random.bit_generator.state
        self.steps += self.fly(self.pool, self.chance, REPEATED)
        hashes = [self.pool.hash()]
        with self.made(1) as alone:
            for pool in (self.pool, alone):
                pool.restore(saved)
                again = Chance(self.compiled.action_size)
                again.random.bit_generator.state = state
                self.fly(pool, again, REPEATED)
                hashes.append(pool.hash())
        same = len(set(hashes)) == 1
        if not same:
            print(f"  {self.name}: HASHES DIFFER: {' '.join(f'{h:016x}' for h in hashes)}")
        return same


def hash_of(pools: Sequence[Soaked]) -> int:
    """64-bit FNV-1a over the hashes of all pools."""
    value = FNV[0]
    for soaked in pools:
        for byte in soaked.pool.hash().to_bytes(8, "little"):
            value = (value ^ byte) * FNV[1] % 2**64
    return value


def soak(names: Sequence[str], steps: int, envs: int) -> bool:
    """All rounds; returns whether all is well."""
    pools = [Soaked(name, envs) for name in names]
    part = max(1, steps // (ROUNDS * len(names)))
    well, values, before = True, [], None
    begun = time.monotonic()
    for number in range(1, ROUNDS + 1):
        well &= all([soaked.soak(part) for soaked in pools])
        values.append(resident())
        before = before or handles()
        done = sum(soaked.steps for soaked in pools)
        print(
            f"  round {number:2}: {done:>13,} steps  {values[-1] / MIB:8.2f} MiB"
            f"  {handles()[0]} files  {time.monotonic() - begun:7.0f} s",
            flush=True,
        )
    growth, same = values[-1] - values[1], handles() == before
    bound = BOUND + len(names) * 2**16  # buffers of each pool, once
    flat = growth < bound
    faults = sum(soaked.pool.faults for soaked in pools)
    print(f"  {faults:,} faults; open files and threads {'the same' if same else 'NOT THE SAME'}")
    print(
        f"  memory since the second round: {growth / MIB:+.2f} MiB, "
        f"bound {bound / MIB:.2f} MiB: {'flat' if flat else 'GROWS'}"
    )
    print(f"  hash of {len(names)} scenarios: {hash_of(pools):016x}")
    for soaked in pools:
        soaked.pool.close()
    return well and flat and same


def main() -> int:
    """Soaks; returns the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--steps", type=float, metavar="N", help=f"of all scenarios; default: {STEPS:,}")
    add("--scenarios", nargs="+", metavar="NAME", help="default: all that are shipped")
    add("--envs", type=int, metavar="N", help=f"of each scenario; default: {ENVS}")
    add("--quick", action="store_true", help=f"a trial: {QUICK_STEPS:,} steps of 3 scenarios")
    options = parser.parse_args()
    names = options.scenarios or (QUICK_SCENARIOS if options.quick else shipped_scenarios())
    if unknown := sorted({*names} - {*shipped_scenarios()}):
        parser.error(f"--scenarios {unknown[0]}: no such scenario")
    envs = options.envs or (QUICK_ENVS if options.quick else ENVS)
    steps = int(options.steps or (QUICK_STEPS if options.quick else STEPS))
    if envs < 1 or steps < ROUNDS * len(names):
        parser.error(f"at least 1 environment and {ROUNDS * len(names)} steps")
    print(f"{len(names)} scenarios, {envs} environments each, {steps:,} steps", flush=True)
    return 0 if soak(names, steps, envs) else 1
