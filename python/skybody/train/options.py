"""The command line of `skybody train`."""

from __future__ import annotations

import argparse
from pathlib import Path

from skybody.ray.cluster import ADDRESSES
from skybody.train import evaluate
from skybody.train.algorithms import summaries
from skybody.train.hyperparameters import UsageError, whole_number

EPILOG = """\
A run can be resumed after Ctrl-C, SIGTERM or kill -9; the result has the same bits as that of an
uninterrupted run. Exit status: 0 done, 2 invalid input, a file that cannot be written (resumable)
or a run that diverged, 130 interrupted (resumable)."""


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = argparse.ArgumentParser(
        prog="skybody train",
        usage="skybody train SCENARIO [OPTIONS]\n       skybody train --resume --out DIR [OPTIONS]",
        description="Trains a policy in a scenario, reproducibly; see docs/training.md.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = made.add_argument
    add("scenario", nargs="?", help="name of a shipped scenario, or a YAML file")
    add("--algo", metavar="LEARNER", help=summaries())
    add("--seed", type=int, help="seed of environments, networks and exploration; default: 0")
    add(
        "--total-steps",
        type=number,
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
    add("--envs", type=int, metavar="N", help="number of environments; default: the preset's")
    add(
        "--threads",
        type=int,
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
        type=number,
        metavar="N",
        help="steps between checkpoints; default: a tenth of --total-steps",
    )
    add(
        "--eval-episodes",
        type=int,
        metavar="N",
        help="evaluation episodes per checkpoint, in a separate process; default: 20, 0: none",
    )
    add(
        "--eval-seed",
        type=int,
        metavar="S",
        help=f"seed of the evaluation episodes; default: {evaluate.SEED}",
    )
    cluster = made.add_argument_group("several machines (docs/ray.md)").add_argument
    cluster("--ray", metavar="ADDRESS", help=f"train with fast-ppo on a Ray cluster: {ADDRESSES}")
    cluster(
        "--workers",
        type=int,
        metavar="N",
        help="processes with the environments, 1 to 8; default: 2. Changes no bits",
    )
    cluster("--worker-threads", type=int, metavar="T", help="threads of each worker; default: 1")
    return made


def number(text: str) -> int:
    """A whole number, also as 2e6."""
    try:
        return whole_number(text, "a number of steps")
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
