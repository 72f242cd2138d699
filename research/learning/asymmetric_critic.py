"""Whether a pendulum's policy gains by a critic with privileged observations.

    python -m research run asymmetric_critic [--seeds 5] [--jobs N] [--quick]

`pendulum_learn_randomized` is trained with its preset and fewer steps: with a critic (value
function) that observes the privileged columns (derivatives, mass, inertia and lags), and with one
that has the policy's observations. Observations of the policy, rewards, draws and hyper-parameters
are the same. The comparison covers the critic's accuracy about returns, training's own returns, and
100 held-out flights of each last policy. Finished runs are not repeated, and interrupted ones are
resumed. Writes asymmetric_critic.md, its JSON and a picture.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from skybody.train.run_folder import read_table

from research.common.machine import machine_line, versions_line
from research.common.options import Options, heading
from research.common.pages import head, markdown_table, write_page
from research.common.places import PROGRAM
from research.common.plots import panels, save
from research.common.programs import RunError
from research.common.training_runs import Run, changed_hyper, train_all
from research.learning.domain_randomization import difference
from research.learning.learning_flight import fly

PAGE = "asymmetric_critic"

SCENARIO = "pendulum_learn_randomized"
STEPS, QUICK_STEPS = 6_000_000, 60_000
EPISODES, QUICK_EPISODES = 100, 5
LAST = 0.1  # share of a run whose returns count as final
POINTS = 60  # of a curve
KINDS = {"asymmetric": (), "symmetric": ("task.parameters.privileged=false",)}
COLORS = {"asymmetric": "C0", "symmetric": "C1"}
Row = dict[str, Any]
# Compared figures: key, name in the table, factor, format.
EXPLAINED = "variance of returns that the critic tells, mean of training [%]"
FIGURES = (
    ("explained", EXPLAINED, 100.0, ".1f"),
    ("return", "return of training, mean over it", 1.0, ".0f"),
    ("last_return", "return of training, in its last tenth", 1.0, ".0f"),
    ("succeeded", "held-out flights that succeed [%]", 100.0, ".0f"),
)


def make_run(options: argparse.Namespace, kind: str, seed: int) -> Run:
    """The run of one policy."""
    return Run(
        folder=options.runs / f"{kind}-seed-{seed}",
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


def row_of(records: Sequence[Row], key: str, name: str, factor: float, form: str) -> list[str]:
    """A line of the table: both kinds, and their difference."""
    both = [[factor * x for x in of_kind(records, kind, key)] for kind in KINDS]
    gap, half = difference(both[1], both[0])
    cells = [f"{np.mean(x):{form}} ({min(x):{form}} to {max(x):{form}})" for x in both]
    return [name, *cells, f"{gap:+{form}} +- {half:{form}}"]


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
    names = " | critic sees privileged columns | critic sees what the policy sees"
    rows = [row_of(records, *figure) for figure in FIGURES]
    table = markdown_table([head(f"{names} | difference, 95 % interval"), *rows])
    return f"""\
# A critic that sees more

Does it help the inverted pendulum's policy that its critic is shown derivatives, mass, inertia and
lags, which it does not see itself? By

    {content["command"]}

on {machine_line(content["machine"])}.

{answer(records)}

{table}

Means over {content["seeds"]} seeds of each, with the least and the greatest; intervals are Welch's.
`{SCENARIO}`, {content["total_steps"]:,} steps a run, a third of its preset's, after which learning
is still under way. Hyper-parameters of the preset: {", ".join(records[0]["hyper"])}.
A flight succeeds as the task says (upright to the end, bob near its target).

![Return over steps](images/asymmetric_critic.png)

Versions: {versions_line(records)}.
"""


def draw(records: Sequence[Row], path: Path) -> None:
    """Return over steps, one line per seed."""
    figure, axes = panels(1, 1, (6.4, 3.8))
    axis = axes[0, 0]
    for kind, color in COLORS.items():
        for index, run in enumerate(r for r in records if r["kind"] == kind):
            if not run["curve"]:
                continue
            steps, returns = np.array(run["curve"]).T
            label = f"{kind} critic" if index == 0 else None
            axis.plot(steps / 1e6, returns, color=color, linewidth=1.0, label=label)
    axis.set(title=SCENARIO, xlabel="million steps", ylabel="return of training")
    axis.legend(fontsize=8)
    save(figure, path)


def main(arguments: list[str] | None = None) -> int:
    """Trains, flies, writes; returns the exit code."""
    parser = Options(__doc__, __name__, "2 seeds, short runs").of_runs().of_training(5)
    options = parser.given(arguments)
    options.seeds = 2 if options.quick else options.seeds
    if options.seeds < 2:
        raise RunError(f"--seeds {options.seeds}: an interval takes 2 at least")
    seeds = range(1, options.seeds + 1)
    runs = [(kind, make_run(options, kind, seed)) for seed in seeds for kind in KINDS]
    train_all([run for _, run in runs], options.jobs, lambda run: run.folder.name)
    episodes = QUICK_EPISODES if options.quick else EPISODES
    records = [record(run, kind, episodes) for kind, run in runs]
    content = {
        **heading("asymmetric critic", options),
        "seeds": options.seeds,
        "total_steps": runs[0][1].total_steps,
        "runs": records,
    }
    draw(records, options.out / "images/asymmetric_critic.png")
    write_page(options.out, PAGE, markdown(content), content)
    return 0
