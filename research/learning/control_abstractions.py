"""Whether a policy learns sooner through a controller (the paper's figure 10).

    python -m research run control_abstractions [--tasks trajectory payload] [--seeds 5]
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
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import permutation_test
from skybody.train.presets import preset
from skybody.train.run_folder import read_table

from research.common.machine import machine_line, versions_line
from research.common.options import Options, heading
from research.common.pages import head, markdown_table, write_page
from research.common.plots import LIMIT, panels, save
from research.common.programs import RunError
from research.common.training_runs import Run, changed_hyper, train_all

PAGE = "control_abstractions"

Row = dict[str, Any]
QUICK_STEPS = 60_000
SAMPLES = 10_000  # of the bootstrap
LEAST_ARRIVED = 0.8  # of the seeds, in both forms: means of fewer are not meaningful
# The answer depends on the learner's settings, so both results must be shown together.
BEFORE = """\
Other settings were run before this one, five seeds each and 4 million steps, which is too few for
most of them:

- `trajectory` with 34 and 33 observations in world axes (`trajectory_compact`, `axes: world`), tanh
  units and three passes of the value function: end-to-end took 0.40 times the steps of modular
  control (95 % interval 0.31 to 0.49; 5 of 5 seeds against 1 of 5 below 0.2 m). With elu units and
  two passes no seed of either form got there.
- `trajectory` with today's 700 and 680 observations and a policy averaged over 100,000 steps: 2 of
  5 seeds end-to-end and 0 of 5 modular ones below 0.2 m.
- `payload` with the paper's reward: no seed of either form below 0.5 m; after the 4 million steps
  the median policy was 3.6 m off end-to-end and 1.3 m modular."""
# Steps over which the error in training is averaged: episodes of `payload` in 256 environments.
AVERAGED = 256_000
COLORS = {"end-to-end": "C1", "modular": "C0"}


@dataclass(frozen=True)
class Compared:
    """A task in both forms."""

    scenarios: dict[str, str]  # by form; their presets are equal
    overrides: tuple[str, ...]  # of both forms
    total_steps: int
    thresholds: tuple[float, ...]  # of the mean error [m]
    doc: str


TASKS = {
    "trajectory": Compared(
        scenarios={"end-to-end": "trajectory", "modular": "trajectory_modular"},
        overrides=("randomization.lissajous.parameters.along=0",),
        total_steps=8_000_000,
        thresholds=(0.5, 0.2, 0.1),
        doc="700 and 680 observations, the heading fixed, which no force commands",
    ),
    "payload": Compared(
        scenarios={"end-to-end": "payload_learn", "modular": "payload_modular_learn"},
        overrides=(),
        total_steps=12_000_000,
        thresholds=(2.0, 1.0),
        doc="26 and 25 observations",
    ),
}
FORMS = tuple(COLORS)


def own_of(records: Sequence[Row], task: str, form: str) -> list[Row]:
    """The records of one form of a task, one per seed."""
    return [r for r in records if (r["task"], r["form"]) == (task, form)]


def make_runs(options: argparse.Namespace, task: str, form: str) -> list[Run]:
    """The runs of one form of a task, one per seed."""
    compared = TASKS[task]
    return [
        Run(
            folder=options.runs / f"{task}-{form}-seed-{seed}",
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


# --- the page -----------------------------------------------------------------------------------


def verdict(row: Row) -> str:
    """The result of a task's comparison, in words."""
    where = f"- `{row['task']}`, {row['threshold']:g} m:"
    arrived = [f"{form['arrived']} of {form['seeds']}" for form in row["forms"].values()]
    if min(form["arrived"] / form["seeds"] for form in row["forms"].values()) < LEAST_ARRIVED:
        return (
            f"{where} {arrived[0]} end-to-end and {arrived[1]} modular seeds get below "
            "the threshold: too few to say which learns sooner."
        )
    low, high = row["ratio_interval"]
    said = "no difference can be told"
    if row["chance"] < 0.05 and not low <= 1.0 <= high:
        sooner = "modular" if low > 1.0 else "end-to-end"
        said = f"{sooner} control learns sooner"
    return (
        f"{where} end-to-end takes {row['ratio']:.2f} times the steps of modular control "
        f"(95 % interval {low:.2f} to {high:.2f}; by chance alone in {100 * row['chance']:.0f} % "
        f"of deals): {said}."
    )


def steps_row(row: Row, form: str) -> list[str]:
    """A line of the table of steps."""
    found = row["forms"][form]
    low, high = (f"{steps / 1e6:.2f}" for steps in found["interval"])
    cells = [row["task"], f"{row['threshold']:g}", form, f"{found['arrived']} of {found['seeds']}"]
    return [*cells, f"{found['mean'] / 1e6:.2f} ({low} to {high})"]


def end_row(records: Sequence[Row], task: str, form: str) -> list[str]:
    """A line of the table of final results."""
    own = own_of(records, task, form)
    training = statistics.median(r["last_error"] for r in own)
    held_out = statistics.median(r["final_error"] for r in own)
    unfailed = statistics.fmean(r["final_success"] for r in own)
    return [task, form, f"{training:.3f}", f"{held_out:.3f}", f"{100 * unfailed:.0f} %"]


def markdown(content: Row) -> str:
    """The whole page."""
    rows, runs = content["comparisons"], content["runs"]
    tasks = [name for name in TASKS if any(r["task"] == name for r in runs)]
    names = "task | threshold [m] | form | seeds below it | millions of steps to it (95 %)"
    steps = [head(names), *(steps_row(row, form) for row in rows for form in FORMS)]
    names = "task | form | error in training [m] | error of held-out flights [m]"
    ends = [head(f"{names} | flights without failure")]
    ends += [end_row(runs, task, form) for task in tasks for form in FORMS]
    about = "\n".join(about_task(task, own_of(runs, task, "modular")[0]) for task in tasks)
    seeds = rows[0]["forms"]["modular"]["seeds"]
    missing = [name for name in TASKS if name not in tasks]
    cut = f"Not run: {', '.join(missing)}.\n\n" if missing else ""
    return f"""\
# Control abstractions

Does a policy learn sooner through a controller (figure 10 of the GzDRL paper)? By

    {content["command"]}

on {machine_line(content["machine"])}.

{chr(10).join(verdict(row) for row in rows)}

A difference is told where the interval leaves out 1 and, besides, fewer than 5 % of all ways to
deal the runs to the two forms give a ratio as far from 1.

![Error over steps](images/control_abstractions.png)

{markdown_table(steps, (0, 2))}

At the end of training:

{markdown_table(ends, (0, 1))}

End-to-end, the policy gives four rotor speeds; modular, a force in world axes, which `force`,
`attitude` and `ctbr` turn into rotor speeds at every physics step (1 kHz). Vehicle, rotors with
their lag, physics, the 100 Hz of the actions, observations but for the action, rewards, draws and
hyper-parameters are the same in both: the scenarios differ in their controllers alone, and their
presets do not differ. (The reward of `trajectory` takes off 0.01 of the squares of the actions,
whatever they are.) The paper compares forms with different actuators.

{about}

The error is that of training, with its noise, a mean over whole episodes: where flights begin
far from the target, as those of `payload`, the way there is in it: a policy that ends 2 cm off
has 0.6 m, so no run gets below the 0.5 m that an earlier version of this page asked for. It is
averaged over {AVERAGED:,} steps. A seed that does not get below a threshold counts with all its
steps, so that means are lower bounds where some do not. Intervals are of the bootstrap over
{seeds} seeds a form, which makes intervals of few seeds too narrow; hence the exact permutation
test besides. Errors at the end are medians over the seeds; that of held-out flights is the mean
over 20 episodes of a deterministic policy, in each its last second. Learning rate and noise fall
over the whole run, so that a longer one arrives later.

## Other settings

{BEFORE}

{cut}The paper's own protocol, one seed of each form, is in [paper_protocol.md](paper_protocol.md).

Versions: {versions_line(runs)}.
"""


def about_task(task: str, run: Row) -> str:
    """The settings of the training."""
    pair = " and ".join(f"`{name}`" for name in TASKS[task].scenarios.values())
    overrides = ", ".join(f"`{override}`" for override in TASKS[task].overrides)
    also = f", both with {overrides}" if overrides else ""
    return (
        f"- `{task}`: {pair}{also}; {TASKS[task].doc}; {run['total_steps']:,} steps a run. "
        f"Hyper-parameters of their presets: {', '.join(run['hyper'])}."
    )


def draw(records: Sequence[Row], tasks: Sequence[str], out: Path) -> None:
    """Error over steps; one line per seed, one panel per task."""
    figure, axes = panels(1, len(tasks), (4.6 * len(tasks), 3.8))
    for axis, task in zip(axes.flat, tasks, strict=True):
        for form, color in COLORS.items():
            for index, run in enumerate(own_of(records, task, form)):
                steps, errors = np.array(run["curve"]).T
                label = form if index == 0 else None
                axis.plot(steps / 1e6, errors, color=color, linewidth=1.0, label=label)
        for threshold in TASKS[task].thresholds:
            axis.axhline(threshold, **LIMIT)
        axis.set(
            yscale="log", title=task, xlabel="million steps", ylabel="mean error in training [m]"
        )
        axis.legend(fontsize=8)
    save(figure, out)


# --- the command line ---------------------------------------------------------------------------


def main(arguments: list[str] | None = None) -> int:
    """Trains, compares, writes; returns the exit code."""
    options = (
        Options(__doc__, __name__, "two seeds, few steps")
        .of_runs()
        .of_training(5, jobs=1)
        .add("--tasks", nargs="+", choices=list(TASKS), default=list(TASKS), help="default: all")
        .given(arguments)
    )
    options.seeds = 2 if options.quick else options.seeds
    if options.seeds < 2:
        raise RunError(f"--seeds {options.seeds}: 2 or more")
    made = {
        (task, form): make_runs(options, task, form) for task in options.tasks for form in FORMS
    }
    by_seed = [run for runs in zip(*made.values(), strict=True) for run in runs]
    for task in options.tasks:
        require_like_presets(task)
    train_all(by_seed, options.jobs, lambda run: run.folder.name)
    records = [record(run, *key) for key, runs in made.items() for run in runs]
    content = {
        **heading("control abstractions", options),
        "comparisons": [
            compare(records, task, threshold)
            for task in options.tasks
            for threshold in TASKS[task].thresholds
        ],
        "runs": records,
    }
    draw(records, options.tasks, options.out / "images/control_abstractions.png")
    write_page(options.out, PAGE, markdown(content), content)
    return 0
