#!/usr/bin/env python3
"""Does a policy learn faster through a controller? The question of figure 10 of the GzDRL paper.

    .venv/bin/python experiments/control_abstractions.py [--tasks trajectory payload] [--seeds 5]
        [--out DIR] [--quick]

A policy commands rotor speeds (end-to-end), or a force that an attitude controller converts into
rotor speeds at every physics step (modular). The following are the same in both: vehicle, rotors
with their lag, physics, action rate, observations except the action, rewards, draws and
hyper-parameters (those of the scenarios' presets). The comparison covers the steps until the error
in training is below a threshold; the final policy flies held-out episodes.
Finished runs are not repeated, and interrupted ones are resumed. Writes control_abstractions.md,
its JSON and a picture.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from control_abstractions_report import draw, markdown
from control_forms import AVERAGED, FORMS, TASKS, Row, own_of
from scipy.stats import permutation_test
from skybody.program import run_program
from skybody.train.presets import preset
from skybody.train.run_folder import read_table
from training_runs import (
    ROOT,
    Run,
    RunError,
    changed_hyper,
    command_line,
    machine,
    page_data,
    shown,
    train_all,
    write_json,
)

QUICK_STEPS = 60_000
SAMPLES = 10_000  # of the bootstrap


def make_runs(options: argparse.Namespace, task: str, form: str) -> list[Run]:
    """The runs of one form of a task, one per seed."""
    compared = TASKS[task]
    return [
        Run(
            folder=options.out / f"{task}-{form}-seed-{seed}",
            scenario=compared.scenarios[form],
            algorithm="fast-ppo",
            seed=seed,
            total_steps=QUICK_STEPS if options.quick else compared.total_steps,
            threads=options.threads,
            overrides=compared.overrides,
            checkpoints=1,
        ).with_threads_of_folder()
        for seed in range(1, options.seeds + 1)
    ]


def require_like_presets(task: str) -> None:
    """Raises RunError if the presets of the two forms differ."""
    hypers = [preset(name, "fast-ppo").hyper for name in TASKS[task].scenarios.values()]
    if any(hyper != hypers[0] for hyper in hypers):
        raise RunError(f"the presets of {', '.join(TASKS[task].scenarios.values())} differ")


def record(run: Run, task: str, form: str) -> Row:
    """The curve of a finished run, and the flights of its policy."""
    rows = read_table(run.folder / "progress.csv")
    steps = np.array([float(row["steps"]) for row in rows])
    errors = averaged(steps, np.array([float(row["position_error"]) for row in rows]))
    known = steps >= AVERAGED
    below = {t: np.flatnonzero((errors < t) & known) for t in TASKS[task].thresholds}
    found = run.evaluations()[-1]
    every = max(1, len(rows) // 60)
    return {
        "task": task,
        "form": form,
        "seed": run.seed,
        "total_steps": run.total_steps,
        "steps": {f"{t:g}": float(steps[k[0]]) if k.size else None for t, k in below.items()},
        "last_error": float(errors[-1]),
        "curve": [[float(s), round(float(e), 4)] for s, e in zip(steps, errors, strict=True)][
            ::every
        ],
        "final_error": found["position_error_mean"],
        "final_success": found["success_share"],
        "hyper": changed_hyper(run.config()),
        "versions": run.config()["versions"],
    }


def averaged(steps: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """The mean over the last AVERAGED steps, at each rollout."""
    known = np.isfinite(errors)
    sums = np.concatenate([[0.0], np.cumsum(np.where(known, errors, 0.0))])
    counts = np.concatenate([[0], np.cumsum(known)])
    first = np.searchsorted(steps, steps - AVERAGED, side="right")
    last = np.arange(len(steps)) + 1
    return (sums[last] - sums[first]) / np.maximum(counts[last] - counts[first], 1)


# --- comparing ----------------------------------------------------------------------------------


def interval(samples: np.ndarray) -> tuple[float, float]:
    """95 % interval."""
    low, high = np.quantile(samples, [0.025, 0.975])
    return float(low), float(high)


def compare(records: Sequence[Row], task: str, threshold: float) -> Row:
    """Means of both forms with intervals, and of their ratio, by the bootstrap over seeds.

    `chance`: probability of a ratio at least as far from 1 if the forms were equal, by all
    assignments of the runs to them (exact permutation test).
    """
    random = np.random.default_rng(1)
    samples: dict[str, np.ndarray] = {}
    found_steps = []
    forms: Row = {}
    for form in FORMS:
        own = own_of(records, task, form)
        found = [r["steps"][f"{threshold:g}"] for r in own]
        # A run that did not reach the threshold counts with all its steps.
        pairs = zip(found, own, strict=True)
        steps = np.array([r["total_steps"] if s is None else s for s, r in pairs], float)
        found_steps.append(steps)
        samples[form] = random.choice(steps, (SAMPLES, len(steps))).mean(axis=1)
        forms[form] = {
            "seeds": len(steps),
            "arrived": sum(s is not None for s in found),
            "mean": float(steps.mean()),
            "interval": interval(samples[form]),
        }
    return {
        "task": task,
        "threshold": threshold,
        "forms": forms,
        "ratio": forms["end-to-end"]["mean"] / forms["modular"]["mean"],
        "ratio_interval": interval(samples["end-to-end"] / samples["modular"]),
        "chance": float(permutation_test(found_steps, log_ratio, n_resamples=np.inf).pvalue),
    }


def log_ratio(one: np.ndarray, other: np.ndarray) -> float:
    """Logarithm of the ratio of the means; 0: they are equal."""
    return float(np.log(one.mean() / other.mean()))


# --- the command line ---------------------------------------------------------------------------


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line's values."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--tasks", nargs="+", choices=list(TASKS), default=list(TASKS), help="tasks; default: all")
    add("--seeds", type=int, default=5, help="number of seeds of each form (5)")
    add("--jobs", type=int, default=1, help="parallel runs (1)")
    add(
        "--threads",
        type=int,
        default=0,
        help="threads of a run; 0: one per processor; changes no bits",
    )
    add(
        "--out", type=Path, default=ROOT / "flights/control_abstractions", help="folder of the runs"
    )
    add("--report", type=Path, help="folder of the page; default: docs/results")
    add("--quick", action="store_true", help="a trial: two seeds, few steps, report in --out")
    options = parser.parse_args(arguments)
    options.report = options.report or (options.out if options.quick else ROOT / "docs/results")
    options.seeds = 2 if options.quick else options.seeds
    if options.seeds < 2 or options.jobs < 1:
        parser.error("--seeds must be 2 or more and --jobs 1 or more")
    return options


def main(arguments: list[str] | None = None) -> int:
    """Trains, compares, writes; returns the exit code."""
    options = parse(arguments)
    made = {
        (task, form): make_runs(options, task, form) for task in options.tasks for form in FORMS
    }
    by_seed = [run for runs in zip(*made.values(), strict=True) for run in runs]
    try:
        for task in options.tasks:
            require_like_presets(task)
        train_all(by_seed, options.jobs, lambda run: run.folder.name)
        records = [record(run, *key) for key, runs in made.items() for run in runs]
    except RunError as error:
        print(f"control_abstractions: {error}", file=sys.stderr)
        return 2
    given = sys.argv[1:] if arguments is None else arguments
    content = {
        "experiment": "control abstractions",
        "command": command_line("control_abstractions.py", given),
        "machine": machine(),
        "comparisons": [
            compare(records, task, threshold)
            for task in options.tasks
            for threshold in TASKS[task].thresholds
        ],
        "runs": records,
    }
    write_json(options.report / "data/control_abstractions.json", content)
    draw(records, options.tasks, options.report / "images/control_abstractions.png")
    text = markdown(content)
    page_data.write(options.report / "control_abstractions.md", text)
    print(f"{text}\nwritten: {shown(options.report / 'control_abstractions.md')}")
    return 0


if __name__ == "__main__":
    run_program(main)
