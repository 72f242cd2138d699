"""Duration and results of the paper's training study on this simulator.

    python -m research run paper_protocol TASK... [--algo ppo fast-ppo] [--transitions N]

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
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from skybody import CompiledScenario
from skybody.train.checkpoint import checkpoint_folders, read_meta
from skybody.train.run_folder import read_table

from research.common.machine import machine, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page
from research.common.places import PROGRAM
from research.common.plots import panels, save
from research.common.programs import RunError
from research.common.training_runs import Run, settings_with, train_all
from research.learning.learning_flight import fly

PAGE = "paper_protocol"

SEEDS = (1, 25, 42)
TRANSITIONS, QUICK_TRANSITIONS = 5_000_000, 62_000
CHECKPOINTS = 20
EPISODES = 100  # of held-out flights
POINTS = 80  # of a curve
PAPER_MINUTES = 220.0  # six runs of a task at once: two sets of three seeds
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
    # No observation of the paper's tasks is an image.
    "cnn_channels": "16,32,32",
    "cnn_kernels": "8,4,3",
    "cnn_strides": "4,2,1",
    "cnn_same_padding": "false",
    "cnn_features": 128,
    "cnn_range": 0,
    "value_images": "true",
    "torch_threads": 1,
}
# Of quick runs: an update of the paper's networks takes twenty seconds.
QUICK_SIZES = {**SIZES, "hidden": "64,64"}


def make_runs(
    task: str,
    algorithm: str,
    out: Path,
    transitions: int,
    seeds: Sequence[int] = SEEDS,
    sizes: dict[str, Any] = SIZES,
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
            settings=settings_with(sizes, algorithm),
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


# --- the page -----------------------------------------------------------------------------------


def learned_section(rows: list[dict[str, Any]]) -> str:
    """Table and picture of runs with their curves; empty without one."""
    if not rows:
        return ""
    ends = "first and last"
    names = f"task | learner | seed | transitions | return of training, {ends} | error of training,"
    names += f" {ends} [m] | held-out flights succeeded | failed"
    table: list[list[Any]] = [head(f"{names} | their median error in the last second [m]")]
    for row in rows:
        course, flown = row["curve"], row.get("flown")
        ends_of = [
            ", ".join(known_or_dash(course[name][k]) for k in (0, -1))
            for name in ("return", "error")
        ]
        cells = [f"`{row['task']}`", row["learner"], row["seed"], f"{row['transitions']:,}"]
        table.append([*cells, *ends_of, *(["-"] * 3 if flown is None else flown_cells(flown))])
    return f"""
## Learned tasks

One seed of each form, by

{chr(10).join(dict.fromkeys(f"    {row['command']}" for row in rows))}

![Return and error over transitions](images/paper_protocol.png)

{markdown_table(table, (0, 1))}

Runs of fewer than 5,000,000 transitions were cut there: they may learn later. First and last: means
over an eightieth of the run. Return and error are those of training, with its noise, and the error
is a mean over whole episodes. The head of the scenario's file defines success, in episodes of a
seed that training does not know, by the last policy without noise.

Beside the paper's curves (its figure 10, payload on the left and trajectory on the right): there
all four learn within the 5,000,000 transitions, and on the trajectory modular control is ahead
early on. Its returns are not comparable: the scenarios here end an episode where the paper's code
does, and mend its mistakes (listed in their heads). The paper's question is asked with
five seeds a form and presets that learn in [control_abstractions.md](control_abstractions.md).
"""


def known_or_dash(value: float | None) -> str:
    """Four digits, or a dash."""
    return "-" if value is None else f"{value:.4g}"


def flown_cells(flown: dict[str, Any]) -> list[str]:
    """Cells on the held-out flights."""
    error = flown["median_error"]
    return [
        f"{flown['succeeded']} of {flown['episodes']}",
        str(flown["failed"]),
        "-" if error is None else f"{error:.3f}",
    ]


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """Return and error over transitions, one column per task, one line per form of control."""
    tasks = sorted({family(row) for row in rows})
    if not tasks:
        return
    figure, axes = panels(2, len(tasks), (4.6 * len(tasks), 5.6), sharex="col")
    for column, task in enumerate(tasks):
        for row in (row for row in rows if family(row) == task):
            course = row["curve"]
            steps = np.array(course["steps"]) / 1e6
            for axis, name in zip(axes[:, column], ("return", "error"), strict=True):
                label = f"{row['task']}, {row['learner']}"
                axis.plot(steps, np.array(course[name], float), label=label, linewidth=1.2)
        axes[0, column].set(title=task, ylabel="return of training")
        axes[1, column].set(xlabel="million transitions", ylabel="mean error in training [m]")
        axes[0, column].legend(fontsize=8)
    save(figure, path)


def family(row: dict[str, Any]) -> str:
    """A panel's title: the task without the form of control."""
    return str(row["task"]).partition("_")[0]


def markdown(content: dict[str, Any]) -> str:
    """The page."""
    names = "task | learner | machine | runs at once | transitions each | measured [min]"
    names += " | steps/s, all runs | these runs, 5,000,000 each [min]"
    table: list[list[Any]] = [head(f"{names} | the paper's six, on 24 cores and two GPUs [min]")]
    for row in content["rows"]:
        whole = f"{row['minutes_for_all']:.1f}" + (" (extrapolated)" if row["extrapolated"] else "")
        start = [f"`{row['task']}`", row["learner"], machine_line(row["machine"]), row["runs"]]
        rates = [f"{row['seconds'] / 60.0:.1f}", f"{row['steps_per_second']:,.0f}", whole]
        table.append([*start, f"{row['transitions']:,}", *rates, f"{PAPER_MINUTES:.0f}"])
    hyper = ", ".join(f"{name} {value}" for name, value in content["hyper"].items())
    commands = "\n".join(
        f"    {text}" for text in dict.fromkeys(r["command"] for r in content["rows"])
    )
    return f"""\
# The paper's training protocol

Runs of the GzDRL paper's training study (networks of [512, 512], seeds 1, 25 and 42, 15
environments each, 5,000,000 transitions), by

{commands}

{markdown_table(table, (0, 1, 2))}

The paper trains six runs of a task at once (two groups of three seeds, 90 environments) in about
220 minutes on 24 cores and two GPUs. Here the runs of a row go side by side, with one thread each.
`extrapolated`: the runs were cut at the transitions that are shown; the rest is counted at the rate
between the first checkpoint and the last of the slowest run.

`ppo` is that of Stable-Baselines3, on processors alone. Both learners have the same
hyper-parameters: {hyper}.
{learned_section(content.get("learned", []))}"""


# --- the command line ---------------------------------------------------------------------------


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line's values, checked."""
    algorithms, ends = ("fast-ppo", "ppo"), f"transitions at which runs end; {TRANSITIONS:,}"
    of_seeds: dict[str, Any] = {"type": int, "choices": SEEDS, "default": SEEDS}
    options = (
        Options(__doc__, __name__, f"one seed, {QUICK_TRANSITIONS:,} transitions, small nets")
        .of_runs()
        .add("tasks", nargs="+", metavar="TASK", help="scenarios")
        .add("--algo", nargs="+", choices=algorithms, default=list(algorithms))
        .add("--transitions", type=float, help=ends)
        .add("--seeds", nargs="+", help="seeds of the paper; default: all", **of_seeds)
        .add("--learned", action="store_true", help="train nothing: show the runs so far")
        .given(arguments)
    )
    wanted = options.transitions or (QUICK_TRANSITIONS if options.quick else TRANSITIONS)
    options.transitions = int(wanted)
    options.seeds = options.seeds[:1] if options.quick else options.seeds
    options.sizes = QUICK_SIZES if options.quick else SIZES
    least = SIZES["envs"] * SIZES["rollout_steps"]  # type: ignore[operator]
    if not 2 * least <= options.transitions <= TRANSITIONS:
        raise RunError(f"--transitions {options.transitions}: {2 * least} to {TRANSITIONS}")
    return options


def merged(earlier: list[dict[str, Any]], rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """`rows`, after the earlier ones of other tasks and learners."""
    new = {(row["task"], row["learner"]) for row in rows}
    return [row for row in earlier if (row["task"], row["learner"]) not in new] + rows


def main(arguments: list[str] | None = None) -> int:
    """Trains, writes; returns the exit code."""
    options = parse(arguments)
    rows: list[dict[str, Any]] = []
    curves: list[dict[str, Any]] = []
    for task in options.tasks:
        CompiledScenario(task)  # mistakes are reported before training
    for task in options.tasks:
        for algorithm in options.algo:
            runs = make_runs(
                task, algorithm, options.runs, options.transitions, options.seeds, options.sizes
            )
            if options.learned:
                curves.append(learned(runs[0], options.command))
                continue
            train_together(runs)
            rows.append({**figures(runs), "command": options.command, "machine": machine()})
    path = options.out / "data/paper_protocol.json"
    earlier = json.loads(path.read_text()) if path.exists() else {}
    content = {
        "experiment": "the paper's training protocol",
        "hyper": options.sizes,
        "rows": merged(earlier.get("rows", []), rows),
        "learned": merged(earlier.get("learned", []), curves),
    }
    draw(content["learned"], options.out / "images/paper_protocol.png")
    keeps = content["rows"] != rows or content["learned"] != curves
    write_page(options.out, PAGE, markdown(content), content, keeps)
    return 0
