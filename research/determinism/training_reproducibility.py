"""Whether one seed gives the same policy, with `ppo` and with
[`fast-ppo`](training_reproducibility_fast-ppo.md).

    python -m research run training_reproducibility [--algo ppo] [--jobs 2] [--out DIR]

PPO of Stable-Baselines3 (or --algo fast-ppo, which also learns with its threads) in separate
processes: one group with one seed and 1, 2 and 4 threads mixed among its processes, one group with
different seeds. Every checkpoint is evaluated in a new process, on the same episodes, with frozen
normalization. Writes a table, its figures as JSON and a picture. Finished runs are not
repeated, and interrupted ones are resumed. Exit code 1 unless all checkpoints of the one seed are
the same in every bit, and no two of different seeds are.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from research.common.options import Options, heading
from research.common.pages import write_page
from research.common.programs import RunError
from research.common.training_runs import Run, settings_with, train_all
from research.determinism.reproducibility_report import draw, markdown

PAGE = "training_reproducibility"

SEEDS = (1, 5, 25, 42, 125)  # the paper's; the first one is also that of the same-seed group
THREADS = (1, 2, 4)  # of the environments, in turn over the processes of the same-seed group
CHECKPOINTS = 10
STEPS, QUICK_STEPS = 500_000, 20_000
EPISODES = 20

ENVS, ROLLOUT_STEPS = 8, 250  # ten checkpoints of 50,000 steps coincide with ends of rollouts

# All hyper-parameters are explicit: the presets of skybody.train may change, this experiment
# must not. Values that the paper does not give are Stable-Baselines3's defaults.
PAPER = {
    "envs": ENVS,
    "rollout_steps": ROLLOUT_STEPS,
    "minibatch": 512,
    "epochs": 3,
    "value_epochs": 3,
    "learning_rate": 1e-4,
    "final_learning_rate": 1,
    "discount": 0.99,
    "gae_lambda": 0.95,
    "clip_range": 0.2,
    "target_kl": 0,
    "entropy_weight": 0,
    "value_weight": 0.5,
    "max_grad_norm": 0.5,
    "log_std": -2,
    "final_log_std": 0,
    "bounded_mean": "false",
    "hidden": "256,256",
    "normalize_rewards": "true",
    "observation_clip": 10,
    "normalization_steps": 0,
    "averaging_steps": 0,
    "torch_threads": 1,
}
# 8 environments give small rollouts: many gradient steps with few passes over them.
LEARNS = {"minibatch": 125, "epochs": 5, "learning_rate": 3e-4, "discount": 0.98}
LEARNS |= {"log_std": -0.5, "hidden": "64,64"}


@dataclass(frozen=True)
class Setup:
    """Scenario and hyper-parameters of the training."""

    overrides: tuple[str, ...]  # of the scenario
    hyper: dict[str, Any]


SETUPS = {
    # 1 s at 1 kHz, as in the paper, whose policy had not learned
    "hover": Setup(("stepping.horizon=1000",), PAPER),
    # the return rises, with randomization
    "hover_learn": Setup((), PAPER | LEARNS),
}


@dataclass(frozen=True)
class Group:
    """Runs whose checkpoints are compared."""

    name: str
    runs: tuple[Run, ...]


def make_groups(
    scenario: str, out: Path, steps: int, processes: int, algorithm: str = "ppo"
) -> list[Group]:
    """The same-seed and the different-seeds group; both contain the first run."""

    def run(seed: int, process: int) -> Run:
        return Run(
            folder=out / scenario / f"seed-{seed}-process-{process + 1}",
            scenario=scenario,
            algorithm=algorithm,
            seed=seed,
            total_steps=steps,
            threads=THREADS[process % len(THREADS)],
            overrides=SETUPS[scenario].overrides,
            settings=settings_with(SETUPS[scenario].hyper, algorithm),
            checkpoints=CHECKPOINTS,
            eval_episodes=EPISODES,
        )

    same = tuple(run(SEEDS[0], process) for process in range(processes))
    different = tuple(run(seed, 0) for seed in SEEDS[:processes])
    return [Group("same seed", same), Group("different seeds", different)]


# --- the table's figures ------------------------------------------------------------------------


def run_record(run: Run) -> dict[str, Any]:
    """A run's checkpoints and their results, without those added by an interruption."""
    every = run.total_steps // CHECKPOINTS
    keep = ("steps", "parameter_hash", "return_mean", "return_std", "position_error_median")
    checkpoints = [
        {name: evaluation[name] for name in (*keep, "success_share")}
        for evaluation in run.evaluations()
        if evaluation["steps"] % every == 0
    ]
    return {
        "seed": run.seed,
        "folder": run.folder.name,
        "threads": run.threads,
        "wall_clock": run.evaluations()[-1]["wall_clock"],
        "checkpoints": checkpoints,
    }


def group_figures(records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The columns of the paper's Table II over the runs of one group, and its curves.

    Deviations are those of a sample (n - 1). `different` counts the checkpoints of which no two
    runs have the same parameters. Raises RunError if the runs do not have the same checkpoints.
    """
    steps = [[point["steps"] for point in record["checkpoints"]] for record in records]
    if any(of_run != steps[0] for of_run in steps):
        raise RunError(f"the runs have checkpoints at different steps: {steps}")
    returns = np.array([[c["return_mean"] for c in r["checkpoints"]] for r in records])
    hashes = [
        {r["checkpoints"][k]["parameter_hash"] for r in records} for k in range(len(steps[0]))
    ]
    deviation = returns.std(axis=0, ddof=1)
    final = float(returns[:, -1].mean())
    return {
        "runs": len(records),
        "final_return_mean": final,
        "final_return_std": float(deviation[-1]),
        "final_return_cv_percent": 100.0 * float(deviation[-1]) / abs(final),
        "checkpoint_return_std_mean": float(deviation.mean()),
        "identical_checkpoints_percent": 100.0 * float(np.mean([len(h) == 1 for h in hashes])),
        "different_checkpoints_percent": 100.0
        * float(np.mean([len(h) == len(records) for h in hashes])),
        "steps": steps[0],
        "return_mean": returns.mean(axis=0).tolist(),
        "return_std": deviation.tolist(),
    }


def scenario_figures(groups: Sequence[Group]) -> dict[str, Any]:
    """All figures of one scenario. Raises RunError if runs used different scenarios."""
    runs = list(dict.fromkeys(run for group in groups for run in group.runs))
    configs = [run.config() for run in runs]
    for one, other in combinations(zip(runs, configs, strict=True), 2):
        for what in ("scenario_hash", "hyper"):
            if one[1][what] != other[1][what]:
                raise RunError(
                    f"{one[0].folder} and {other[0].folder} were done with different {what}; "
                    "remove the older one"
                )
    records = {run: run_record(run) for run in runs}
    return {
        "scenario_hash": configs[0]["scenario_hash"],
        "overrides": configs[0]["overrides"],
        "hyper": configs[0]["hyper"],
        "eval_episodes": configs[0]["eval_episodes"],
        "eval_seed": configs[0]["eval_seed"],
        "groups": {g.name: group_figures([records[run] for run in g.runs]) for g in groups},
        "members": {g.name: [run.folder.name for run in g.runs] for g in groups},
        "runs": list(records.values()),
        "versions": [config["versions"] for config in configs],
    }


def reproducible(figures: dict[str, Any]) -> bool:
    """Whether one seed always gave the same bits, and different ones never."""
    same, different = (figures["groups"][name] for name in ("same seed", "different seeds"))
    return bool(
        same["identical_checkpoints_percent"] == 100.0
        and different["different_checkpoints_percent"] == 100.0
    )


# --- the command line ---------------------------------------------------------------------------


def say(run: Run) -> str:
    """One line on a finished run."""
    last = run.evaluations()[-1]
    return (
        f"{run.scenario}, seed {run.seed}, threads {run.threads} ({run.folder.name}): "
        f"{last['wall_clock']:.0f} s, return {last['return_mean']:.4g}, "
        f"parameters {last['parameter_hash'][:16]}"
    )


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line's values, checked."""
    of_names: dict[str, Any] = {"nargs": "+", "choices": SETUPS, "default": list(SETUPS)}
    most = len(SEEDS)
    options = (
        Options(__doc__, __name__, f"2 processes, {QUICK_STEPS:,} steps")
        .of_runs()
        .add("--algo", choices=("ppo", "fast-ppo"), default="ppo", help="learner; default: ppo")
        .add("--steps", type=float, help=f"steps per run; default: {STEPS:,}")
        .add("--processes", type=int, help=f"runs per group, 2 to {most}; default: {most}")
        .add("--scenarios", help="scenarios; default: all", **of_names)
        .add("--jobs", type=int, default=2, help="parallel runs; changes no bits; default: 2")
        .given(arguments)
    )
    options.name = PAGE if options.algo == "ppo" else f"{PAGE}_{options.algo}"
    if not options.quick:
        options.runs = options.runs.with_name(options.name)
    options.steps = int(options.steps or (QUICK_STEPS if options.quick else STEPS))
    options.processes = options.processes or (2 if options.quick else most)
    if not 2 <= options.processes <= len(SEEDS):
        raise RunError(f"--processes {options.processes}: 2 to {len(SEEDS)}")
    rollout = ENVS * ROLLOUT_STEPS
    if options.steps < rollout * CHECKPOINTS or options.steps % (rollout * CHECKPOINTS):
        raise RunError(
            f"--steps {options.steps}: a multiple of {rollout * CHECKPOINTS}, so that each of the "
            f"{CHECKPOINTS} checkpoints falls on the end of a rollout ({rollout} steps)"
        )
    return options


def main(arguments: list[str] | None = None) -> int:
    """Trains, compares, writes; returns the exit code."""
    options = parse(arguments)
    groups = {
        name: make_groups(name, options.runs, options.steps, options.processes, options.algo)
        for name in options.scenarios
    }
    every = [run for of_one in groups.values() for group in of_one for run in group.runs]
    train_all(list(dict.fromkeys(every)), options.jobs, say)
    scenarios = {name: scenario_figures(of_one) for name, of_one in groups.items()}
    content = {
        **heading("training reproducibility", options),
        "algorithm": options.algo,
        "name": options.name,
        "steps": options.steps,
        "scenarios": scenarios,
    }
    draw(content, options.out / f"images/{options.name}.png")
    write_page(options.out, options.name, markdown(content), content)
    return 0 if all(reproducible(figures) for figures in scenarios.values()) else 1
