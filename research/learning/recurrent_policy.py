"""Whether memory helps one policy to fly 1,000 drawn vehicles.

    python -m research run recurrent_policy [--seeds 1 2 3] [--out DIR] [--quick]

RAPTOR's question: can one recurrent policy fly unknown vehicles from 30 g to 5 kg?
Hover is `vehicles` with these masses and the rewards of `hover_learn`, the path is that of
`vehicles_trajectory`. Policies have gated recurrent units or none, and observe their past actions
or not; past actions reveal the vehicle's response to a throttle. All take the same steps. Each
flies 100 episodes with vehicles drawn by another seed. Finished runs are not repeated, and
interrupted ones are resumed. Writes recurrent_policy.md, its JSON and a picture.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from research.common.machine import machine_line, versions_line
from research.common.options import Options, heading
from research.common.pages import head, markdown_table, write_page
from research.common.places import PROGRAM
from research.common.plots import panels, save
from research.common.training_runs import Run, changed_hyper, train_all
from research.learning.learning_flight import SEED, fly

PAGE = "recurrent_policy"

EXPERIMENT = "one policy for many vehicles, with and without memory"
FLEET, LIGHTEST, HEAVIEST = 1000, 0.03, 5.0  # vehicles; kg
EPISODES = 100
PPO = (
    "final_log_std=-2.7",
    "bounded_mean=true",
    "normalization_steps=1500000",
    "averaging_steps=300000",
)
NEAR = 0.1  # m
UNITS = 64  # of memory
QUICK_STEPS, QUICK_EPISODES = 100_000, 4
MASS = "robots.quad.links.base_link.mass"
MORE, FEWER = "More arrive with memory", "Fewer arrive with memory"
NEARER = "the median vehicle is nearer with it, with every seed"
FARTHER = "the median vehicle is farther off with it, with every seed"
Row = dict[str, Any]


def overrides() -> tuple[str, ...]:
    """Overrides of the scenario: the fleet, and the rewards of `hover_learn`."""
    return (
        "randomization=[{plugin: vehicle, parameters: {robot: quad, "
        f"fleet: {FLEET}, mass: [{LIGHTEST}, {HEAVIEST}]}}}}, "
        "{plugin: start, parameters: {robot: quad, position_min: [-1, -1, 2], "
        "position_max: [1, 1, 4], yaw_min: -0.7, yaw_max: 0.7, rotor_speed: hover}}]",
        "task={plugin: hover, parameters: {robot: quad, target: [0, 0, 3, 0], approach_reward: 1, "
        "precision_reward: 4, heading_reward: 0.5, tilt_cost: 2, failure_reward: -100}}",
    )


@dataclass(frozen=True)
class Flown:
    """A task, and its error that counts."""

    scenario: str
    overrides: tuple[str, ...]
    settings: tuple[str, ...]  # in addition to the scenario's preset
    total_steps: int
    error: str  # an info
    is_mean: bool  # its final value is already a mean; otherwise it is averaged over a second
    doc: str


TASKS = {
    "hover": Flown(
        scenario="vehicles",
        overrides=overrides(),
        settings=PPO,
        total_steps=10_000_000,
        error="position_error",
        is_mean=False,
        doc="distance from the target, averaged over the last second of 15",
    ),
    "trajectory": Flown(
        scenario="vehicles_trajectory",
        overrides=(),
        settings=(),
        total_steps=6_000_000,
        error="mean_error",
        is_mean=True,
        doc="distance from the moving place on the path, averaged from 3 s on to the end (30 s)",
    ),
}


@dataclass(frozen=True)
class Kind:
    """A kind of policy."""

    name: str
    remembers: bool
    sees_actions: bool
    color: str

    def settings(self) -> tuple[str, ...]:
        """Hyper-parameters."""
        return (f"recurrent_units={UNITS}",) if self.remembers else ()

    def overrides(self) -> tuple[str, ...]:
        """Overrides of the scenario."""
        return () if self.sees_actions else ("task.parameters.past_actions=false",)


KINDS = (
    Kind("memory, sees past actions", True, True, "C0"),
    Kind("no memory, sees past actions", False, True, "C1"),
    Kind("memory, sees no actions", True, False, "C2"),
    Kind("no memory, sees no actions", False, False, "C3"),
)


def make_run(options: argparse.Namespace, task: str, kind: Kind, seed: int) -> Run:
    """The run of one policy."""
    flown = TASKS[task]
    name = kind.name.replace(", ", "-").replace(" ", "-")
    return Run(
        folder=options.runs / f"{task}-{name}-seed-{seed}",
        scenario=flown.scenario,
        algorithm="fast-ppo",
        seed=seed,
        total_steps=QUICK_STEPS if options.quick else flown.total_steps,
        threads=options.threads,
        overrides=(*flown.overrides, *kind.overrides()),
        settings=(*flown.settings, *kind.settings()),
        checkpoints=1,
        eval_episodes=0,
    ).with_threads_of_folder()


def all_runs(options: argparse.Namespace) -> Iterator[tuple[str, Kind, Run]]:
    """Seed by seed for all policies, so that an interruption leaves whole comparisons."""
    for seed in options.seeds:
        for task in options.tasks:
            for kind in KINDS:
                yield task, kind, make_run(options, task, kind, seed)


def record(task: str, kind: Kind, run: Run, program: Path, episodes: int) -> Row:
    """Results of a policy in held-out flights."""
    flights = fly(program, run, episodes)
    flown = TASKS[task]
    infos = flights.at_the_end if flown.is_mean else flights.last_second
    errors = infos[flown.error]
    return {
        "task": task,
        "policy": kind.name,
        "seed": run.seed,
        "total_steps": run.total_steps,
        "median_error": float(np.median(errors)),
        "error_90_percent": float(np.percentile(errors, 90)),
        "failures": int(flights.failed.sum()),
        "near": int((~flights.failed & (errors < NEAR)).sum()),
        "episodes": len(errors),
        "masses": [round(float(m), 5) for m in flights.at_the_end[MASS]],
        "errors": [round(float(e), 5) for e in errors],
        "failed": flights.failed.tolist(),
        "hyper": changed_hyper(run.config()),
        "versions": run.config()["versions"],
    }


# --- the page -----------------------------------------------------------------------------------


def of_kind(rows: Sequence[Row], task: str, kind: Kind) -> list[Row]:
    """Rows of a kind of policy, one per seed."""
    return [r for r in rows if (r["task"], r["policy"]) == (task, kind.name)]


def pair(rows: Sequence[Row], task: str, sees_actions: bool) -> tuple[list[Row], list[Row]]:
    """Rows of policies with memory and without, that observe their actions or do not."""
    kinds = {kind.remembers: kind for kind in KINDS if kind.sees_actions == sees_actions}
    return of_kind(rows, task, kinds[True]), of_kind(rows, task, kinds[False])


def answer(rows: Sequence[Row], of: Sequence[tuple[str, bool]]) -> str:
    """The whole page in a sentence."""
    pairs = [pair(rows, *which) for which in of]
    said = [(arriving(*both), erring(*both)) for both in pairs]
    better = sum(more == MORE or error == NEARER for more, error in said)
    worse = sum(more == FEWER or error == FARTHER for more, error in said)
    seeds = len({row["seed"] for row in rows})
    runs = f"{seeds} seed{'s' if seeds > 1 else ''} of each policy"
    if not better and not worse:
        return (
            f"**No effect of memory can be told with {runs}:** in none of {len(said)} comparisons "
            "is there a difference in how many vehicles arrive or in the median error."
        )
    return (
        f"**With {runs}, memory helps in {better} of {len(said)} comparisons and does harm in "
        f"{worse}**, in how many vehicles arrive or in the median error."
    )


def compared(rows: Sequence[Row], task: str, sees_actions: bool) -> str:
    """The effect of memory for policies that observe their actions, or do not."""
    ours, theirs = pair(rows, task, sees_actions)
    who = "past actions observed" if sees_actions else "no actions observed"
    return (
        f"- `{task}`, {who}: with memory {in_words(ours)}; without {in_words(theirs)}. "
        f"{arriving(ours, theirs)}; {erring(ours, theirs)}."
    )


def in_words(own: Sequence[Row]) -> str:
    """Summary of all flights of the seeds."""
    near, flown = (sum(r[name] for r in own) for name in ("near", "episodes"))
    median = statistics.median(r["median_error"] for r in own)
    return f"{near} of {flown} within {NEAR} m, median error {1e3 * median:.1f} mm"


def arriving(ours: Sequence[Row], theirs: Sequence[Row]) -> str:
    """Whether more flights succeed with memory: two standard errors, and all seeds agree."""
    shares = [[r["near"] / r["episodes"] for r in own] for own in (ours, theirs)]
    means = [statistics.fmean(own) for own in shares]
    counts = [sum(r["episodes"] for r in own) for own in (ours, theirs)]
    error = sum(p * (1.0 - p) / n for p, n in zip(means, counts, strict=True)) ** 0.5
    if abs(means[0] - means[1]) > 2.0 * error:
        if min(shares[0]) > max(shares[1]):
            return MORE
        if max(shares[0]) < min(shares[1]):
            return FEWER
    return "Of how many arrive no difference can be told"


def erring(ours: Sequence[Row], theirs: Sequence[Row]) -> str:
    """Whether the median error is smaller with memory: all seeds agree."""
    medians = [[r["median_error"] for r in own] for own in (ours, theirs)]
    if max(medians[0]) < min(medians[1]):
        return NEARER
    if min(medians[0]) > max(medians[1]):
        return FARTHER
    return "of the median error no difference can be told"


def table(rows: Sequence[Row]) -> str:
    """One line per policy."""
    names = "task | policy | seed | steps | median error [m] | 90 % quantile [m] | failures"
    lines: list[list[Any]] = [head(f"{names} | within {NEAR} m")]
    order = {kind.name: k for k, kind in enumerate(KINDS)}
    for row in sorted(rows, key=lambda r: (r["task"], order[r["policy"]], r["seed"])):
        start = [row["task"], row["policy"], row["seed"], f"{row['total_steps'] / 1e6:.4g} M"]
        errors = [f"{row[name]:.4f}" for name in ("median_error", "error_90_percent")]
        counts = [f"{row['failures']} of {row['episodes']}", row["near"]]
        lines.append([*start, *errors, *counts])
    return markdown_table(lines, (0, 1))


def markdown(content: dict[str, Any]) -> str:
    """The page."""
    rows = content["runs"]
    tasks = [name for name in TASKS if any(row["task"] == name for row in rows)]
    first = rows[0]
    pairs = [(task, sees) for task in tasks for sees in (True, False)]
    verdicts = [compared(rows, *which) for which in pairs]
    hyper = {f"{row['task']}, {row['policy']}": row["hyper"] for row in rows}
    settings = "\n".join(f"- {name}: {', '.join(values)}" for name, values in hyper.items())
    errors = "\n".join(
        f"- `{task}` (scenario `{TASKS[task].scenario}`): {TASKS[task].doc}." for task in tasks
    )
    return f"""\
# One policy for {FLEET:,} vehicles, with and without memory

{answer(rows, pairs)}

Does memory help one policy that is to fly any quadrotor of {1e3 * LIGHTEST:.0f} g to
{HEAVIEST:.0f} kg (RAPTOR's question)? By

    {content["command"]}

on {machine_line(content["machine"])}.

{chr(10).join(verdicts)}

More or fewer are said to arrive where the shares differ by two standard errors and those of all
seeds lie on one side; the median vehicle is said to be nearer or farther off where it is so for all
seeds. The median error of a line is the median of its seeds'.

![Error over mass](images/recurrent_policy.png)

A point is an episode, a cross one that failed; lines are medians of neighbours in mass.

{table(rows)}

A policy is trained with {FLEET:,} vehicles (randomizer `vehicle`: mass, arms, inertia, rotors,
their lag and thrust to weight; nobody observes them), one of them in each episode, and gives
throttles at 100 Hz. Then it flies {first["episodes"]} episodes with vehicles of another fleet, that
of seed {SEED}: {len(set(first["masses"]))} different ones, from {1e3 * min(first["masses"]):.0f} g
to {max(first["masses"]):.2f} kg. Memory is {UNITS} gated recurrent units in front of the policy's
two layers; the value function has none. A policy that sees past actions sees the last two of them
(hover) or the last one (trajectory), which tell how its vehicle answers a throttle. A policy that
sees none (`past_actions: false`) can tell by its memory alone, if it has one.

Errors, failed episodes included:

{errors}

A failure is an episode that ends early or faults.

Whether a critic should see more than the policy is asked with the pendulum:
[asymmetric_critic.md](asymmetric_critic.md).

Hyper-parameters that are not the learner's defaults:

{settings}

Versions: {versions_line(rows)}.
"""


def draw(rows: Sequence[Row], out: Path) -> None:
    """Error over mass; one point per episode, a cross for a failure, one panel per task."""
    tasks = [name for name in TASKS if any(row["task"] == name for row in rows)]
    figure, axes = panels(1, len(tasks), (4.8 * len(tasks), 4.4))
    for axis, task in zip(axes.flat, tasks, strict=True):
        for kind in KINDS:
            own = of_kind(rows, task, kind)
            masses = np.concatenate([r["masses"] for r in own])
            errors = np.concatenate([r["errors"] for r in own])
            failed = np.concatenate([r["failed"] for r in own]).astype(bool)
            axis.plot(masses[~failed], errors[~failed], ".", markersize=3, color=kind.color)
            axis.plot(masses[failed], errors[failed], "x", markersize=4, color=kind.color)
            axis.plot(*middles(masses, errors), color=kind.color, linewidth=1.5, label=kind.name)
        axis.set(xscale="log", yscale="log", title=task, xlabel="mass [kg]", ylabel="error [m]")
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, fontsize=8)
    save(figure, out)


def middles(masses: np.ndarray, errors: np.ndarray, parts: int = 8) -> tuple[list[float], ...]:
    """Masses and median errors of parts with equal numbers of episodes."""
    order = np.array_split(np.argsort(masses), parts)
    return (
        [float(np.median(masses[k])) for k in order],
        [float(np.median(errors[k])) for k in order],
    )


# --- the command line ---------------------------------------------------------------------------


def main(arguments: list[str] | None = None) -> int:
    """Trains, flies, writes; returns the exit code."""
    options = (
        Options(__doc__, __name__, "one seed, few steps", PROGRAM)
        .of_runs()
        .of_training([1, 2, 3], jobs=1)
        .add("--tasks", nargs="+", choices=list(TASKS), default=list(TASKS), help="default: all")
        .given(arguments)
    )
    options.seeds = options.seeds[:1] if options.quick else options.seeds
    made = list(all_runs(options))
    episodes = QUICK_EPISODES if options.quick else EPISODES
    train_all([run for _, _, run in made], options.jobs, lambda run: run.folder.name)
    records = [record(*of_run, options.program, episodes) for of_run in made]
    content = {**heading(EXPERIMENT, options), "runs": records}
    draw(records, options.out / "images/recurrent_policy.png")
    write_page(options.out, PAGE, markdown(content), content)
    return 0
