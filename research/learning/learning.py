"""Tasks learned with their presets, by three seeds each, and flight errors of their policies.

    python -m research run learning [--scenarios NAME...] [--no-training] [--quick]
    python -m research run learning --check [--scenarios NAME...]

Run folders are kept in --runs: finished runs are not repeated, interrupted ones are resumed. A run
trained elsewhere is used if its folder is put there under its name, SCENARIO-seed-N.
Checkpoints fly 20 episodes each; `skybody run` flies the last one in 100 drawn episodes
that occur neither in training nor in those evaluations. Rows of the page whose runs are not
repeated are kept while scenario and preset are unchanged, or if a scenario has a new hash but the
run's first rollout and its update have the same bits. --check trains every run of the page again up
to its first checkpoint and compares the hash over all parameters; exit code 1 if one differs.
Writes learning.md, its JSON and pictures; learned_tables.py copies the JSON's figures to the
READMEs of tasks.
"""

from __future__ import annotations

import argparse
import dataclasses
import datetime
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from skybody import CompiledScenario, Error
from skybody.train.algorithms import algorithm_of
from skybody.train.checkpoint import checkpoint_folders, read_meta
from skybody.train.evaluate import SEED as EVALUATION_SEED
from skybody.train.evaluate import evaluate_checkpoint
from skybody.train.evaluation_file import read_evaluation
from skybody.train.hashing import parameter_hash
from skybody.train.learner import Learner
from skybody.train.policy_file import read_policy, shipped_policy
from skybody.train.presets import preset
from skybody.train.run_folder import read_table

from research.common.machine import machine
from research.common.options import Options
from research.common.pages import write_json, write_page
from research.common.places import PROGRAM
from research.common.training_runs import Run
from research.learning.learning_courses import COURSES, Course
from research.learning.learning_flight import SEED, fly
from research.learning.learning_report import draw, markdown

EPISODES, CHECKPOINT_EPISODES = 100, 20
QUICK_STEPS, QUICK_EPISODES = 20_000, 4
CURVE_POINTS = 40  # of a run, in the JSON
PAGE = "learning"
Row = dict[str, Any]


# --- runs ---------------------------------------------------------------------------------------


def make_run(course: Course, seed: int, out: Path, threads: int = 0, quick: bool = False) -> Run:
    """The run of a course with its preset.

    Settings that change no bits (threads, evaluations during training) come from the folder, if
    any.
    """
    folder = out / f"{course.scenario}-seed-{seed}"
    run = Run(
        folder=folder,
        scenario=course.scenario,
        algorithm=course.algorithm,
        seed=seed,
        total_steps=QUICK_STEPS if quick else preset(course.scenario, course.algorithm).total_steps,
        threads=threads,
        eval_episodes=0,
    )
    if not (folder / "config.json").exists():
        return run
    found = run.config()
    return dataclasses.replace(run, threads=found["threads"], eval_episodes=found["eval_episodes"])


def is_finished(run: Run) -> bool:
    """Whether it has reached its end; makes missing evaluations."""
    return dataclasses.replace(run, eval_episodes=0).finished()


def train(run: Run) -> None:
    """Trains it to its end, unless it is finished, and prints notes."""
    run.check()
    if not is_finished(run):
        print(f"{run.folder.name}: trains, {run.total_steps:,} steps", flush=True)
        run.train()
        write_json(run.folder / "machine.json", machine())


def evaluate(run: Run, episodes: int) -> list[Row]:
    """Evaluations of all checkpoints, oldest first; makes the missing ones."""
    found = []
    for checkpoint in checkpoint_folders(run.folder):
        row = read_evaluation(checkpoint)
        if row is None:
            row = evaluate_checkpoint(checkpoint, episodes, EVALUATION_SEED)
            write_json(checkpoint / "evaluation.json", row)
        found.append(row)
    return found


# --- the beginning of a run, again --------------------------------------------------------------


def learner(course: Course, seed: int, total_steps: int) -> Learner:
    """A run's learner before its first rollout."""
    compiled = CompiledScenario(course.scenario)
    hyper = preset(course.scenario, course.algorithm).hyper
    return algorithm_of(course.algorithm).make(compiled, hyper, seed, 0, total_steps)


def start(course: Course, seed: int, total_steps: int) -> Row:
    """Steps and hash after the first rollout and its update."""
    begun = learner(course, seed, total_steps)
    begun.iterate()
    return {"steps": begun.steps, "parameter_hash": parameter_hash(begun.parameters())}


def is_same(row: Row) -> bool:
    """Whether a row's run reaches the same first checkpoint when it is trained again."""
    course = next(c for c in COURSES if c.scenario == row["scenario"])
    again, first = learner(course, row["seed"], row["total_steps"]), row["first_checkpoint"]
    while again.steps < first["steps"]:
        again.iterate()
    return parameter_hash(again.parameters()) == first["parameter_hash"]


def check(rows: Sequence[Row]) -> int:
    """Trains the first part of all rows again; returns the exit code."""
    differ = 0
    for row in rows:
        same = is_same(row)
        differ += not same
        steps = row["first_checkpoint"]["steps"]
        verdict = "the same" if same else "DIFFERS"
        print(f"{row['scenario']}, seed {row['seed']}: {verdict} after {steps:,} steps", flush=True)
    print(f"{len(rows)} runs, {differ} differ")
    return 1 if differ else 0


# --- rows ---------------------------------------------------------------------------------------


def what_decides(course: Course, total_steps: int) -> Row:
    """Values that determine a run's bits, apart from the seed."""
    hyper = dataclasses.asdict(preset(course.scenario, course.algorithm).hyper)
    return {
        "scenario_hash": f"{CompiledScenario(course.scenario).scenario_hash:016x}",
        "total_steps": total_steps,
        "hyper": [f"{name}={value}" for name, value in hyper.items()],
    }


def row_decides(row: Row, course: Course) -> Row:
    """The same values of a row; a hyper-parameter that is newer than the row had its default."""
    known = dict(text.split("=", 1) for text in row["hyper"])
    defaults = type(preset(course.scenario, course.algorithm).hyper)()
    hyper = [f"{n}={known.get(n, value)}" for n, value in dataclasses.asdict(defaults).items()]
    return {
        "scenario_hash": row["scenario_hash"],
        "total_steps": row["total_steps"],
        "hyper": hyper,
    }


def record(course: Course, run: Run, options: argparse.Namespace) -> Row:
    """A finished run's row."""
    evaluations = evaluate(run, options.checkpoint_episodes)
    flights = fly(options.program, run, options.episodes)
    folders = checkpoint_folders(run.folder)
    first, last = read_meta(folders[0]), read_meta(folders[-1])
    figures = [limit.figure(flights) for limit in course.learned]
    met = [limit.is_met(x) for limit, x in zip(course.learned, figures, strict=True)]
    error = flights.last_second[course.error] if course.error else np.array([])
    noted = run.folder / "machine.json"
    end = datetime.datetime.fromtimestamp((folders[-1] / "meta.json").stat().st_mtime, datetime.UTC)
    return {
        "scenario": course.scenario,
        "seed": run.seed,
        **what_decides(course, run.total_steps),
        "steps": last["steps"],
        "seconds": last["wall_clock"],
        "threads": run.threads,
        "date": f"{end:%Y-%m-%d}",
        "machine": json.loads(noted.read_text()) if noted.exists() else None,
        "versions": versions(run),
        "learned": all(met),
        "figures": [limit.shown(x) for limit, x in zip(course.learned, figures, strict=True)],
        "median_error": float(np.median(error)) if len(error) else None,
        "flights": flights.line,
        "failed": int(flights.failed.sum()),
        "episodes": len(flights.failed),
        "parameter_hash": last["parameter_hash"],
        "is_shipped": is_shipped(course.scenario, folders[-1]),
        "start": start(course, run.seed, run.total_steps),
        "first_checkpoint": {x: first[x] for x in ("steps", "parameter_hash")},
        "checkpoints": [
            {x: e[x] for x in ("steps", "wall_clock", "reached_share", "success_share")}
            for e in evaluations
        ],
        "curve": curve(run),
    }


def versions(run: Run) -> dict[str, str]:
    """Versions at the start of the run, except those of plugins."""
    found = run.config()["versions"]
    return {name: text for name, text in found.items() if not name.startswith("plugin ")}


def is_shipped(scenario: str, checkpoint: Path) -> bool:
    """Whether the shipped policy has the same weights as this one."""
    try:
        mine, theirs = read_policy(checkpoint / "policy.h5"), read_policy(shipped_policy(scenario))
    except (OSError, ValueError, Error):
        return False
    return len(mine.layers) == len(theirs.layers) and all(
        np.array_equal(a.weight, b.weight) for a, b in zip(mine.layers, theirs.layers, strict=True)
    )


def curve(run: Run) -> dict[str, list[float | None]]:
    """Training's mean return of the last 100 episodes over steps and seconds, thinned."""
    rows = read_table(run.folder / "progress.csv")
    places = np.unique(np.linspace(0, len(rows) - 1, CURVE_POINTS).round().astype(int))
    found: dict[str, list[float | None]] = {}
    for name in ("steps", "wall_clock", "recent_return_mean"):
        values = [float(rows[place][name]) for place in places]
        found[name] = [round(x, 3) if np.isfinite(x) else None for x in values]
    return found


def is_of_today(row: Row, course: Course) -> bool:
    """Whether a row's run would be the same today.

    A new parameter changes a scenario's hash: then the first rollout and its update must have the
    same bits.
    """
    total = preset(course.scenario, course.algorithm).total_steps
    was, now = row_decides(row, course), what_decides(course, total)
    if was | {"scenario_hash": ""} != now | {"scenario_hash": ""}:
        return False
    return was == now or start(course, row["seed"], total) == row["start"]


def kept(path: Path, courses: Sequence[Course]) -> list[Row]:
    """Rows of an earlier page whose runs would be the same today."""
    if not path.exists():
        return []
    by_name = {course.scenario: course for course in courses}
    rows = []
    for row in json.loads(path.read_text())["runs"]:
        course = by_name.get(row["scenario"])
        if course and row["seed"] in course.seeds and is_of_today(row, course):
            rows.append(row)
            continue
        print(f"{row['scenario']}, seed {row['seed']}: is another run by now, its row goes")
    return rows


def rows_of(options: argparse.Namespace, earlier: Sequence[Row]) -> list[Row]:
    """All rows in the courses' order: of existing or new runs, otherwise the earlier row."""
    before = {(row["scenario"], row["seed"]): row for row in earlier}
    rows = []
    for course in COURSES:
        for seed in course.seeds[: options.seeds]:
            run = make_run(course, seed, options.runs, options.threads, options.quick)
            if course.scenario in options.scenarios and options.training:
                train(run)
            if (run.folder / "config.json").exists() and is_finished(run):
                run.check()
                rows.append(record(course, run, options))
                say(rows[-1])
            elif (course.scenario, seed) in before:
                rows.append(before[course.scenario, seed])
    return rows


def lean(content: Row) -> str:
    """JSON with one line for each innermost list or map."""
    text = json.dumps(content, indent=1)
    innermost = re.compile(r"[\[{]\n[^\[\]{}]*[\]}]")
    return innermost.sub(lambda found: re.sub(r"\n *", " ", found[0]), text) + "\n"


def say(row: Row) -> None:
    """Prints a line on a row."""
    print(
        f"{row['scenario']}, seed {row['seed']}: {', '.join(row['figures'])}; "
        f"{'learned' if row['learned'] else 'NOT LEARNED'}; {row['flights']}",
        flush=True,
    )


# --- the command line ---------------------------------------------------------------------------


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line's values, checked."""
    names = [course.scenario for course in COURSES]
    of_names: dict[str, Any] = {"nargs": "+", "choices": names, "default": names}
    options = (
        Options(__doc__, __name__, "one seed, few steps", PROGRAM)
        .of_runs()
        .add("--scenarios", help="scenarios to train or check; default: all", **of_names)
        .add("--no-training", dest="training", action="store_false", help="use finished runs")
        .add("--threads", type=int, default=0, help="0: one per processor; changes no bits")
        .add("--check", action="store_true", help="train the page's runs to their first checkpoint")
        .given(arguments)
    )
    options.episodes = QUICK_EPISODES if options.quick else EPISODES
    options.checkpoint_episodes = QUICK_EPISODES if options.quick else CHECKPOINT_EPISODES
    options.seeds = 1 if options.quick else None
    return options


def main(arguments: list[str] | None = None) -> int:
    """Trains, flies, writes; returns the exit code."""
    options = parse(arguments)
    path = options.out / "data/learning.json"
    earlier = [] if options.quick else kept(path, COURSES)
    if options.check:
        return check([row for row in earlier if row["scenario"] in options.scenarios])
    rows = rows_of(options, earlier)
    content = {
        "experiment": "learning",
        "command": "python -m research run learning" + " --quick" * options.quick,
        "machine": machine(),
        "flights": {"episodes": options.episodes, "seed": SEED},
        "runs": rows,
    }
    for over in ("steps", "seconds"):
        draw(rows, over, options.out / f"images/learning_{over}.png")
    keeps = any(row in earlier for row in rows)
    write_page(options.out, PAGE, markdown(content, COURSES), keeps=keeps)
    path.write_text(lean(content))
    return 0
