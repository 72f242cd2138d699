"""Cost of PyTorch's threads for a small network: PPO of Stable-Baselines3 on Skybody's
environments.

    .venv/bin/python experiments/torch_threads.py [--turns 3] [--markdown FILE]

Each run is a separate process, settings in turns: PyTorch's own choice, then
`torch.set_num_threads(1)`; each without other load, and with one process that keeps a processor
busy, like another training or a build. PPO with its defaults (two layers of 64, minibatches of 64)
learns `hover_learn` in 16 environments.
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from pathlib import Path

from skybody.program import ignoring_interrupts, run_program
from throughput import (
    facts,
    machine_line,
    markdown_table,
    page_data,
    plain_table,
)

ENVS, ROLLOUT = 16, 128
QUICK_ROLLOUT = 32


def train(
    one_thread: bool, rollout: int, results: multiprocessing.Queue[tuple[int, float]]
) -> None:
    """Trains briefly; puts PyTorch's number of threads and environment steps per second."""
    import torch
    from skybody.sb3 import SkybodyVecEnv
    from stable_baselines3 import PPO

    if one_thread:
        torch.set_num_threads(1)
    envs = SkybodyVecEnv("hover_learn", ENVS, seed=1)
    model = PPO("MlpPolicy", envs, n_steps=rollout, seed=1, device="cpu")
    model.learn(ENVS * rollout)  # warm-up
    begin = time.perf_counter()
    steps = 2 * ENVS * rollout  # two rollouts with their updates
    model.learn(steps)
    results.put((torch.get_num_threads(), steps / (time.perf_counter() - begin)))
    envs.close()


def keep_busy() -> None:
    while True:
        sum(range(10_000))


def measure(one_thread: bool, is_busy: bool, rollout: int) -> tuple[int, float]:
    """PyTorch's threads and steps per second of one run."""
    context = multiprocessing.get_context("spawn")
    results = context.Queue()
    other = context.Process(target=keep_busy, daemon=True)
    if is_busy:
        with ignoring_interrupts():
            other.start()
    try:
        run = context.Process(target=train, args=(one_thread, rollout, results))
        with ignoring_interrupts():
            run.start()
        found: tuple[int, float] = results.get(timeout=900)
        run.join()
    finally:
        if is_busy:
            other.terminate()
            other.join()
    return found


def extent(values: list[float], form: str = ",.0f") -> str:
    """Smallest to largest."""
    return f"{min(values):{form}} to {max(values):{form}}"


def page(machine: str, rows: list[list[str]], turns: int) -> str:
    return f"""# PyTorch's threads and small networks

    python experiments/torch_threads.py --turns {turns} --markdown docs/results/torch_threads.md

on {machine}.
PPO of Stable-Baselines3 with its defaults (two layers of 64, minibatches of 64) on `hover_learn` in
{ENVS} environments: environment steps a second of rollouts and updates together, least to greatest
of {turns} turns. "Beside another": one more process computes all the time.

{markdown_table(rows)}

The matrices are so small that PyTorch's threads wait for one another more than they compute. Where
a processor is busy with something else, each of thousands of such waits lasts until the system
gives it back.
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--turns", type=int, default=3, help="runs of each setting")
    parser.add_argument("--markdown", type=Path, metavar="FILE", help="write the page to this file")
    parser.add_argument("--quick", action="store_true", help="a trial: one turn, short rollouts")
    options = parser.parse_args()
    rollout = QUICK_ROLLOUT if options.quick else ROLLOUT
    options.turns = 1 if options.quick else options.turns
    rows = [["the machine", "PyTorch's threads", "steps/s", "times slower than with one"]]
    machine = machine_line(facts())
    print(machine)
    for is_busy in (False, True):
        turns = [
            [measure(one, is_busy, rollout) for one in (False, True)] for _ in range(options.turns)
        ]
        slower = [one[1] / own[1] for own, one in turns]
        where = "beside another" if is_busy else "as it is"
        threads = f"{turns[0][0][0]} (its choice)"
        rates = [extent([turn[k][1] for turn in turns]) for k in (0, 1)]
        rows.append([where, threads, rates[0], extent(slower, ".1f")])
        rows.append([where, "1 (set)", rates[1], "1"])
    print(plain_table(rows))
    if options.markdown:
        page_data.write(options.markdown, page(machine, rows, options.turns))


if __name__ == "__main__":
    run_program(main)
