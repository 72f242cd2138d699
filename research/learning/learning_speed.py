"""Time until each learner hovers, in seconds from the command.

    python -m research run learning_speed [--algo fast-ppo ppo] [--out DIR] [--quick]

Three seeds of each learner (ten of `gradient`, one of `ppo`, which is cut), one after another, with
the shipped hyper-parameters and without other load. `ppo`, of Stable-Baselines3, is the reference
of rates. Seconds are from the command to the moment at which a checkpoint can be flown. Then every
checkpoint flies 100 held-out episodes. Writes learning_speed.md, its JSON and the picture of error
over seconds. Finished runs are not repeated; an interrupted one begins again, because its time
counts. Run it on an otherwise idle machine; with --train-only it evaluates and
writes in a later call, which may run on a loaded machine.

With --rl-tools FOLDER the published hover training of rl_tools is compared with them. The folder is
the result of `git clone https://github.com/rl-tools/rl-tools`; g++ compiles it.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from skybody.train.algorithms import ALGORITHMS
from skybody.train.checkpoint import checkpoint_folders
from skybody.train.presets import preset
from skybody.train.run_folder import read_table

from research.common.machine import machine_line, versions_line
from research.common.options import Options, heading
from research.common.pages import head, markdown_table, write_page
from research.common.plots import LEARNER_COLORS, LIMIT, panels, plain_logarithms, save
from research.common.training_runs import Run
from research.learning import rl_tools
from research.learning.timed_runs import EPISODES, evaluate, measure

PAGE = "learning_speed"

SCENARIO = "hover_learn"
SEEDS = {"gradient": range(1, 11), "ppo": (1,)}  # others:
MOST_SEEDS = (1, 2, 3)
STEPS = {"ppo": 7_500_000}  # half of the shipped number; others: all
QUICK_STEPS = 100_000
CHECKPOINT_STEPS = {"gradient": 175_000}  # between two points of a curve; others:
MOST_CHECKPOINT_STEPS = 500_000
LIMITS = (0.1, 0.03)  # m, median over the episodes
LEAST_SUCCESS = 0.98


def make_runs(out: Path, algorithms: Sequence[str], quick: bool) -> list[Run]:
    """All runs, in their order of execution."""
    runs = []
    for algorithm in algorithms:
        whole = STEPS.get(algorithm, preset(SCENARIO, algorithm).total_steps)
        steps = QUICK_STEPS if quick else whole
        every = CHECKPOINT_STEPS.get(algorithm, MOST_CHECKPOINT_STEPS)
        seeds = [1] if quick else SEEDS.get(algorithm, MOST_SEEDS)
        for seed in seeds:
            runs.append(
                Run(
                    folder=out / f"{algorithm}-seed-{seed}",
                    scenario=SCENARIO,
                    algorithm=algorithm,
                    seed=seed,
                    total_steps=steps,
                    checkpoints=max(2, steps // every),
                    eval_episodes=0,
                )
            )
    return runs


def record(run: Run) -> dict[str, Any]:
    """Evaluates a measured run; returns its curve, rates and shares."""
    measured = measure(run)
    for checkpoint in checkpoint_folders(run.folder):
        evaluate(checkpoint)
    evaluations, rows = run.evaluations(), read_table(run.folder / "progress.csv")
    written = [measured["published"][folder.name] for folder in checkpoint_folders(run.folder)]
    points = [
        {
            "steps": found["steps"],
            "seconds": seconds,
            "median_error": found["position_error_median"],
            "success_share": found["success_share"],
            "return_mean": found["return_mean"],
        }
        for found, seconds in zip(evaluations, written, strict=True)
    ]
    rates = [float(row["steps_per_second"]) for row in rows]
    shares = {
        name: statistics.fmean(float(row[f"{name}_share"]) for row in rows)
        for name in ("environment", "inference", "update")
    }
    return {
        "learner": run.algorithm,
        "seed": run.seed,
        "seconds": measured["wall_clock"],
        "steps_per_second": statistics.median(rates),
        "shares": shares,
        "reached": {str(limit): reached(points, limit) for limit in LIMITS},
        "points": points,
        "parameter_hash": evaluations[-1]["parameter_hash"],
        "hyper": run.config()["hyper"],
        "versions": run.config()["versions"],
    }


def reached(points: Sequence[dict[str, Any]], limit: float) -> float | None:
    """Seconds to the first checkpoint below the limit; None: there is none."""
    for point in points:
        if point["median_error"] < limit and point["success_share"] >= LEAST_SUCCESS:
            return float(point["seconds"])
    return None


def by_learner(records: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """One row per learner. The slowest seed counts; None if one does not reach the limit."""
    rows = []
    for learner in dict.fromkeys(record["learner"] for record in records):
        own = [record for record in records if record["learner"] == learner]
        row: dict[str, Any] = {"learner": learner, "seeds": len(own)}
        row["steps_per_second"] = statistics.median(r["steps_per_second"] for r in own)
        for limit in LIMITS:
            seconds = [r["reached"][str(limit)] for r in own]
            row[f"seconds_to_{limit}"] = slowest(seconds)
            row[f"arrived_{limit}"] = sum(one is not None for one in seconds)
        row["final_error"] = max(r["points"][-1]["median_error"] for r in own)
        rows.append(row | _of_ours(own))
    return rows


def _of_ours(records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Figures that only learners on our tasks have."""
    if "shares" not in records[0]:
        return {"final_return": None, "shares": {}}
    parts = records[0]["shares"]
    shares = {name: statistics.fmean(r["shares"][name] for r in records) for name in parts}
    return {"final_return": min(r["points"][-1]["return_mean"] for r in records), "shares": shares}


def slowest(seconds: Sequence[float | None]) -> float | None:
    """The largest; None if one of them is None."""
    known = [value for value in seconds if value is not None]
    return max(known) if len(known) == len(seconds) else None


# --- the page -----------------------------------------------------------------------------------


def markdown(content: dict[str, Any]) -> str:
    """The whole page."""
    limits = " | ".join(f"< {limit} m [s]" for limit in LIMITS)
    names = f"learner | seeds | steps/s | against ppo | {limits} | worst final median [m]"
    names += " | least final return | environment / inference / update"
    rows = [head(names), *(_row(row, content["learners"]) for row in content["learners"])]
    table = markdown_table(rows, (0, len(rows[0]) - 1))
    return f"""\
# Speed of learning

How long each learner takes to hover (`{SCENARIO}`), by

    {content["command"]}

on {machine_line(content["machine"])}.

![Median error over seconds from the command](images/learning_speed.png)

{table}

steps/s: median over the rollouts, with the update. Seconds: from the command to the moment at which
the first checkpoint can be flown (one every {MOST_CHECKPOINT_STEPS:,} steps; of `gradient` every
{CHECKPOINT_STEPS["gradient"]:,}) whose median error over {EPISODES} held-out episodes is below the
limit with at least {100 * LEAST_SUCCESS:.0f} % without failure; of the slowest seed, and only where
all arrive (else how many do). The error is a mean over an episode's last second. Shares are of
training's wall clock.

Finished runs are kept, so that learners may have been measured in several calls: the versions below
name each source.

{chr(10).join(_notes(content))}
Versions: {versions_line([run for run in content["runs"] if "versions" in run])}.
"""


def _notes(content: dict[str, Any]) -> list[str]:
    """A paragraph on each learner with notes."""
    there = {row["learner"] for row in content["learners"]}
    notes = []
    if "ppo" in there:
        notes.append(
            f"`ppo` is that of Stable-Baselines3: one seed, and {STEPS['ppo']:,} of the "
            f"{preset(SCENARIO, 'ppo').total_steps:,}\nsteps that it is shipped with, its "
            "schedules shortened likewise.\n"
        )
    if rl_tools.LEARNER in there:
        notes.append(rl_tools.note(content["rl_tools"], EPISODES))
    wanted = (*ALGORITHMS, rl_tools.LEARNER)
    if missing := [name for name in wanted if name not in there]:
        notes.append(f"Not run: {', '.join(missing)}.\n")
    return notes


def _row(row: dict[str, Any], rows: Sequence[dict[str, Any]]) -> list[str]:
    ppo = [r["steps_per_second"] for r in rows if r["learner"] == "ppo"]
    ratio = f"{row['steps_per_second'] / ppo[0]:.2f}" if ppo else "-"
    times = [
        f"{row['arrived_' + str(limit)]} of {row['seeds']}"
        if row[f"seconds_to_{limit}"] is None
        else f"{row[f'seconds_to_{limit}']:.2f}"
        for limit in LIMITS
    ]
    shares = " / ".join(f"{100 * share:.0f} %" for share in row["shares"].values()) or "-"
    final = "-" if row["final_return"] is None else f"{row['final_return']:.1f}"
    cells = [row["learner"], str(row["seeds"]), f"{row['steps_per_second']:,.0f}", ratio, *times]
    return [*cells, f"{row['final_error']:.4f}", final, shares]


def draw(records: Sequence[dict[str, Any]], out: Path) -> None:
    """Error over seconds, both logarithmic; one line per seed."""
    figure, axes = panels(1, 1, (8, 4.6))
    axis = axes[0, 0]
    named: set[str] = set()
    for run in records:
        points, learner = run["points"], run["learner"]
        label = None if learner in named else learner
        named.add(learner)
        axis.plot(
            [p["seconds"] for p in points],
            [p["median_error"] for p in points],
            color=LEARNER_COLORS.get(learner, "0.4"),
            marker="o",
            markersize=2.5,
            linewidth=1.2,
            label=label,
        )
    for limit in LIMITS:
        axis.axhline(limit, **LIMIT)
    axis.set_xscale("log")
    axis.set_yscale("log")
    plain_logarithms(axis.xaxis, axis.yaxis)
    axis.set(xlabel="seconds from the command", ylabel="median position error [m]")
    axis.legend(fontsize=8)
    save(figure, out)


# --- the command line ---------------------------------------------------------------------------


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line's values."""
    there, checkout = list(ALGORITHMS), "checkout of rl_tools, to run it as well"
    return (
        Options(__doc__, __name__, "one seed, few steps")
        .of_runs()
        .add("--algo", nargs="+", choices=there, default=there, help="learners; default: all")
        .add("--rl-tools", type=Path, metavar="FOLDER", help=checkout)
        .add("--train-only", action="store_true", help="evaluate and write in a later call")
        .given(arguments)
    )


def peers(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Records of rl_tools."""
    program = rl_tools.build(options.rl_tools, options.runs)
    seeds = [1] if options.quick else MOST_SEEDS
    records = [rl_tools.record(program, seed, options.runs) for seed in seeds]
    for found in records:
        found["reached"] = {str(limit): reached(found["points"], limit) for limit in LIMITS}
        tell(found)
    return records


def tell(found: dict[str, Any]) -> dict[str, Any]:
    """Prints a line on a record."""
    print(
        f"{found['learner']}, seed {found['seed']}: {found['seconds']:.1f} s, "
        f"{found['steps_per_second']:,.0f} steps/s, median error "
        f"{found['points'][-1]['median_error']:.4f} m",
        flush=True,
    )
    return found


def main(arguments: list[str] | None = None) -> int:
    """Trains, evaluates, writes; returns the exit code."""
    options = parse(arguments)
    runs = make_runs(options.runs, options.algo, options.quick)
    if options.rl_tools:
        rl_tools.check(options.rl_tools)
    for run in runs:
        measure(run)
    records = peers(options) if options.rl_tools else []
    if options.train_only:
        return 0
    records = [tell(record(run)) for run in runs] + records
    if options.rl_tools:  # no path of this machine
        options.command = options.command.replace(str(options.rl_tools), "FOLDER")
    content = {
        **heading("speed of learning", options),
        "learners": by_learner(records),
        "runs": records,
        "rl_tools": rl_tools.facts(options.rl_tools) if options.rl_tools else None,
    }
    draw(records, options.out / "images/learning_speed.png")
    write_page(options.out, PAGE, markdown(content), content)
    return 0
