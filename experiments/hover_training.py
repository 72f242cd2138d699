#!/usr/bin/env python3
"""Learns to hover with each learner, three seeds each, and measures quality and time.

    .venv/bin/python experiments/hover_training.py [--out DIR] [--program build/release/bin/skybody]

The runs are made one after another, with the shipped hyper-parameters and without other load: wall
clock is that of the whole command `skybody train`, from its start to its exit. Then every
checkpoint flies 100 episodes in a new process. `lean-ppo` (experiments/yardstick), in PyTorch, is
the reference for the learners in C++. The page also has fast-ppo on hover.yaml (K = 1, the
paper's), a run shared with training_reproducibility.py. Finally fast-ppo's policy of the first seed
is flown by `skybody run`, and its actions are compared with those computed by PyTorch.

Finished runs are not repeated; an interrupted one begins again, because its time counts. Run
it on an otherwise idle machine. Exit code 1 if a run misses a limit.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import training_reproducibility
from hover_report import draw, markdown
from policy_flight import PICTURE, fly_policy
from result_pages import add_quick, heading, option_parser, place_quick, write_page
from skybody import CompiledScenario
from skybody.program import module_command, run_program
from skybody.train.checkpoint import checkpoint_folders
from skybody.train.evaluation_file import read_evaluation
from skybody.train.presets import preset
from training_runs import (
    ROOT,
    Run,
    RunError,
    train_all,
    write_json,
)
from yardstick import command as yardstick

SCENARIO = "hover_learn"
SEEDS = (1, 2, 3)
YARDSTICK = (str(Path(yardstick.__file__)),)
SECONDS = {"fast-ppo": 30.0, "gradient": 5.0, "lean-ppo": 180.0}  # limits of wall clock
MOST_ERROR, LEAST_SUCCESS = 0.05, 0.98  # median [m]; share of episodes without failure
CHECKPOINTS = 20  # points of a curve
REPRODUCIBILITY = "training_reproducibility_fast-ppo"  # folder of those runs
EPISODES = 100


def shipped_steps(algorithm: str) -> int:
    """Environment steps of a whole run."""
    if algorithm == yardstick.NAME:
        return yardstick.TOTAL_STEPS
    return preset(SCENARIO, algorithm).total_steps


def shipped(algorithm: str) -> dict[str, Any]:
    """Further arguments of Run; the yardstick is a separate program."""
    if algorithm == yardstick.NAME:
        return {"settings": yardstick.SETTINGS, "program": YARDSTICK}
    return {}


def make_runs(out: Path, steps: dict[str, int], seeds: Sequence[int]) -> list[Run]:
    """All runs, the fast learners' first. They make no evaluations during training."""
    return [
        Run(
            folder=out / f"{algorithm}-seed-{seed}",
            scenario=SCENARIO,
            algorithm=algorithm,
            seed=seed,
            total_steps=steps[algorithm],
            checkpoints=CHECKPOINTS,
            eval_episodes=0,
            **shipped(algorithm),
        )
        for algorithm in steps
        for seed in seeds
    ]


# --- training, alone ----------------------------------------------------------------------------


def measure(run: Run) -> dict[str, Any]:
    """Trains and returns the times [s]; for a finished run, its recorded times.

    `wall_clock` is the whole command's. `published` has, by the checkpoint's folder, the time from
    the command to the moment at which the folder got its final name: then it can be flown.
    """
    run.check()
    path = run.folder / "measured.json"
    if not path.exists():
        shutil.rmtree(run.folder, ignore_errors=True)
        load, begun = os.getloadavg()[0], time.time()
        run.train()
        seconds = time.time() - begun
        # A folder's ctime is the time of its renaming, until an evaluation is written into it.
        published = {
            folder.name: folder.stat().st_ctime - begun for folder in checkpoint_folders(run.folder)
        }
        write_json(path, {"wall_clock": seconds, "load_before": load, "published": published})
    measured: dict[str, Any] = json.loads(path.read_text())
    return measured


def evaluate(run: Run) -> None:
    """Evaluates the checkpoints without an evaluation, each in a new process."""
    for checkpoint in checkpoint_folders(run.folder):
        evaluate_checkpoint(checkpoint)


def evaluate_checkpoint(checkpoint: Path) -> None:
    """Flies EPISODES in a new process, unless an evaluation exists."""
    found = read_evaluation(checkpoint)
    if found is not None and found["episodes"] == EPISODES:
        return
    command = module_command("skybody.train.evaluate", str(checkpoint))
    command += ["--episodes", str(EPISODES), "--json", str(checkpoint / "evaluation.json")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RunError(f"{' '.join(command)}\n{done.stderr}")


def curve(run: Run) -> dict[str, Any]:
    """Curve of the evaluations, and the divisor that makes returns comparable."""
    keep = ("steps", "wall_clock", "return_mean", "position_error_median", "success_share")
    points = [{name: evaluation[name] for name in keep} for evaluation in run.evaluations()]
    return {"horizon": CompiledScenario(run.scenario, list(run.overrides)).horizon, "curve": points}


def record(run: Run, measured: dict[str, float]) -> dict[str, Any]:
    """A run's row in the table, and its curve."""
    last = run.evaluations()[-1]
    errors = np.array([np.nan if e is None else e for e in last["position_errors"]], float)
    median, seconds = float(np.nanmedian(errors)), measured["wall_clock"]
    return {
        "learner": run.algorithm,
        "seed": run.seed,
        "steps": last["steps"],
        "wall_clock": measured["wall_clock"],
        "load_before": measured["load_before"],
        "episodes": last["episodes"],
        "median_error": median,
        "error_90_percent": float(np.nanpercentile(errors, 90)),
        "failures": int(sum(last["failed"])),
        "success_share": last["success_share"],
        "within_limits": bool(
            median < MOST_ERROR
            and last["success_share"] >= LEAST_SUCCESS
            and seconds <= SECONDS[run.algorithm]
        ),
        "parameter_hash": last["parameter_hash"],
        **curve(run),
    }


def evaluate_all(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """The rows of measured runs; prints a line on each."""
    records = []
    for run in runs:
        evaluate(run)
        row = record(run, measure(run))
        print(
            f"{row['learner']}, seed {row['seed']}: {row['wall_clock']:.1f} s, median error "
            f"{row['median_error']:.4f} m, {row['failures']} failures of {row['episodes']}",
            flush=True,
        )
        records.append(row)
    return records


def hover_curve(out: Path, steps: int) -> dict[str, Any]:
    """Curve on hover.yaml: the first run of training_reproducibility.py, made if missing."""
    group = training_reproducibility.make_groups("hover", out, steps, 2, "fast-ppo")[0]
    run = group.runs[0]
    train_all([run], 1, training_reproducibility.say)
    return {
        "learner": run.algorithm,
        "seed": run.seed,
        "overrides": list(run.overrides),
        **curve(run),
    }


# --- the command line ---------------------------------------------------------------------------


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line's values, checked."""
    parser = option_parser(__doc__)
    add = parser.add_argument
    steps = {algorithm: shipped_steps(algorithm) for algorithm in SECONDS}
    defaults = ", ".join(f"{name} {number:,}" for name, number in steps.items())
    add("--steps", type=float, help=f"steps of all runs, for a trial; default: {defaults}")
    add("--seeds", type=int, nargs="+", default=list(SEEDS), help="seeds; default: 1 2 3")
    add_quick(parser, "a rollout of each run")
    add(
        "--reproducibility",
        type=Path,
        help="folder --out of training_reproducibility.py, for the curve of hover.yaml",
    )
    add(
        "--hover-steps",
        type=float,
        default=training_reproducibility.STEPS,
        help="steps of that run; default: 500,000",
    )
    add(
        "--program",
        type=Path,
        default=ROOT / "build/release/bin/skybody",
        help="program that flies the policy",
    )
    add(
        "--train-only",
        action="store_true",
        help="only train; a later call, perhaps under other load, evaluates and writes",
    )
    options = parser.parse_args(arguments)
    place_quick(options, "hover_training")
    if options.quick:
        options.steps, options.hover_steps, options.seeds = 1, 1, [1]
    runs = options.out if options.quick else ROOT / "flights"
    options.reproducibility = options.reproducibility or runs / REPRODUCIBILITY
    options.steps = steps if options.steps is None else dict.fromkeys(steps, int(options.steps))
    options.hover_steps = int(options.hover_steps)
    if not options.program.exists():
        parser.error(f"--program {options.program} does not exist; ./dev build makes it")
    return options


def main(arguments: list[str] | None = None) -> int:
    """Trains, evaluates, flies, writes; returns the exit code."""
    options = parse(arguments)
    runs = make_runs(options.out, options.steps, options.seeds)
    report: Path = options.report
    (report / "images").mkdir(parents=True, exist_ok=True)
    try:
        for run in runs:
            measure(run)
        if options.train_only:
            return 0
        records = evaluate_all(runs)
        hover = hover_curve(options.reproducibility, options.hover_steps)
        flight = fly_policy(options.program, runs[0], options.out / "flight")
    except RunError as error:
        print(f"hover_training: {error}", file=sys.stderr)
        return 2
    shutil.copyfile(options.out / "flight" / PICTURE, report / "images/hover_policy.png")
    content = {
        **heading("hover training", "hover_training.py", arguments),
        "limits": {
            "median_error": MOST_ERROR,
            "success_share": LEAST_SUCCESS,
            "seconds": SECONDS,
        },
        "config": {run.algorithm: run.config() for run in runs},
        "runs": records,
        "hover": hover,
        "flight": flight,
    }
    draw(content, report / "images/hover_training.png")
    write_page(report, "hover_training", content, markdown(content))
    is_good = options.quick or all(row["within_limits"] for row in records)
    return 0 if is_good and flight["agrees"] else 1


if __name__ == "__main__":
    run_program(main)
