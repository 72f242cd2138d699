"""Compares an old build with a new one in turns: has an edit made the engine slower?

    .venv/bin/python experiments/old_and_new.py --old ../old

`--old` is another clone, built (`./dev build`). Each turn runs the same short measurement on both,
the old one first in every other turn, on one thread. The ratio new over old of each turn is kept;
the table has its median and the 95 % interval of the median (order statistics, binomial). A case is
slower if the whole interval is below --least. Exit status 0: none is, 1: some are, 2: a
process failed. `--markdown docs/results/old_and_new.md` writes the page.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from skybody.program import run_program
from training_runs import (
    ROOT,
    machine,
    machine_line,
    page_data,
)


@dataclass(frozen=True)
class Case:
    """One workload. `arguments` go to `skybody bench`; from Python: environments of a Pool."""

    name: str
    arguments: tuple[str, ...] = ()
    python_envs: int = 0


# Starts on the ground, with rotors at two thirds of the weight: the vehicles stay there.
GROUND = (
    "--actions",
    "zero",
    "--set",
    "randomization[0].parameters.position_min=[-5,-5,0.02]",
    "--set",
    "randomization[0].parameters.position_max=[5,5,0.03]",
)

CASES = (
    Case("hover, K = 1", ("hover", "--envs", "128", "--set", "stepping.action_repeat=1")),
    Case("hover, K = 10", ("hover", "--envs", "128", "--set", "stepping.action_repeat=10")),
    Case("all on the ground", ("hover", "--envs", "128", *GROUND)),
    Case("rod", ("boom", "--envs", "128")),
    Case("payload as shipped", ("payload", "--envs", "128")),
    Case("payload bare", ("payload", "--envs", "128", "--set", "randomization=[]")),
    Case("formation of 20", ("formation_20", "--envs", "32")),
    Case("hover, one environment", ("hover", "--envs", "1")),
    Case("Python, N = 1024", python_envs=1024),
    Case("Python, N = 1", python_envs=1),
)

# Run with the project's own module: the rate of `make_vec` in steps per second.
PYTHON = """
import sys, time
import numpy as np
import skybody
envs = skybody.make_vec("hover", num_envs=int(sys.argv[1]), seed=1, num_threads=1)
envs.reset(seed=1)
actions = np.zeros(envs.action_space.shape, np.float32)
end, count, begin = time.perf_counter() + float(sys.argv[2]), 0, time.perf_counter()
while time.perf_counter() < end:
    for _ in range(10):
        envs.step(actions)
    count += 10
print(count * int(sys.argv[1]) / (time.perf_counter() - begin))
"""


def measure(project: Path, case: Case, seconds: float) -> float:
    """Steps per second."""
    if case.python_envs > 0:
        environment = {**os.environ, "PYTHONPATH": str(project / "python")}
        command = [sys.executable, "-P", "-c", PYTHON, str(case.python_envs), str(seconds)]
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
    else:
        program = [str(project / "build/release/bin/skybody"), "bench", *case.arguments]
        command = [*program, "--threads", "1", "--seconds", str(seconds), "--json"]
        done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        print(f"{' '.join(command[:4])} failed:\n{done.stderr}", file=sys.stderr)
        raise SystemExit(2)
    if case.python_envs > 0:
        return float(done.stdout)
    return float(json.loads(done.stdout)["env_steps_per_second"])


def interval(values: list[float]) -> tuple[float, float, float]:
    """Median and the 95 % interval of the median: order statistics of a binomial at 1/2."""
    values, n = sorted(values), len(values)
    below, outside = 0.0, -1
    for k in range(n):
        below += math.comb(n, k) / 2**n
        if below > 0.025:
            break
        outside = k
    first = max(outside, 0)
    return values[n // 2], values[first], values[n - 1 - first]


def turns(old: Path, new: Path, case: Case, count: int, seconds: float) -> list[float]:
    ratios = []
    for turn in range(count):
        pair = (old, new) if turn % 2 == 0 else (new, old)
        first, second = (measure(project, case, seconds) for project in pair)
        ratios.append(second / first if turn % 2 == 0 else first / second)
    return ratios


def revision(project: Path) -> str:
    done = subprocess.run(
        ["git", "-C", str(project), "rev-parse", "--short", "HEAD"], capture_output=True, text=True
    )
    return done.stdout.strip() or "no commit"


def page(options: argparse.Namespace, rows: list[str]) -> str:
    return f"""# Old against new

Steps a second of one build over another, in turns, by

    python experiments/old_and_new.py --old OTHER_CLONE --markdown docs/results/old_and_new.md

on {machine_line(machine())}. Old: {revision(options.old)}, new: {revision(options.new)};
{options.turns} turns of {options.seconds} s, one thread; median of the ratios, its 95 % interval.

| case | new / old | 95 % interval |
| --- | ---: | --- |
{chr(10).join(rows)}
"""


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--old", type=Path, help="folder of the old project")
    parser.add_argument(
        "--new", type=Path, default=ROOT, help="folder of the new project (this one)"
    )
    parser.add_argument("--turns", type=int, default=21)
    parser.add_argument(
        "--seconds", type=float, default=0.5, help="duration of one measurement [s]"
    )
    parser.add_argument("--least", type=float, default=0.97)
    parser.add_argument("--case", action="append", help="only cases with this text in their name")
    parser.add_argument("--markdown", type=Path, help="page to write")
    parser.add_argument(
        "--quick", action="store_true", help="a trial: the first case, three short turns"
    )
    options = parser.parse_args()
    if options.quick:
        options.old = options.old or options.new
        options.turns, options.seconds, options.least = 3, 0.05, 0.0
        options.case = options.case or [CASES[0].name]
    if options.old is None:
        parser.error("--old: the other project folder")
    rows, slower = [], 0
    for case in CASES:
        if options.case and not any(part in case.name for part in options.case):
            continue
        ratios = turns(options.old, options.new, case, options.turns, options.seconds)
        median, low, high = interval(ratios)
        slower += high < options.least
        verdict = " slower" if high < options.least else ""
        rows.append(f"| {case.name} | {median:.3f} | {low:.3f} ... {high:.3f}{verdict} |")
        print(rows[-1], flush=True)
    if options.markdown:
        page_data.write(options.markdown, page(options, rows))
    return 1 if slower else 0


if __name__ == "__main__":
    run_program(main)
