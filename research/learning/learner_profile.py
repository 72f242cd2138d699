"""Run time of the learners by part, and the update relative to bare matrix products.

shares of time, update against bare matrix products, wide networks.

    python -m research run learner_profile [--turns 3] [--program BENCH_LEARN]

Three parts, each run in separate processes:

* Shares: `fast-ppo` and `gradient` learn `hover_learn` with their presets, on all threads and on
  one.
* Products: `bench_learn` measures our networks, Eigen's networks and only Eigen's matrix products
  (research/bench/learn); they are compared with the operations of fast-ppo's whole update.
* Wide: networks of [512, 512] on 700 observations (hover_learn's 22 and those of 113 inertial
  measurement units), fast-ppo against PPO of Stable-Baselines3 with the same hyper-parameters on
  the same scenario, in turns; PyTorch has one thread and two, and the better counts.

Writes learner_profile.md and its JSON. Run it on an otherwise idle machine. Exit code 1 if a wide
figure misses its goal.
"""

from __future__ import annotations

import multiprocessing
import re
import statistics
import time
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from skybody import CompiledScenario
from skybody.program import ignoring_interrupts
from skybody.train.__main__ import all_versions
from skybody.train.algorithms import algorithm_of
from skybody.train.hyperparameters import with_settings
from skybody.train.learner import Learner
from skybody.train.presets import preset

from research.common.machine import machine_line, versions_line
from research.common.options import Options, heading
from research.common.pages import head, markdown_table, write_page
from research.common.places import PROGRAMS
from research.common.programs import RunError, output_of
from research.common.training_runs import settings_with

PAGE = "learner_profile"

SCENARIO = "hover_learn"
LEARNERS = ("fast-ppo", "gradient")
PATIENCE = 300.0  # s, for one process

# 22 observations and 113 times 6 are 700.
UNITS = 113
_NAMES = [f"imu{k}" for k in range(UNITS)]
WIDE_OVERRIDES = (
    "sensors=["
    + ", ".join(f"{{plugin: imu, name: {name}, parameters: {{period: 20}}}}" for name in _NAMES)
    + "]",
    "observe=[" + ", ".join(f"{name}.angular_rate, {name}.specific_force" for name in _NAMES) + "]",
)
WIDE = {
    "envs": 64,
    "rollout_steps": 32,
    "minibatch": 1024,
    "epochs": 5,
    "value_epochs": 5,
    "hidden": "512,512",
}
WIDE_STEPS = 5 * 64 * 32  # five iterations
QUICK_STEPS, QUICK_WIDE_STEPS = 60_000, 2 * 64 * 32  # two
LEAST_AGAINST_SB3, LEAST_OF_PRODUCTS = 1.2, 0.8


# --- one learner in its own process -------------------------------------------------------------


def learn(wanted: dict[str, Any], results: multiprocessing.Queue[dict[str, Any]]) -> None:
    """Iterates a learner; puts its rate, its shares of time and its update's seconds per step."""
    algorithm, overrides = wanted["algorithm"], list(wanted["overrides"])
    row = algorithm_of(algorithm)
    base = preset(SCENARIO, algorithm).hyper if wanted["preset"] else row.defaults()
    hyper = with_settings(base, wanted["settings"])
    compiled = CompiledScenario(SCENARIO, overrides)
    total = wanted["steps"]
    learner: Learner = row.make(compiled, hyper, 1, wanted["threads"], total)
    learner.iterate()
    before, begun, reports = learner.steps, time.perf_counter(), []
    while learner.steps < total:
        reports.append(learner.iterate())
    seconds, steps = time.perf_counter() - begun, learner.steps - before
    parts = {
        name: sum(getattr(report, f"{name}_seconds") for report in reports)
        for name in ("environment", "inference", "update")
    }
    results.put(
        {
            "steps_per_second": steps / seconds,
            "shares": {name: value / seconds for name, value in parts.items()},
            "update_seconds_per_step": parts["update"] / steps,
            "observations": compiled.observation_size,
            "actions": compiled.action_size,
        }
    )
    learner.close()


def measure(algorithm: str, threads: int, steps: int, **more: Any) -> dict[str, Any]:
    """The result of learn() in a new process, from the second iteration to `steps`."""
    wanted = {"preset": True, "overrides": (), "settings": (), **more}
    wanted |= {"algorithm": algorithm, "threads": threads, "steps": steps}
    context = multiprocessing.get_context("spawn")
    results = context.Queue()
    process = context.Process(target=learn, args=(wanted, results))
    with ignoring_interrupts():
        process.start()
    found: dict[str, Any] = results.get(timeout=PATIENCE)
    process.join()
    return found


# --- floating-point operations ------------------------------------------------------------------


def operations(sizes: Sequence[int]) -> int:
    """Operations of a network of these sizes, forward and backward, per sample: matrix products
    only.

    A layer multiplies once forward and twice backward, for the gradients of its weights and of its
    input; the first layer needs no gradient of its input.
    """
    products = [a * b for a, b in pairwise(sizes)]
    return 2 * (2 * products[0] + 3 * sum(products[1:]))


def update_operations(observations: int, actions: int, hyper: Any) -> int:
    """Operations of a whole update of fast-ppo per step: passes of the policy and of the value."""
    policy = operations([observations, *hyper.hidden, actions])
    value = operations([observations, *hyper.hidden, 1])
    both: int = hyper.epochs * policy + hyper.value_epochs * value
    return both


def bare_products(program: Path) -> dict[str, dict[str, float]]:
    """GFLOP/s of bench_learn's rows, forward and backward together, by the network's sizes."""
    printed = output_of([program])
    found: dict[str, dict[str, float]] = {}
    network = ""
    for line in printed.splitlines():
        if head := re.match(r"(\d+(-\d+)+), \d+ rows", line):
            network = head[1]
            found[network] = {}
        elif row := re.match(r"  (\S.*?) +[\d.]+ ns +[\d.]+ GFLOP/s +[\d.]+ ns +([\d.]+)", line):
            found[network][row[1]] = float(row[2])
    return found


# --- the three parts ----------------------------------------------------------------------------


def shares(turns: int, quick: bool) -> list[dict[str, Any]]:
    """One row per learner and number of threads; medians over the turns."""
    rows = []
    for algorithm in LEARNERS:
        for threads in (1, 2):
            steps = QUICK_STEPS if quick else preset(SCENARIO, algorithm).total_steps
            found = [measure(algorithm, threads, steps) for _ in range(turns)]
            row = {"learner": algorithm, "threads": threads, **median(found)}
            if algorithm == "fast-ppo":
                count = update_operations(
                    found[0]["observations"], found[0]["actions"], preset(SCENARIO, algorithm).hyper
                )
                row["update_gflops"] = 1e-9 * count / row["update_seconds_per_step"]
            rows.append(row)
    return rows


def wide(turns: int, quick: bool) -> list[dict[str, Any]]:
    """fast-ppo, and ppo with one thread of PyTorch and with two, in turns; medians."""
    contestants = {
        "fast-ppo": ("fast-ppo", {}),
        "ppo, 1 thread of PyTorch": ("ppo", {"torch_threads": 1}),
        "ppo, 2 threads of PyTorch": ("ppo", {"torch_threads": 2}),
    }
    found: dict[str, list[dict[str, Any]]] = {name: [] for name in contestants}
    for _ in range(turns):
        for name, (algorithm, more) in contestants.items():
            settings = settings_with({**WIDE, **more}, algorithm)
            options = {"preset": False, "overrides": WIDE_OVERRIDES, "settings": settings}
            steps = QUICK_WIDE_STEPS if quick else WIDE_STEPS
            found[name].append(measure(algorithm, 2, steps, **options))
    hyper = with_settings(
        algorithm_of("fast-ppo").defaults(), [f"{k}={v}" for k, v in WIDE.items()]
    )
    rows = []
    for name, results in found.items():
        row = {"learner": name, "threads": 2, **median(results)}
        count = update_operations(results[0]["observations"], results[0]["actions"], hyper)
        row["update_gflops"] = 1e-9 * count / row["update_seconds_per_step"]
        rows.append(row)
    return rows


def median(found: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The median of each figure."""
    return {
        "steps_per_second": statistics.median(f["steps_per_second"] for f in found),
        "shares": {
            name: statistics.median(f["shares"][name] for f in found) for name in found[0]["shares"]
        },
        "update_seconds_per_step": statistics.median(f["update_seconds_per_step"] for f in found),
    }


def ratios(content: dict[str, Any]) -> dict[str, float]:
    """The ratios that have goals."""
    ours, *others = content["wide"]
    products = content["products"]["700-512-512-4"]
    best = next(name for name in ("ours, v4", "ours, v3", "ours, v2") if name in products)
    return {
        "against_sb3": ours["steps_per_second"] / max(o["steps_per_second"] for o in others),
        "of_products": products[best] / products["Eigen, products alone"],
        "update_of_products": content["shares"][0]["update_gflops"]
        / content["products"]["22-64-64-4"]["Eigen, products alone"],
    }


# --- the page -----------------------------------------------------------------------------------


def markdown(content: dict[str, Any]) -> str:
    """The whole page."""
    found = content["ratios"]
    return f"""\
# Where learners spend their time

    {content["command"]}

on {machine_line(content["machine"])}; medians of {content["turns"]} turns.

## Shares

`{SCENARIO}` to the end with the shipped hyper-parameters. Environment: steps of physics, rewards
and ends. Inference: the rest of a rollout, which is the policy's forward passes with normalization
and noise. Update: all that follows the rollout, of fast-ppo values and advantages, too, of
`gradient` the way back through the horizon.
GFLOP/s of the update: the floating-point operations of the networks' matrix products (forward, and
both backward ones), by the seconds of the whole update, with losses, activations, gathering of rows
and Adam.

{_shares_table(content["shares"])}

## Matrix products

GFLOP/s on one thread, forward and backward, 1,024 rows (`bench_learn`). "Products alone" is Eigen's
GEMM on the same shapes, without biases and activations.

{_products_table(content["products"])}

On one thread fast-ppo's whole update of `{SCENARIO}` does {found["update_of_products"]:.2f} of what
these products alone do (22-64-64-4).

## Wide networks: [512, 512] on 700 observations

`{SCENARIO}` with {UNITS} inertial measurement units, all observed: 22 + {UNITS} x 6 = 700. Both
learners have {", ".join(f"{key} {value}" for key, value in WIDE.items())},
and two threads for the environments (fast-ppo's also learn).

{_shares_table(content["wide"])}

fast-ppo against the better `ppo`: {found["against_sb3"]:.2f} times its steps/s (goal:
{LEAST_AGAINST_SB3}). Its networks on one thread against bare products of the same shapes:
{found["of_products"]:.2f} (goal: {LEAST_OF_PRODUCTS}).

Versions: {versions_line([content])}.
"""


def _shares_table(rows: Sequence[dict[str, Any]]) -> str:
    table = [
        head("learner | threads | steps/s | environment | inference | update | update [GFLOP/s]")
    ]
    for row in rows:
        parts = [f"{100 * share:.0f} %" for share in row["shares"].values()]
        rate = f"{row['update_gflops']:.0f}" if "update_gflops" in row else "-"
        start = (row["learner"], row["threads"], f"{row['steps_per_second']:,.0f}")
        table.append([*start, *parts, rate])
    return markdown_table(table)


def _products_table(products: dict[str, dict[str, float]]) -> str:
    names = list(next(iter(products.values())))
    rows = [[network, *(f"{row[name]:.0f}" for name in names)] for network, row in products.items()]
    return markdown_table([["network", *names], *rows])


# --- the command line ---------------------------------------------------------------------------


def main(arguments: list[str] | None = None) -> int:
    """Measures, writes; returns the exit code."""
    bench_learn = PROGRAMS / "bench_learn"
    options = (
        Options(__doc__, __name__, "one turn of two iterations", bench_learn)
        .add("--turns", type=int, default=3, help="turns of each measurement; default: 3")
        .given(arguments)
    )
    options.turns = 1 if options.quick else options.turns
    if options.turns < 1:
        raise RunError(f"--turns {options.turns}: at least 1")
    content: dict[str, Any] = {
        **heading("profile of the learners", options),
        "versions": all_versions(CompiledScenario(SCENARIO), "ppo"),
        "turns": options.turns,
        "products": bare_products(options.program),
        "shares": shares(options.turns, options.quick),
        "wide": wide(options.turns, options.quick),
    }
    content["ratios"] = ratios(content)
    write_page(options.out, PAGE, markdown(content), content)
    found = content["ratios"]
    good = found["against_sb3"] >= LEAST_AGAINST_SB3 and found["of_products"] >= LEAST_OF_PRODUCTS
    return 0 if good or options.quick else 1
