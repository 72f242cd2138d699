#!/usr/bin/env python3
"""One policy for 20,000 drawn quadrotors, from 30 g to 5 kg: its quality after a minute of
training.

    .venv/bin/python experiments/vehicle_policy.py [--seeds 1] [--train-only] [--out DIR]

The scenario is `vehicles` with another draw (20,000 vehicles of 30 g to 5 kg) and the rewards of
`hover_learn`. Learners: fast-ppo, fast-ppo with gated recurrent memory, and gradient. Of each run
the newest policy counts that was written within 60 s of the command. It flies 100 episodes with 100
held-out vehicles, drawn by another seed. Writes vehicle_policy.md and its JSON.
Finished runs are not repeated; an interrupted one begins again, because its time counts. Run
it on an otherwise idle machine; with --train-only it evaluates and writes in a later call,
which may run on a loaded machine.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from hover_training import EPISODES, evaluate_checkpoint, measure
from result_pages import add_quick, heading, option_parser, place_quick, write_page
from skybody.program import run_program
from skybody.train.checkpoint import checkpoint_folders
from skybody.train.evaluation_file import read_evaluation
from training_runs import (
    Run,
    RunError,
    changed_hyper,
    machine_line,
    versions_line,
)

SCENARIO = "vehicles"
QUICK_FLEET = 64
FLEET, LIGHTEST, HEAVIEST = 20_000, 0.03, 5.0  # vehicles; kg
SECONDS = 60.0  # from the command to the policy that counts
NEAR = 0.3  # m, the scenario's success
CHECKPOINTS = 10
PPO = (
    "final_log_std=-2.7",
    "bounded_mean=true",
    "normalization_steps=1500000",
    "averaging_steps=300000",
)


def overrides(fleet: int) -> tuple[str, ...]:
    """Overrides of the scenario: the number of vehicles, and the rewards of `hover_learn`."""
    return (
        "randomization=[{plugin: vehicle, parameters: {robot: quad, "
        f"fleet: {fleet}, mass: [{LIGHTEST}, {HEAVIEST}]}}}}, "
        "{plugin: start, parameters: {robot: quad, position_min: [-1, -1, 2], "
        "position_max: [1, 1, 4], yaw_min: -0.7, yaw_max: 0.7, rotor_speed: hover}}]",
        "task={plugin: hover, parameters: {robot: quad, target: [0, 0, 3, 0], approach_reward: 1, "
        "precision_reward: 4, heading_reward: 0.5, tilt_cost: 2, failure_reward: -100}}",
    )


@dataclass(frozen=True)
class Contestant:
    """A learner with its settings, and steps for less than a minute on two idle cores."""

    algorithm: str
    steps: int
    settings: tuple[str, ...]


CONTESTANTS = {
    "fast-ppo": Contestant("fast-ppo", 24_000_000, PPO),
    "fast-ppo, memory of 64 units": Contestant(
        "fast-ppo", 12_000_000, (*PPO, "recurrent_units=64")
    ),
    "gradient": Contestant(
        "gradient",
        12_000_000,
        # The preset's long, slow approach is for few steps: here it ends with an error of 44 mm.
        (
            "envs=128",
            "learning_rate=6e-3",
            "max_grad_norm=1",
            "rollout_steps=32",
            "approach_speed=3",
        ),
    ),
}


def make_runs(out: Path, seeds: Sequence[int], quick: bool) -> list[tuple[str, Run]]:
    """Names of contestants and their runs, in their order of execution."""
    fleet, contestants = FLEET, CONTESTANTS
    if quick:
        fleet, contestants = QUICK_FLEET, {"fast-ppo": Contestant("fast-ppo", 1, PPO)}
    return [
        (
            name,
            Run(
                folder=out / f"{name.replace(', ', '-').replace(' ', '-')}-seed-{seed}",
                scenario=SCENARIO,
                algorithm=contestant.algorithm,
                seed=seed,
                total_steps=contestant.steps,
                overrides=overrides(fleet),
                settings=contestant.settings,
                checkpoints=CHECKPOINTS,
                eval_episodes=0,
            ),
        )
        for name, contestant in contestants.items()
        for seed in seeds
    ]


def newest_in_time(run: Run) -> tuple[Path, float]:
    """The last checkpoint that was written within SECONDS of the command, and its time [s]."""
    published = measure(run)["published"]
    written = [(folder, published[folder.name]) for folder in checkpoint_folders(run.folder)]
    in_time = [(folder, seconds) for folder, seconds in written if seconds <= SECONDS]
    if not in_time:
        raise RunError(f"{run.folder} has no checkpoint within {SECONDS:.0f} s of the command")
    return in_time[-1]


def record(name: str, run: Run) -> dict[str, Any]:
    """A row of the table."""
    checkpoint, seconds = newest_in_time(run)
    evaluate_checkpoint(checkpoint)
    found = read_evaluation(checkpoint)
    assert found is not None
    errors = np.array([np.nan if e is None else e for e in found["position_errors"]], float)
    failed = np.array(found["failed"], bool)
    return {
        "learner": name,
        "seed": run.seed,
        "steps": found["steps"],
        "seconds": seconds,
        "median_error": float(np.nanmedian(errors)),
        "error_90_percent": float(np.nanpercentile(errors, 90)),
        "failures": int(failed.sum()),
        "near": int((~failed & (errors < NEAR)).sum()),
        "episodes": found["episodes"],
        "parameter_hash": found["parameter_hash"],
        "hyper": changed_hyper(run.config()),
        "versions": run.config()["versions"],
    }


def markdown(content: dict[str, Any]) -> str:
    """The page."""
    rows = [
        "| learner | seed | steps | seconds | median error [m] | 90 % quantile [m] | failures "
        f"| within {NEAR} m |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for row in content["runs"]:
        rows.append(
            f"| {row['learner']} | {row['seed']} | {row['steps']:,} | {row['seconds']:.1f} "
            f"| {row['median_error']:.4f} | {row['error_90_percent']:.4f} "
            f"| {row['failures']} of {row['episodes']} | {row['near']} |"
        )
    hyper = {row["learner"]: row["hyper"] for row in content["runs"]}
    lines = "\n".join(f"- {name}: {', '.join(values)}" for name, values in hyper.items())
    return f"""\
# One policy for {FLEET:,} vehicles

How well does one policy hover quadrotors of {1e3 * LIGHTEST:.0f} g to {HEAVIEST:.0f} kg within a
minute of training? By

    {content["command"]}

on {machine_line(content["machine"])}.

{chr(10).join(rows)}

`{SCENARIO}` with {FLEET:,} vehicles (randomizer `vehicle`: mass, arms, inertia, rotors and their
lag by scaling laws; thrust to weight is drawn, too, and observed by nobody), throttles at 100 Hz,
15 s, and the rewards of `hover_learn`. Each episode draws one of them. Seconds: from the command to
the policy file that is judged, the last one within {SECONDS:.0f} s. It flies {EPISODES} episodes
with vehicles of another fleet, none of which it has seen. The error is the distance from the
target, averaged over an episode's last second, failed ones included; a failure is an episode that
terminates or faults.

A policy sees its last two actions, so that one without memory can learn how much throttle its
vehicle needs: it corrects what it did before.

Hyper-parameters that are not the learners' defaults, of the presets of `{SCENARIO}` and of this
script together:

{lines}

Versions: {versions_line(content["runs"])}.
"""


def main(arguments: list[str] | None = None) -> int:
    """Trains, evaluates, writes; returns the exit code."""
    parser = option_parser(__doc__)
    add = parser.add_argument
    add("--seeds", type=int, nargs="+", default=[1], help="seeds; default: 1")
    add("--train-only", action="store_true", help="only train; a later call evaluates and writes")
    add_quick(parser, f"a rollout of one learner with {QUICK_FLEET} vehicles")
    options = parser.parse_args(arguments)
    place_quick(options, "vehicle_policy")
    runs = make_runs(options.out, options.seeds, options.quick)
    try:
        for _, run in runs:
            measure(run)
        if options.train_only:
            return 0
        records = [record(name, run) for name, run in runs]
    except RunError as error:
        print(f"vehicle_policy: {error}", file=sys.stderr)
        return 2
    content = {
        **heading("one policy for many vehicles", "vehicle_policy.py", arguments),
        "runs": records,
    }
    write_page(options.report, "vehicle_policy", content, markdown(content))
    return 0


if __name__ == "__main__":
    run_program(main)
