#!/usr/bin/env python3
"""The GzDRL paper's training study on this machine: how long do its runs take here?

    .venv/bin/python experiments/paper_protocol.py TASK... [--algo ppo fast-ppo] [--transitions N]

The paper's runs of each task (a scenario) and learner: networks of [512, 512], seeds 1, 25 and 42
(or those of --seeds), 15 environments each, 5,000,000 transitions; `ppo` is that of
Stable-Baselines3. The runs of a learner are made in parallel, as in the paper; wall clock is that
of the slowest, including interrupted parts. With --transitions the runs are shorter, and the time
for all transitions is extrapolated from the rate between the first checkpoint and the last; the
table states this. Finished runs are not repeated, and interrupted ones are resumed.

With --learned nothing is trained: the run of the first of --seeds, complete or not, is shown with
its curve, and its last policy flies 100 held-out episodes. Such runs may share the machine.

Writes paper_protocol.md, its JSON and a picture of the learning curves; earlier tasks and learners
are kept in it.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from learning_flight import fly
from paper_protocol_report import draw, markdown
from skybody import CompiledScenario, InputError
from skybody.program import run_program
from skybody.train.algorithms import algorithm_of
from skybody.train.checkpoint import checkpoint_folders, read_meta
from skybody.train.run_folder import read_table
from training_runs import (
    ROOT,
    Run,
    RunError,
    command_line,
    machine,
    page_data,
    shown,
    train_all,
    write_json,
)

SEEDS = (1, 25, 42)
TRANSITIONS, QUICK_TRANSITIONS = 5_000_000, 62_000
CHECKPOINTS = 20
PROGRAM = ROOT / "build/release/bin/skybody"
EPISODES = 100  # of held-out flights
POINTS = 80  # of a curve
ERRORS = ("payload_error", "position_error")  # infos [m]: the first that a task has
# The paper's sizes. The rest are Stable-Baselines3's defaults, which the paper does not change. All
# hyper-parameters of both learners are here: a task's preset is not part of the study.
SIZES = {
    "hidden": "512,512",
    "envs": 15,
    "rollout_steps": 2048,
    "minibatch": 1024,
    "epochs": 10,
    "value_epochs": 10,
    "learning_rate": 3e-4,
    "final_learning_rate": 1,
    "discount": 0.99,
    "gae_lambda": 0.95,
    "clip_range": 0.2,
    "target_kl": 0,
    "entropy_weight": 0,
    "value_weight": 0.5,
    "max_grad_norm": 0.5,
    "log_std": 0,
    "final_log_std": 0,
    "bounded_mean": "false",
    "squashed": "false",
    "shared_policy": "false",
    "recurrent_units": 0,
    "activation": "tanh",
    "normalize_rewards": "true",
    "observation_clip": 10,
    "normalization_steps": 0,
    "averaging_steps": 0,
    "torch_threads": 1,
}


def settings(algorithm: str) -> tuple[str, ...]:
    """SIZES as arguments of --set, without those that the learner does not have."""
    known = vars(algorithm_of(algorithm).defaults())
    return tuple(f"{name}={value}" for name, value in SIZES.items() if name in known)


def make_runs(
    task: str, algorithm: str, out: Path, transitions: int, seeds: Sequence[int] = SEEDS
) -> list[Run]:
    """One run per seed. They evaluate after training, so that it has all processors."""
    return [
        Run(
            folder=out / Path(task).stem / f"{algorithm}-seed-{seed}",
            scenario=task,
            algorithm=algorithm,
            seed=seed,
            total_steps=transitions,
            threads=1,
            settings=settings(algorithm),
            checkpoints=CHECKPOINTS,
            eval_episodes=0,
        )
        for seed in seeds
    ]


def train_together(runs: Sequence[Run]) -> None:
    """Trains all runs of a learner in parallel; finished ones are kept."""
    train_all(runs, len(runs), say)


def say(run: Run) -> str:
    """One line on a finished run."""
    meta = read_meta(checkpoint_folders(run.folder)[-1])
    return f"{run.scenario}, {run.algorithm}, seed {run.seed}: {meta['wall_clock']:.0f} s"


def figures(runs: Sequence[Run]) -> dict[str, Any]:
    """A row of the table. The total time is that of all transitions, extrapolated if necessary.

    The wall clock is the slowest run's, from its last checkpoint: a killed run continues
    from the time of its previous checkpoint.
    """
    first, last = ([read_meta(checkpoint_folders(run.folder)[k]) for run in runs] for k in (0, -1))
    steps, seconds = sum(meta["steps"] for meta in last), max(meta["wall_clock"] for meta in last)
    slowest = max(
        (b["wall_clock"] - a["wall_clock"]) / max(1, b["steps"] - a["steps"])
        for a, b in zip(first, last, strict=True)
    )
    left = max(0, TRANSITIONS - min(meta["steps"] for meta in last))
    return {
        "task": runs[0].scenario,
        "learner": runs[0].algorithm,
        "runs": len(runs),
        "transitions": last[0]["steps"],
        "seconds": seconds,
        "steps_per_second": steps / seconds,
        "minutes_for_all": (seconds + left * slowest) / 60.0,
        "extrapolated": left > 0,
        "parameter_hashes": [meta["parameter_hash"] for meta in last],
    }


# --- learning results ---------------------------------------------------------------------------


def curve(run: Run) -> dict[str, list[float | None]]:
    """Over transitions: return and error [m] of training, in blocks of rollouts; None: unknown."""
    rows = read_table(run.folder / "progress.csv")
    blocks = np.array_split(np.arange(len(rows)), min(POINTS, len(rows)))
    columns = {"steps": "steps", "return": "recent_return_mean", "error": "position_error"}
    found: dict[str, list[float | None]] = {}
    for name, column in columns.items():
        values = np.array([float(row[column]) for row in rows])
        means = [float(np.mean(values[block])) for block in blocks]
        found[name] = [float(f"{x:.5g}") if np.isfinite(x) else None for x in means]
    return found


def learned(run: Run, command: str) -> dict[str, Any]:
    """A run's curve, and the flights of its last policy if the task defines success."""
    found: dict[str, Any] = {
        "task": run.scenario,
        "learner": run.algorithm,
        "seed": run.seed,
        "transitions": read_meta(checkpoint_folders(run.folder)[-1])["steps"],
        "curve": curve(run),
        "command": command,
    }
    if "success" not in {info.name for info in CompiledScenario(run.scenario).info_channels}:
        return found
    flights = fly(PROGRAM, run, EPISODES)
    error = next((name for name in ERRORS if name in flights.last_second), None)
    found["flown"] = {
        "episodes": len(flights.failed),
        "succeeded": int(flights.succeeded.sum()),
        "failed": int(flights.failed.sum()),
        "median_error": float(np.median(flights.last_second[error])) if error else None,
    }
    return found


# --- the command line ---------------------------------------------------------------------------


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line's values, checked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("tasks", nargs="+", metavar="TASK", help="scenarios")
    add("--algo", nargs="+", choices=("ppo", "fast-ppo"), default=["fast-ppo", "ppo"])
    add(
        "--transitions", type=float, help=f"transitions at which runs end; default: {TRANSITIONS:,}"
    )
    add(
        "--seeds",
        type=int,
        nargs="+",
        choices=SEEDS,
        default=SEEDS,
        help="seeds of the paper; default: all",
    )
    add("--out", type=Path, default=ROOT / "flights/paper_protocol", help="folder of the runs")
    add("--report", type=Path, help="folder of the page; default: docs/results")
    add("--learned", action="store_true", help="train nothing: show the results of the runs so far")
    add(
        "--quick", action="store_true", help=f"a trial: one seed, {QUICK_TRANSITIONS:,} transitions"
    )
    options = parser.parse_args(arguments)
    wanted = options.transitions or (QUICK_TRANSITIONS if options.quick else TRANSITIONS)
    options.transitions = int(wanted)
    options.seeds = options.seeds[:1] if options.quick else options.seeds
    least = SIZES["envs"] * SIZES["rollout_steps"]  # type: ignore[operator]
    if not 2 * least <= options.transitions <= TRANSITIONS:
        parser.error(f"--transitions {options.transitions}: {2 * least} to {TRANSITIONS}")
    options.report = options.report or (options.out if options.quick else ROOT / "docs/results")
    return options


def merged(earlier: list[dict[str, Any]], rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """`rows`, after the earlier ones of other tasks and learners."""
    new = {(row["task"], row["learner"]) for row in rows}
    return [row for row in earlier if (row["task"], row["learner"]) not in new] + rows


def main(arguments: list[str] | None = None) -> int:
    """Trains, writes; returns the exit code."""
    options = parse(arguments)
    command = command_line("paper_protocol.py", sys.argv[1:] if arguments is None else arguments)
    rows: list[dict[str, Any]] = []
    curves: list[dict[str, Any]] = []
    try:
        for task in options.tasks:
            CompiledScenario(task)  # mistakes are reported before training
        for task in options.tasks:
            for algorithm in options.algo:
                runs = make_runs(task, algorithm, options.out, options.transitions, options.seeds)
                if options.learned:
                    curves.append(learned(runs[0], command))
                    continue
                train_together(runs)
                rows.append({**figures(runs), "command": command, "machine": machine()})
    except (InputError, RunError) as error:
        print(f"paper_protocol: {error}", file=sys.stderr)
        return 2
    path = options.report / "data/paper_protocol.json"
    earlier = json.loads(path.read_text()) if path.exists() else {}
    content = {
        "experiment": "the paper's training protocol",
        "hyper": SIZES,
        "rows": merged(earlier.get("rows", []), rows),
        "learned": merged(earlier.get("learned", []), curves),
    }
    write_json(path, content)
    draw(content["learned"], options.report / "images/paper_protocol.png")
    text = markdown(content)
    keeps = content["rows"] != rows or content["learned"] != curves
    page_data.write(options.report / "paper_protocol.md", text, keeps=keeps)
    print(f"{text}\nwritten: {shown(options.report / 'paper_protocol.md')}")
    return 0


if __name__ == "__main__":
    run_program(main)
