"""Table and picture of training_reproducibility.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import EngFormatter

from research.common.machine import machine_line, versions_line
from research.common.pages import head, markdown_table
from research.common.plots import panels, save

# Table II of the paper (hover, Gazebo): mean and deviation of the final return, its CV [%], mean
# deviation over checkpoints, identical checkpoints [%].
PAPER = {
    "same seed": (18.43, 0.00, 0.00, 0.00, 100),
    "different seeds": (18.08, 1.27, 7.05, 1.32, 0),
}
PROTOCOL = """\
Final return: mean ± standard deviation (n - 1), over the runs, of the mean return of {episodes}
episodes. CV: that deviation over that mean. Mean checkpoint sigma: mean, over the {checkpoints}
checkpoints, of the deviation over the runs. Identical: share of the checkpoints at which all runs
have the same SHA-256 over all parameters.

Each run is a process of its own, of {steps:,} steps in 8 environments with 250 steps a rollout.
The runs of one seed step their environments with 1, 2 and 4 threads in turn. Every checkpoint is
evaluated in a new process: deterministic policy, frozen normalization, {episodes} episodes of seed
{eval_seed}. A seed is that of networks, exploration and environments (in the paper the
environments' was held fixed). The first run stands in both groups.

`hover` is the paper's task and its learner's configuration: episodes of 1,000 steps of 1 ms, of at
most 1.01 each. The paper's final return is a fiftieth of that, so its policy had not learned.
`hover_learn` (50 Hz policy, 7 s, inertia, drag and motors drawn anew every episode) is learned
with hyper-parameters with which the return rises.

Versions: {versions}."""
LEARNERS = {
    "ppo": "PPO of Stable-Baselines3",
    "fast-ppo": "the learner in C++, whose rollouts and updates run on those threads too",
}
OTHERS = {
    "ppo": "With `fast-ppo`: [training_reproducibility_fast-ppo.md]"
    "(training_reproducibility_fast-ppo.md).",
    "fast-ppo": "With `ppo`: [training_reproducibility.md](training_reproducibility.md).",
}
SHORT_HASH = 16  # digits of a SHA-256 that the tables show; the JSON has all 64


def markdown(content: dict[str, Any]) -> str:
    """The whole report."""
    scenarios = content["scenarios"]
    parts = [_head(content), _table(scenarios), _protocol(content)]
    parts += [_runs(name, figures) for name, figures in scenarios.items()]
    return "\n\n".join(parts) + "\n"


def _head(content: dict[str, Any]) -> str:
    return f"""\
# Training reproducibility

Does one seed give the same policy, bit for bit? The experiment of the GzDRL paper's section V-B,
with {LEARNERS[content["algorithm"]]}
(`skybody train --algo {content["algorithm"]}`), by

    {content["command"]}

on {machine_line(content["machine"])}.

{OTHERS[content["algorithm"]]}

![Returns over training, one seed and different seeds](images/{content["name"]}.png)"""


def _table(scenarios: dict[str, Any]) -> str:
    names = "scenario | configuration | runs | final return | CV [%] | mean checkpoint sigma"
    table: list[list[Any]] = [head(f"{names} | identical checkpoints [%]")]
    keys = ("final_return_mean", "final_return_std", "final_return_cv_percent")
    keys = (*keys, "checkpoint_return_std_mean", "identical_checkpoints_percent")
    found = [("the paper's hover (Gazebo)", name, 5, figures) for name, figures in PAPER.items()]
    found += [
        (f"`{scenario}`", name, group["runs"], tuple(group[key] for key in keys))
        for scenario, figures in scenarios.items()
        for name, group in figures["groups"].items()
    ]
    for *start, (mean, deviation, cv, sigma, identical) in found:
        numbers = [f"{mean:.2f} ± {deviation:.2f}", f"{cv:.2f}", f"{sigma:.2f}"]
        table.append([*start, *numbers, f"{identical:.0f}"])
    return markdown_table(table, (0, 1))


def _protocol(content: dict[str, Any]) -> str:
    first = next(iter(content["scenarios"].values()))
    versions = [
        {"versions": found}
        for figures in content["scenarios"].values()
        for found in figures["versions"]
    ]
    return PROTOCOL.format(
        steps=content["steps"],
        episodes=first["eval_episodes"],
        eval_seed=first["eval_seed"],
        checkpoints=len(first["groups"]["same seed"]["steps"]),
        versions=versions_line(versions),
    )


def _runs(scenario: str, figures: dict[str, Any]) -> str:
    overrides = "".join(f", `{text}`" for text in figures["overrides"])
    hyper = ", ".join(f"{name} {value}" for name, value in figures["hyper"].items())
    names = "run | seed | threads | final return | median position error [m] | wall clock [s]"
    table = [head(f"{names} | final parameters (SHA-256)")]
    for run in figures["runs"]:
        last = run["checkpoints"][-1]
        error = last["position_error_median"]
        numbers = [f"{last['return_mean']:.4f}", "" if error is None else f"{error:.3f}"]
        numbers += [f"{run['wall_clock']:.0f}", f"`{last['parameter_hash'][:SHORT_HASH]}`"]
        table.append([run["folder"], run["seed"], run["threads"], *numbers])
    same = figures["members"]["same seed"]
    runs = [run for run in figures["runs"] if run["folder"] in same]
    points_table = [head("steps | different values | SHA-256")]
    for points in zip(*(run["checkpoints"] for run in runs), strict=True):
        hashes = sorted({point["parameter_hash"] for point in points})
        texts = ", ".join(f"`{text[:SHORT_HASH]}`" for text in hashes)
        points_table.append([f"{points[0]['steps']:,}", len(hashes), texts])
    apart = figures["groups"]["different seeds"]
    return f"""\
## {scenario}

Scenario hash {figures["scenario_hash"]}{overrides}. Hyper-parameters: {hyper}.

{markdown_table(table, (0, 6))}

Parameters of the {len(runs)} runs of one seed, checkpoint by checkpoint:

{markdown_table(points_table, (2,))}

At {apart["different_checkpoints_percent"]:.0f} % of the checkpoints the parameters of the \
{apart["runs"]} runs with different seeds all differ from each other."""


# --- the picture --------------------------------------------------------------------------------


def draw(content: dict[str, Any], out: Path) -> None:
    """The paper's figure: one row per scenario; one seed left, different seeds right."""
    scenarios = content["scenarios"]
    size = (10, 1.4 + 3.4 * len(scenarios))
    figure, axes = panels(len(scenarios), 2, size, sharex=True, sharey="row")
    for row, (scenario, figures) in zip(axes, scenarios.items(), strict=True):
        for axis, name in zip(row, figures["groups"], strict=True):
            _draw_group(axis, figures, name)
            axis.set_title(_title(scenario, figures["groups"][name], name), fontsize=9)
        row[0].set_ylabel("evaluation return")
    for axis in axes[-1]:
        axis.set_xlabel("environment steps")
        axis.xaxis.set_major_formatter(EngFormatter(sep=""))
        # Below, outside the curves; once per column, because every scenario has the same runs.
        axis.legend(fontsize=7, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    save(figure, out)


def _title(scenario: str, group: dict[str, Any], name: str) -> str:
    identical = group["identical_checkpoints_percent"]
    return f"{scenario}, {group['runs']} runs, {name}: {identical:.0f} % of checkpoints identical"


def _draw_group(axis: Axes, figures: dict[str, Any], name: str) -> None:
    group, by_folder = figures["groups"][name], {run["folder"]: run for run in figures["runs"]}
    runs = [by_folder[folder] for folder in figures["members"][name]]
    steps, mean, deviation = (
        np.array(group[key], float) for key in ("steps", "return_mean", "return_std")
    )
    axis.fill_between(
        steps, mean - deviation, mean + deviation, color="0.6", alpha=0.35, linewidth=0,
        label="mean ± 1 standard deviation",
    )  # fmt: skip
    axis.plot(steps, mean, color="0.35", linewidth=1, linestyle="--")
    for number, run in enumerate(runs):
        values = [point["return_mean"] for point in run["checkpoints"]]
        # Identical curves are drawn from wide to narrow, so that each is visible.
        width = 2.0 * (len(runs) - number) if name == "same seed" else 1.5
        label = f"process {number + 1}, environment threads: {run['threads']}"
        if name != "same seed":
            label = f"seed {run['seed']}"
        axis.plot(steps, values, color=f"C{number}", linewidth=width, label=label)
