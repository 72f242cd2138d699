"""The flight of `skybody hash`, from Python: the same actions, so the same trajectory hash.

    python -m research run hash_run SCENARIO [--envs N] [--threads T] [--batch B] ...

Prints four hashes, which should equal that of `skybody hash` with the same options:

1. of the whole flight;
2. of one that is saved in the middle, disturbed and restored;
3. of one that is restored there into a pool of one thread;
4. of the whole flight again, if all environments except the first are unchanged while the first
   gets actions that are not finite (otherwise of that flight).
"""

from __future__ import annotations

import argparse

import numpy as np
import skybody
from numpy.typing import NDArray

# Philox4x64 of Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011.
ROUNDS = 10
MULTIPLIERS = (0xD2E7470EE14C6C93, 0xCA5A826395121157)
KEY_STEPS = (0x9E3779B97F4A7C15, 0xBB67AE8584CAA73B)
WORDS = 4  # per block
LOW = np.uint64(0xFFFFFFFF)
HALF = np.uint64(32)

DISTURBING_STEPS = 3
FAULT_EVERY = 5  # steps of the first environment

Words = NDArray[np.uint64]


def multiply(a: Words, b: int) -> tuple[Words, Words]:
    """High and low word of the 128-bit product, from products of 32-bit halves."""
    b_low, b_high = np.uint64(b & 0xFFFFFFFF), np.uint64(b >> 32)
    a_low, a_high = a & LOW, a >> HALF
    middle = a_high * b_low + (a_low * b_low >> HALF)
    other = a_low * b_high + (middle & LOW)
    return a_high * b_high + (middle >> HALF) + (other >> HALF), a * np.uint64(b)


def philox(counter: list[Words], key: tuple[Words, Words]) -> Words:
    """Blocks (..., 4) from the counters' four words and the key's two."""
    x0, x1, x2, x3 = counter
    k0, k1 = key
    for _ in range(ROUNDS):
        high0, low0 = multiply(x0, MULTIPLIERS[0])
        high2, low2 = multiply(x2, MULTIPLIERS[1])
        x0, x1, x2, x3 = high2 ^ x1 ^ k0, low2, high0 ^ x3 ^ k1, low0
        k0, k1 = k0 + np.uint64(KEY_STEPS[0]), k1 + np.uint64(KEY_STEPS[1])
    return np.stack([x0, x1, x2, x3], axis=-1)


def stream(name: str) -> int:
    """Id of a stream of random numbers: 64-bit FNV-1a of its name."""
    value = 0xCBF29CE484222325
    for byte in name.encode():
        value = (value ^ byte) * 0x100000001B3 % 2**64
    return value


def hash_actions(seed: int, envs: int, steps: int, size: int) -> NDArray[np.float32]:
    """Actions (steps, envs, size) of `skybody hash`: uniform in [-1, 1]; see its --help."""
    blocks = -(-size // WORDS)
    step, env, block = np.indices((steps, envs, blocks), np.uint64)
    counter = [np.zeros_like(step), np.full_like(step, stream("hash.action")), step, block]
    words = philox(counter, (np.full_like(step, seed), env))
    uniform = (words >> np.uint64(11)) * 2.0**-53  # exact, as are the following operations
    return (2.0 * uniform - 1.0).astype(np.float32).reshape(steps, envs, -1)[:, :, :size]


class Flight:
    """Environments that each make a reset and then one step after another."""

    def __init__(self, pool: skybody.Pool, actions: NDArray[np.float32]) -> None:
        self.pool = pool
        self.actions = actions
        self.taken = np.zeros(pool.num_envs, np.int64)

    def reset(self) -> None:
        """Resets all environments, and waits for them."""
        self.pool.async_reset()
        while self.pool.in_flight > 0:
            self.pool.recv()

    def fly_to(self, step: int) -> None:
        """Steps every environment up to `step`, sending each as soon as it is received."""
        ids = np.arange(self.pool.num_envs, dtype=np.int32)
        while True:
            ids = ids[self.taken[ids] < step]
            if len(ids) > 0:
                self.pool.send(self.actions[self.taken[ids], ids], ids)
                self.taken[ids] += 1
            if self.pool.in_flight == 0:
                return
            ids = self.pool.recv()[-1]["env_id"]


def hashes(options: argparse.Namespace) -> list[str]:
    """The four hashes of the program."""
    compiled = skybody.CompiledScenario(options.scenario, options.set)
    steps, half = options.steps, options.steps // 2
    actions = hash_actions(options.seed, options.envs, steps, compiled.action_size)

    def flight(threads: int, batch: int, order: skybody.options.Order) -> Flight:
        pool = skybody.make_pool(
            compiled,
            options.envs,
            batch_size=batch,
            num_threads=threads,
            order=order,
            seed=options.seed,
            keep_hash=True,
        )
        return Flight(pool, actions)

    whole = flight(options.threads, options.batch, options.order)
    whole.reset()
    whole.fly_to(steps)

    restored = flight(options.threads, options.batch, options.order)
    restored.reset()
    restored.fly_to(half)
    saved = restored.pool.save()
    restored.fly_to(min(half + DISTURBING_STEPS, steps))
    restored.pool.restore(saved)
    restored.taken[:] = half
    restored.fly_to(steps)

    moved = flight(1, 0, "fixed")
    moved.pool.restore(saved)
    moved.taken[:] = half
    moved.fly_to(steps)

    disturbed = flight(options.threads, options.batch, options.order)
    disturbed.actions = actions.copy()
    disturbed.actions[::FAULT_EVERY, 0] = np.nan
    disturbed.reset()
    disturbed.fly_to(steps)
    others = range(1, options.envs)
    same = all(disturbed.pool.hash(env) == whole.pool.hash(env) for env in others)
    neighbours = whole if same and disturbed.pool.faults > 0 else disturbed
    return [f"{one.pool.hash():016x}" for one in (whole, restored, moved, neighbours)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add = parser.add_argument
    add("scenario", help="YAML file, or the name of a shipped scenario")
    add("--set", metavar="PATH=VALUE", action="append", default=[], help="override one value")
    add("--envs", type=int, default=1, help="number of environments; default: 1")
    add("--steps", type=int, default=1000, help="steps per environment; default: 1000")
    add("--seed", type=int, default=0, help="key of all random numbers; default: 0")
    add("--threads", type=int, default=1, help="0: one per processor; default: 1")
    add("--batch", type=int, default=0, help="environments per batch; default: 0, all")
    add("--order", choices=("fixed", "arrival"), default="fixed", help="of batches")
    print(*hashes(parser.parse_args()), sep="\n")
