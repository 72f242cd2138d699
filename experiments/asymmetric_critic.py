#!/usr/bin/env python3
"""Does a critic with privileged observations help the policy of a pendulum?

    .venv/bin/python experiments/asymmetric_critic.py [--seeds 5] [--jobs N] [--quick]

`pendulum_learn_randomized` is trained with its preset and fewer steps: with a critic (value
function) that observes the privileged columns (derivatives, mass, inertia and lags), and with one
that has the policy's observations. Observations of the policy, rewards, draws and hyper-parameters
are the same. The comparison covers the critic's accuracy about returns, training's own returns, and
100 held-out flights of each last policy. Finished runs are not repeated, and interrupted ones are
resumed. Writes asymmetric_critic.md, its JSON and a picture.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from domain_randomization import difference
from learning_flight import fly
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from skybody.program import run_program
from skybody.train.run_folder import read_table
from training_runs import (
    ROOT,
    Run,
    RunError,
    changed_hyper,
    command_line,
    machine,
    machine_line,
    page_data,
    shown,
    train_all,
    versions_line,
    write_json,
)

SCENARIO = "pendulum_learn_randomized"
PROGRAM = ROOT / "build/release/bin/skybody"
STEPS, QUICK_STEPS = 6_000_000, 60_000
EPISODES, QUICK_EPISODES = 100, 5
LAST = 0.1  # share of a run whose returns count as final
POINTS = 60  # of a curve
KINDS = {"asymmetric": (), "symmetric": ("task.parameters.privileged=false",)}
COLORS = {"asymmetric": "C0", "symmetric": "C1"}
Row = dict[str, Any]
# Compared figures: key, name in the table, factor, format.
FIGURES = (
    (
        "explained",
        "variance of returns that the critic tells, mean of training [%]",
        100.0,
        ".1f",
    ),
    ("return", "return of training, mean over it", 1.0, ".0f"),
    ("last_return", "return of training, in its last tenth", 1.0, ".0f"),
    ("succeeded", "held-out flights that succeed [%]", 100.0, ".0f"),
)


def make_run(options: argparse.Namespace, kind: str, seed: int) -> Run:
    """The run of one policy."""
    return Run(
        folder=options.out / f"{kind}-seed-{seed}",
        scenario=SCENARIO,
        algorithm="fast-ppo",
        seed=seed,
        total_steps=QUICK_STEPS if options.quick else STEPS,
        threads=1,
        overrides=KINDS[kind],
        checkpoints=1,
        eval_episodes=0,
    )


def record(run: Run, kind: str, episodes: int) -> Row:
    """The curve of a finished run, and the flights of its policy."""
    rows = read_table(run.folder / "progress.csv")
    column = {
        name: np.array([float(row[name]) for row in rows])
        for name in ("steps", "recent_return_mean", "explained_variance")
    }
    returns = column["recent_return_mean"]
    late = column["steps"] > (1.0 - LAST) * run.total_steps
    every = max(1, len(rows) // POINTS)
    points = zip(column["steps"][::every], returns[::every], strict=True)
    flights = fly(PROGRAM, run, episodes)
    return {
        "kind": kind,
        "seed": run.seed,
        "explained": float(np.nanmean(column["explained_variance"])),
        "return": float(np.nanmean(returns)),
        "last_return": float(np.nanmean(returns[late])),
        "succeeded": float(flights.succeeded.mean()),
        "curve": [[float(s), round(float(r), 2)] for s, r in points if np.isfinite(r)],
        "hyper": changed_hyper(run.config()),
        "versions": run.config()["versions"],
    }


def of_kind(records: Sequence[Row], kind: str, key: str) -> list[float]:
    """A figure of each seed."""
    return [r[key] for r in records if r["kind"] == kind]


def row_of(records: Sequence[Row], key: str, name: str, factor: float, form: str) -> str:
    """A line of the table: both kinds, and their difference."""
    both = [[factor * x for x in of_kind(records, kind, key)] for kind in KINDS]
    gap, half = difference(both[1], both[0])
    cells = [f"{np.mean(x):{form}} ({min(x):{form}} to {max(x):{form}})" for x in both]
    return f"| {name} | {cells[0]} | {cells[1]} | {gap:+{form}} +- {half:{form}} |"


def answer(records: Sequence[Row]) -> str:
    """The answer in one sentence, by the returns of training."""
    both = [of_kind(records, kind, "return") for kind in KINDS]
    gap, half = difference(both[1], both[0])
    if abs(gap) <= half:
        return "No difference can be told between returns with and without the privileged columns."
    helps = "helps" if gap > 0.0 else "does harm"
    return f"It {helps}: returns over training differ by more than chance (95 % interval)."


def markdown(content: Row) -> str:
    """The page."""
    records = content["runs"]
    table = [
        "| | critic sees privileged columns | critic sees what the policy sees "
        "| difference, 95 % interval |",
        "| --- | ---: | ---: | ---: |",
        *(row_of(records, *figure) for figure in FIGURES),
    ]
    return f"""\
# A critic that sees more

Does it help the inverted pendulum's policy that its critic is shown derivatives, mass, inertia and
lags, which it does not see itself? By

    {content["command"]}

on {machine_line(content["machine"])}.

{answer(records)}

{chr(10).join(table)}

Means over {content["seeds"]} seeds of each, with the least and the greatest; intervals are Welch's.
`{SCENARIO}`, {content["total_steps"]:,} steps a run, a third of its preset's, after which learning
is still under way. Hyper-parameters of the preset: {", ".join(records[0]["hyper"])}.
A flight succeeds as the task says (upright to the end, bob near its target).

![Return over steps](images/asymmetric_critic.png)

Versions: {versions_line(records)}.
"""


def draw(records: Sequence[Row], path: Path) -> None:
    """Return over steps, one line per seed."""
    figure = Figure(figsize=(6.4, 3.8), layout="constrained")
    canvas = FigureCanvasAgg(figure)
    axis = figure.subplots()
    for kind, color in COLORS.items():
        for index, run in enumerate(r for r in records if r["kind"] == kind):
            if not run["curve"]:
                continue
            steps, returns = np.array(run["curve"]).T
            label = f"{kind} critic" if index == 0 else None
            axis.plot(steps / 1e6, returns, color=color, linewidth=1.0, label=label)
    axis.set(title=SCENARIO, xlabel="million steps", ylabel="return of training")
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8)
    path.parent.mkdir(parents=True, exist_ok=True)
    canvas.print_png(path)


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line's values, checked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--seeds", type=int, default=5, help="number of seeds of each kind, at least 2; default: 5")
    add("--jobs", type=int, default=2, help="parallel runs; default: 2")
    add("--out", type=Path, default=ROOT / "flights/asymmetric_critic", help="folder of the runs")
    add("--report", type=Path, help="folder of the page; default: docs/results")
    add("--quick", action="store_true", help="a trial: 2 seeds, short runs, report in --out")
    options = parser.parse_args(arguments)
    options.report = options.report or (options.out if options.quick else ROOT / "docs/results")
    options.seeds = 2 if options.quick else options.seeds
    if options.seeds < 2 or options.jobs < 1:
        parser.error("--seeds must be 2 or more and --jobs 1 or more")
    return options


def main(arguments: list[str] | None = None) -> int:
    """Trains, flies, writes; returns the exit code."""
    options = parse(arguments)
    seeds = range(1, options.seeds + 1)
    runs = [(kind, make_run(options, kind, seed)) for seed in seeds for kind in KINDS]
    try:
        train_all([run for _, run in runs], options.jobs, lambda run: run.folder.name)
        episodes = QUICK_EPISODES if options.quick else EPISODES
        records = [record(run, kind, episodes) for kind, run in runs]
    except RunError as error:
        print(f"asymmetric_critic: {error}", file=sys.stderr)
        return 2
    given = sys.argv[1:] if arguments is None else arguments
    content = {
        "experiment": "asymmetric critic",
        "command": command_line("asymmetric_critic.py", given),
        "machine": machine(),
        "seeds": options.seeds,
        "total_steps": runs[0][1].total_steps,
        "runs": records,
    }
    write_json(options.report / "data/asymmetric_critic.json", content)
    draw(records, options.report / "images/asymmetric_critic.png")
    text = markdown(content)
    page_data.write(options.report / "asymmetric_critic.md", text)
    print(f"{text}\nwritten: {shown(options.report / 'asymmetric_critic.md')}")
    return 0


if __name__ == "__main__":
    run_program(main)
