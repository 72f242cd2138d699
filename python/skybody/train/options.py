"""The command line of `skybody train`."""

from __future__ import annotations

import argparse
from pathlib import Path

from skybody.arguments import MOST_ENVS, MOST_THREADS
from skybody.command_line import CommandLine, whole
from skybody.ray.cluster import ADDRESSES
from skybody.ray.slices import MOST_SLICES
from skybody.train import evaluate
from skybody.train.algorithms import summaries

EPILOG = """\
A run can be resumed after Ctrl-C, SIGTERM or kill -9; the result has the same bits as that of an
uninterrupted run. Exit status: 0 done, 2 invalid input, a file that cannot be written (resumable)
or a run that diverged, 130 interrupted (resumable)."""

MOST_STEPS = 2**63 - 1
RANGES = {
    "seed": (0, 2**32 - 1),  # of NumPy's global generator, which Stable-Baselines3 uses
    "total_steps": (1, MOST_STEPS),
    "checkpoint_every": (1, MOST_STEPS),
    "threads": (0, MOST_THREADS),
    "eval_episodes": (0, MOST_ENVS),
    "eval_seed": (0, 2**64 - 1),
}


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = CommandLine(
        prog="skybody train",
        usage="skybody train SCENARIO [OPTIONS]\n       skybody train --resume --out DIR [OPTIONS]",
        description="Trains a policy in a scenario, reproducibly; see docs/training.md.",
        epilog=EPILOG,
    )
    add = made.add_argument
    add("scenario", nargs="?", help="name of a shipped scenario, or a YAML file")
    add("--algo", metavar="LEARNER", help=summaries())
    add(
        "--seed",
        type=whole(*RANGES["seed"]),
        help="seed of environments, networks and exploration; default: 0",
    )
    add(
        "--total-steps",
        type=whole(*RANGES["total_steps"]),
        metavar="N",
        help="total steps of all environments, such as 9e6; default: the preset's, otherwise 1e6",
    )
    add(
        "--out",
        type=Path,
        metavar="DIR",
        help="run folder, new or empty; default: a new folder flights/SCENARIO_ALGO",
    )
    add("--resume", action="store_true", help="continue from the newest checkpoint in --out")
    add(
        "--envs",
        type=whole(1, MOST_ENVS),
        metavar="N",
        help="number of environments; default: the preset's",
    )
    add(
        "--threads",
        type=whole(*RANGES["threads"]),
        metavar="T",
        help="threads of the environments and the learner (ppo: of the environments); 0 "
        "(default): one per processor; changes no bits",
    )
    add(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a hyper-parameter, such as learning_rate=3e-4 or hidden=64,64; docs/training.md "
        "lists all; repeatable",
    )
    add(
        "--override",
        action="append",
        metavar="PATH=VALUE",
        help="override one value of the scenario, as skybody run --set; repeatable",
    )
    add(
        "--plugin-path",
        action="append",
        metavar="DIR",
        help="folder to search for plugins first; repeatable",
    )
    add(
        "--checkpoint-every",
        type=whole(*RANGES["checkpoint_every"]),
        metavar="N",
        help="steps between checkpoints; default: a tenth of --total-steps",
    )
    add(
        "--eval-episodes",
        type=whole(*RANGES["eval_episodes"]),
        metavar="N",
        help="evaluation episodes per checkpoint, in a separate process; default: 20, 0: none",
    )
    add(
        "--eval-seed",
        type=whole(*RANGES["eval_seed"]),
        metavar="S",
        help=f"seed of the evaluation episodes; default: {evaluate.SEED}",
    )
    cluster = made.add_argument_group("several machines (docs/ray.md)").add_argument
    cluster("--ray", metavar="ADDRESS", help=f"train with fast-ppo on a Ray cluster: {ADDRESSES}")
    cluster(
        "--workers",
        type=whole(1, MOST_SLICES),
        metavar="N",
        help="processes with the environments, 1 to 8; default: 2. Changes no bits",
    )
    cluster(
        "--worker-threads",
        type=whole(1, MOST_SLICES),
        metavar="T",
        help="threads of each worker; default: 1",
    )
    return made
