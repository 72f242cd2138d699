"""Trains one policy with `fast-ppo` on a Ray cluster; see docs/ray.md.

python -m skybody.ray.train hover_learn --workers 4 --address HOST:PORT --out run
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from pathlib import Path
from typing import Any

from skybody._native import CompiledScenario, Error, InputError
from skybody.program import run_program
from skybody.ray.cluster import ADDRESS_HELP, LOCAL, ClusterError, check_cpus, cluster
from skybody.ray.slices import MOST_SLICES, RaySlices, Setup
from skybody.train import __main__ as command
from skybody.train.evaluate import check_option, in_our_words
from skybody.train.presets import UsageError
from skybody.train.requirements import TRAINING, demand_packages
from skybody.train.run_folder import Config

ALGORITHM = "fast-ppo"  # the one whose slices can be held elsewhere


def parser() -> argparse.ArgumentParser:
    """That of `python -m skybody.train`, and the cluster."""
    made = command.parser()
    made.prog = "python -m skybody.ray.train"
    made.description = (
        "Trains a policy with fast-ppo, whose environments are on the machines of a Ray cluster. "
        "The same bits as on one machine."
    )
    made.add_argument("--address", default=LOCAL, help=ADDRESS_HELP)
    made.add_argument(
        "--workers",
        type=int,
        default=2,
        metavar="N",
        help=f"that hold the {MOST_SLICES} slices of environments; default: 2. Changes no bits",
    )
    made.add_argument(
        "--worker-threads", type=int, default=1, metavar="T", help="of each worker; default: 1"
    )
    return made


def prepare(options: argparse.Namespace) -> tuple[Config, CompiledScenario]:
    """The run, checked as `python -m skybody.train` does, and the number of workers."""
    if options.algo not in (None, ALGORITHM):
        raise UsageError(f"--algo {options.algo}: on a cluster there is {ALGORITHM}")
    if not options.resume:
        options.algo = ALGORITHM
    config, compiled = command.prepare(options)
    if config.algorithm != ALGORITHM:
        raise UsageError(f"--out {options.out} is a run of {config.algorithm}, not of {ALGORITHM}")
    slices = slices_of(config)
    if not 1 <= options.workers <= slices:
        raise UsageError(
            f"--workers {options.workers}: 1 to {slices}, since the environments are cut into "
            f"{slices} slices; give each worker more threads instead (--worker-threads)"
        )
    check_option("--worker-threads", options.worker_threads, 1, MOST_SLICES)
    return config, compiled


def slices_of(config: Config) -> int:
    """Slices of the learner's environments."""
    return min(MOST_SLICES, config.hyper.envs)


def hold_slices(ray: Any, config: Config, options: argparse.Namespace) -> RaySlices:
    """Starts the workers."""
    cpus = options.workers * options.worker_threads
    check_cpus(ray, cpus, f"--workers {options.workers} --worker-threads {options.worker_threads}")
    is_file = Path(config.scenario).exists()
    setup = Setup(
        scenario=str(Path(config.scenario).absolute()) if is_file else config.scenario,
        overrides=config.overrides,
        plugin_path=[str(Path(folder).absolute()) for folder in config.searched],
        scenario_hash=config.scenario_hash,
        hyper=dict(vars(config.hyper)),
        seed=config.seed,
        total_steps=config.total_steps,
    )
    return RaySlices(ray, setup, slices_of(config), options.workers, options.worker_threads)


def main(arguments: list[str] | None = None) -> int:
    """Trains; returns the exit code."""
    options = parser().parse_args(arguments)
    with contextlib.ExitStack() as scope:
        try:
            demand_packages(TRAINING)
            config, compiled = prepare(options)
            ray = scope.enter_context(cluster(options.address))
            slices = hold_slices(ray, config, options)
            trainer = command.open_trainer(options, config, compiled, scope, slices)
        except BlockingIOError:
            print(f"train: --out {options.out}: another process trains there", file=sys.stderr)
            return 2
        except (UsageError, InputError, ClusterError, Error, OSError, ValueError) as error:
            print(f"train: {in_our_words(error)}", file=sys.stderr)
            return 2
        status = command.train(trainer)
        if slices.replaced:
            print(f"workers that died and were replaced: {slices.replaced}")
        return status


if __name__ == "__main__":
    run_program(main)
