"""The command line of `skybody train`."""

from __future__ import annotations

import argparse
from pathlib import Path

from skybody.ray.cluster import ADDRESSES
from skybody.train import evaluate
from skybody.train.algorithms import summaries
from skybody.train.hyperparameters import UsageError, whole_number

EPILOG = """\
A run folder can be resumed after Ctrl-C, SIGTERM or kill -9 and then ends with the same bits as a
run that was never interrupted. Exit codes: 0 done, 2 wrong input, a file that cannot be written
(resumable) or a run that diverged, 130 interrupted (resumable)."""


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = argparse.ArgumentParser(
        prog="skybody train",
        usage="skybody train SCENARIO [OPTIONS]\n       skybody train --resume --out DIR [OPTIONS]",
        description="Trains a policy in a scenario, reproducibly. docs/training.md says more.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = made.add_argument
    add("scenario", nargs="?", help="name of a shipped scenario, or a YAML file")
    add("--algo", metavar="LEARNER", help=summaries())
    add("--seed", type=int, help="of environments, networks and exploration; default: 0")
    add(
        "--total-steps",
        type=number,
        metavar="N",
        help="steps over all environments, may be written as 9e6; default: the preset's, else 1e6",
    )
    add(
        "--out",
        type=Path,
        metavar="DIR",
        help="run folder; must be new or empty; default: a new one, flights/SCENARIO_ALGO",
    )
    add("--resume", action="store_true", help="go on from the newest checkpoint in --out")
    add("--envs", type=int, metavar="N", help="environments; default: the preset's")
    add(
        "--threads",
        type=int,
        metavar="T",
        help="of environments and learner (of ppo: of environments), 0 (default): one a processor; "
        "changes no bits",
    )
    add(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a hyper-parameter (learning_rate=3e-4, hidden=64,64), of those that docs/training.md "
        "lists; repeatable",
    )
    add(
        "--override",
        action="append",
        metavar="PATH=VALUE",
        help="of the scenario, as skybody run --set; repeatable",
    )
    add(
        "--plugin-path",
        action="append",
        metavar="DIR",
        help="where to look for plugins first; repeatable",
    )
    add(
        "--checkpoint-every",
        type=number,
        metavar="N",
        help="steps; default: a tenth of --total-steps",
    )
    add(
        "--eval-episodes",
        type=int,
        metavar="N",
        help="per checkpoint, in a process of its own; default: 20, 0: none",
    )
    add("--eval-seed", type=int, metavar="S", help=f"of their episodes; default: {evaluate.SEED}")
    cluster = made.add_argument_group("several machines (docs/ray.md)").add_argument
    cluster("--ray", metavar="ADDRESS", help=f"train with fast-ppo on a Ray cluster: {ADDRESSES}")
    cluster(
        "--workers",
        type=int,
        metavar="N",
        help="processes that hold its environments, 1 to 8; default: 2. Changes no bits",
    )
    cluster("--worker-threads", type=int, metavar="T", help="of each of them; default: 1")
    return made


def number(text: str) -> int:
    """A whole number, also as 2e6."""
    try:
        return whole_number(text, "a number of steps")
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
