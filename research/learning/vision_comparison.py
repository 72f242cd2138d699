"""Policies that learn from images, beside blind ones and ones that see the state.

    python -m research run vision_comparison [--scenarios NAME...] [--seeds 1] [--jobs N] [--quick]

Each scenario is trained with its preset three times: as it is; blind, without images in the
observation; and with the state, without images but with all columns that the scenario reserves for
the critic. Rewards, draws and hyper-parameters are the same. Each last policy flies 100 held-out
episodes, judged as in learning.md. Finished runs are not repeated, and interrupted ones are
resumed; runs of the scenario as it is are those of `research run learning`, which may be put into
--runs. Writes vision_comparison.md, its JSON and a picture.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from skybody import CompiledScenario
from skybody._native import shipped_scenarios
from skybody.train.run_folder import read_table

from research.common.machine import machine_line, versions_line
from research.common.options import Options, heading
from research.common.pages import head, markdown_table, write_page
from research.common.places import PROGRAM
from research.common.plots import panels, save
from research.common.training_runs import Run, train_all
from research.learning.learning import EPISODES, QUICK_EPISODES, make_run
from research.learning.learning_courses import COURSES, Course, Share
from research.learning.learning_flight import fly

PAGE = "vision_comparison"

IMAGES, BLIND, STATE = "images", "blind", "state"
KINDS = {IMAGES: "C0", BLIND: "0.5", STATE: "C2"}  # with the colours of their lines
# Scenarios whose task observes more of the state if asked: overrides.
MORE_STATE = {"obstacles_vision": ("task.parameters.nearest=5",)}
SCENARIOS = ("obstacles_vision", "racing_vision", "landing_vision")
POINTS = 60  # of a curve
TASK = "task."  # beginning of the channels of a task's own columns
Row = dict[str, Any]


# --- runs ---------------------------------------------------------------------------------------


def channel_of(entry: str | Row) -> str:
    """The channel of an entry of `observe`."""
    return entry if isinstance(entry, str) else str(entry["channel"])


def observed(scenario: str, kind: str) -> list[str | Row]:
    """The entries of `observe` of a kind without images.

    A task's column is the policy's unless an entry makes it privileged.
    """
    compiled = CompiledScenario(scenario)
    images = {column.source for column in compiled.observation_columns if column.image >= 0}
    entries = yaml.safe_load(compiled.scenario_text)["observe"]
    kept = [entry for entry in entries if channel_of(entry) not in images]
    if kind == BLIND:
        return kept
    for_policy = [entry for entry in kept if not channel_of(entry).startswith(TASK)]
    return [x if isinstance(x, str) else x | {"privileged": False} for x in for_policy]


def overrides_of(scenario: str, kind: str) -> tuple[str, ...]:
    """The overrides of a scenario's run."""
    if kind == IMAGES:
        return ()
    more = MORE_STATE.get(scenario, ()) if kind == STATE else ()
    return (f"observe={json.dumps(observed(scenario, kind))}", *more)


def course_of(scenario: str) -> Course:
    """The scenario's criteria in learning.md; the task's success while it has none."""
    found = (course for course in COURSES if course.scenario == scenario)
    return next(found, Course(scenario, (Share(0.9),)))


def run_of(options: argparse.Namespace, scenario: str, kind: str, seed: int) -> Run:
    """The run of one policy."""
    run = make_run(course_of(scenario), seed, options.runs, options.threads, options.quick)
    if kind == IMAGES:
        return run
    folder = options.runs / f"{scenario}-{kind}-seed-{seed}"
    return dataclasses.replace(
        run, folder=folder, overrides=overrides_of(scenario, kind), eval_episodes=0
    )


def curve_of(run: Run) -> list[list[float]]:
    """Steps and mean return of the last 100 episodes, thinned."""
    rows = read_table(run.folder / "progress.csv")
    thinned = rows[:: max(1, len(rows) // POINTS)]
    points = [(float(row["steps"]), float(row["recent_return_mean"])) for row in thinned]
    return [[steps, round(y, 3)] for steps, y in points if np.isfinite(y)]


def record(run: Run, kind: str, options: argparse.Namespace) -> Row:
    """A finished run's figures, and its curve."""
    flights = fly(options.program, run, QUICK_EPISODES if options.quick else EPISODES)
    limits = course_of(run.scenario).learned
    figures = [limit.figure(flights) for limit in limits]
    speeds = flights.whole_flight.get("speed")
    return {
        "scenario": run.scenario,
        "kind": kind,
        "seed": run.seed,
        "steps": run.total_steps,
        "overrides": list(run.overrides),
        "succeeded": float(flights.succeeded.mean()),
        "figures": [limit.shown(x) for limit, x in zip(limits, figures, strict=True)],
        "learned": all(limit.is_met(x) for limit, x in zip(limits, figures, strict=True)),
        "speed": None if speeds is None else float(speeds.mean()),
        "seconds": float(read_table(run.folder / "progress.csv")[-1]["wall_clock"]),
        "curve": curve_of(run),
        "versions": run.config()["versions"],
    }


# --- the page -----------------------------------------------------------------------------------


def cells(rows: Sequence[Row], scenario: str, kind: str) -> list[str]:
    """A line of the table: all seeds of a policy."""
    found = [row for row in rows if (row["scenario"], row["kind"]) == (scenario, kind)]
    speeds = [row["speed"] for row in found if row["speed"] is not None]
    figures = zip(*(row["figures"] for row in found), strict=True)
    return [
        f"`{scenario}`",
        kind,
        ", ".join(f"{100 * row['succeeded']:.0f} %" for row in found),
        "; ".join(", ".join(each) for each in figures),
        f"{sum(row['learned'] for row in found)} of {len(found)}",
        ", ".join(f"{speed:.2f}" for speed in speeds),
        ", ".join(f"{row['seconds']:.0f}" for row in found),
    ]


def markdown(content: Row) -> str:
    """The page."""
    rows = content["runs"]
    names = "scenario | policy | success | figures | reached by seeds | mean speed [m/s] | seconds"
    scenarios = list(dict.fromkeys(row["scenario"] for row in rows))
    table = [head(names), *(cells(rows, name, kind) for name in scenarios for kind in KINDS)]
    criteria = [
        f"- `{name}`, {next(r['steps'] for r in rows if r['scenario'] == name) / 1e6:g} million "
        f"steps: {'; '.join(limit.text for limit in course_of(name).learned)}."
        for name in scenarios
    ]
    return f"""\
# Policies that see images, and policies that do not

Each scenario of vision is learned with its preset by three policies: `{IMAGES}`, the scenario as it
is; `{BLIND}`, without its images; `{STATE}`, without images, but with the columns that otherwise
only the critic observes, and obstacles with the five nearest ones. By

    {content["command"]}

on {machine_line(content["machine"])}.

{markdown_table(table, (0, 1, 3))}

Figures are of {content["episodes"]} held-out episodes of the last checkpoint, a figure a seed; the
criteria are:

{chr(10).join(criteria)}

`mean speed`: the info `speed` over all steps of all flights, in `landing_vision` relative to the
deck. Seconds are training's own; runs may have shared the machine.

![Return over steps](images/{PAGE}.png)

Lines: training's mean return of the last 100 episodes, one line a seed.

Versions: {versions_line(rows)}.
"""


def draw(rows: Sequence[Row], path: Path) -> None:
    """Return over steps, a panel a scenario."""
    scenarios = list(dict.fromkeys(row["scenario"] for row in rows))
    figure, axes = panels(1, len(scenarios), (4.4 * len(scenarios), 3.4))
    for axis, scenario in zip(axes.flat, scenarios, strict=True):
        named = set()
        for row in (row for row in rows if row["scenario"] == scenario and row["curve"]):
            steps, returns = np.array(row["curve"]).T
            kind = row["kind"]
            label = None if kind in named else kind
            named.add(kind)
            axis.plot(steps / 1e6, returns, color=KINDS[kind], linewidth=1.2, label=label)
        axis.set(title=scenario, xlabel="million steps", ylabel="return of training")
        axis.legend(fontsize=8)
    save(figure, path)


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line's values."""
    there = [name for name in SCENARIOS if name in shipped_scenarios()]
    of_names: dict[str, Any] = {"nargs": "+", "choices": there, "default": there}
    parser = Options(__doc__, __name__, "few steps", PROGRAM).of_runs().of_training(1, jobs=1)
    return parser.add("--scenarios", help="default: all", **of_names).given(arguments)


def main(arguments: list[str] | None = None) -> int:
    """Trains, flies, writes; returns the exit code."""
    options = parse(arguments)
    runs = [
        (kind, run_of(options, scenario, kind, seed))
        for scenario in options.scenarios
        for seed in range(1, options.seeds + 1)
        for kind in KINDS
    ]
    train_all([run for _, run in runs], options.jobs, lambda run: run.folder.name)
    content = {
        **heading("vision comparison", options),
        "episodes": QUICK_EPISODES if options.quick else EPISODES,
        "runs": [record(run, kind, options) for kind, run in runs],
    }
    draw(content["runs"], options.out / f"images/{PAGE}.png")
    write_page(options.out, PAGE, markdown(content), content)
    return 0
