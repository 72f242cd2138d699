"""`skybody train --ray`: one policy with `fast-ppo` on a Ray cluster; see docs/ray.md."""

from __future__ import annotations

import argparse
import contextlib

from skybody.ray.absolute_paths import absolute_scenario, folders_from_anywhere
from skybody.ray.cluster import check_cpus, cluster
from skybody.ray.slices import MOST_SLICES, RaySlices, Setup
from skybody.train.hyperparameters import UsageError
from skybody.train.run_folder import Config

ALGORITHM = "fast-ppo"  # the one whose slices can run on other machines
WORKERS = 2  # default number of workers


def check_options(options: argparse.Namespace) -> None:
    """Raises UsageError for options that a cluster does not support.

    Sets the defaults of --workers and of its threads.
    """
    if options.algo not in (None, ALGORITHM):
        raise UsageError(f"--algo {options.algo}: with --ray there is {ALGORITHM} alone")
    options.workers = WORKERS if options.workers is None else options.workers
    options.worker_threads = 1 if options.worker_threads is None else options.worker_threads


def hold_slices(
    options: argparse.Namespace, config: Config, scope: contextlib.ExitStack
) -> RaySlices:
    """Connects to the cluster and starts the workers, which live as long as `scope`.

    Raises:
        UsageError: the run of another learner, or more workers than slices.
        ClusterError: no such cluster, too few processors, or other versions there.
    """
    if config.algorithm != ALGORITHM:
        raise UsageError(f"--out {options.out} is a run of {config.algorithm}, not of {ALGORITHM}")
    slices = min(MOST_SLICES, config.hyper.envs)
    if not 1 <= options.workers <= slices:
        raise UsageError(
            f"--workers {options.workers}: 1 to {slices}, since the environments are cut into "
            f"{slices} slices; give each worker more threads instead (--worker-threads)"
        )
    ray = scope.enter_context(cluster(options.ray, option="--ray"))
    cpus = options.workers * options.worker_threads
    check_cpus(ray, cpus, f"--workers {options.workers} --worker-threads {options.worker_threads}")
    made = RaySlices(ray, setup_of(config), slices, options.workers, options.worker_threads)
    scope.callback(say_replaced, made)
    return made


def setup_of(config: Config) -> Setup:
    """The setup from which workers, in another working folder, create their slices."""
    return Setup(
        scenario=absolute_scenario(config.scenario),
        overrides=config.overrides,
        plugin_path=folders_from_anywhere(config.searched),
        scenario_hash=config.scenario_hash,
        hyper=dict(vars(config.hyper)),
        seed=config.seed,
        total_steps=config.total_steps,
    )


def say_replaced(slices: RaySlices) -> None:
    """Prints a line at the end if workers were lost."""
    if slices.replaced:
        print(f"workers that died and were replaced: {slices.replaced}")
