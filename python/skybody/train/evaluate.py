"""Evaluates a checkpoint: deterministic policy, frozen normalization, episodes of a fixed seed.

    python -P -m skybody.train.evaluate CHECKPOINT [--episodes 100] [--seed 1000] [--json FILE]
    python -P -m skybody.train.evaluate shipped --scenario NAME

Episode i is that of environment i under the seed, whatever the number of episodes. The network is
evaluated from policy.h5, the file for `skybody run --policy`, without PyTorch.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skybody._native import (
    CompiledScenario,
    Error,
    InputError,
    ObservationColumn,
    Pool,
    printable,
)
from skybody.arguments import MOST_ENVS, MOST_THREADS, check_plugin_path
from skybody.command_line import CommandLine, report_error, whole
from skybody.observations import values_of
from skybody.program import run_program
from skybody.train import files
from skybody.train.checkpoint import check_file, read_meta, resolve
from skybody.train.hyperparameters import UsageError
from skybody.train.learner import columns_of, goal_distance
from skybody.train.policy_file import Policy, read_policy, shipped_policy
from skybody.train.run_folder import load_recorded

SUCCESS = "success"  # info value of tasks that report success (docs/task_kit.md)
SHIPPED = "shipped"  # in place of a checkpoint: the policy shipped with Skybody
SEED = 1000  # default of evaluation episodes; training seeds draw other episodes


def evaluate(
    compiled: CompiledScenario, policy: Policy, episodes: int, seed: int, threads: int = 0
) -> dict[str, Any]:
    """Flies one episode in each of `episodes` environments; returns the figures of summarize()."""
    pool = Pool(
        compiled,
        episodes,
        num_threads=threads,
        order="fixed",
        autoreset="disabled",
        seed=seed,
    )
    try:
        return summarize(_fly(compiled, policy, pool))
    finally:
        pool.close()


@dataclass
class Flights:
    """Results of the episodes, one row per episode."""

    returns: NDArray[np.float64]
    errors: NDArray[np.float64]  # position error, mean over the last second [m]; nan: none
    lengths: NDArray[np.int64]
    failed: NDArray[np.bool_]  # ended by a fault, or by the task without success
    info_names: list[str] = field(default_factory=list)  # of info values with one component
    info_sums: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))
    info_ends: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))


def _fly(compiled: CompiledScenario, policy: Policy, pool: Pool) -> Flights:
    """Flies the episode of every environment to its end."""
    n = pool.num_envs
    second = max(1, round(1.0 / (compiled.dt * compiled.action_repeat)))
    errors = np.full((n, second), np.nan)
    returns, lengths = np.zeros(n), np.zeros(n, np.int64)
    failed, flying = np.zeros(n, bool), np.ones(n, bool)
    infos = [channel for channel in compiled.info_channels if channel.count == 1]
    places = [channel.first for channel in infos]
    info_names = [channel.name for channel in infos]
    info_sums, info_ends = np.zeros((n, len(infos))), np.zeros((n, len(infos)))
    states = policy.states(n)
    columns = [_column_of(compiled, image.column) for image in policy.images]
    pool.send_reset()
    batch = pool.recv()
    observation = np.array(batch.observation)
    pixels = [np.array(values_of(c, batch.observation, batch.image)) for c in columns]
    while flying.any():
        ids = np.flatnonzero(flying).astype(np.int32)
        remembered = states[ids]
        actions = policy(observation[ids], remembered, [seen[ids] for seen in pixels])
        states[ids] = remembered
        pool.send(np.ascontiguousarray(actions, dtype=np.float32), ids)
        batch = pool.recv()
        ids = batch.env_id
        observation[ids] = batch.observation
        for seen, column in zip(pixels, columns, strict=True):
            seen[ids] = values_of(column, batch.observation, batch.image)
        returns[ids] += batch.reward
        errors[ids, lengths[ids] % second] = _position_error(compiled, batch)
        info_ends[ids] = batch.info[:, places]
        info_sums[ids] += info_ends[ids]
        lengths[ids] += 1
        failed[ids] = batch.terminated | batch.fault
        flying[ids] = ~(batch.terminated | batch.truncated)
    if SUCCESS in info_names:  # a success that ends the episode is not a failure
        failed &= info_ends[:, info_names.index(SUCCESS)] < 0.5
    known = ~np.isnan(errors)
    mean_error = np.where(known, errors, 0.0).sum(1) / np.maximum(known.sum(1), 1)
    mean_error = np.where(known.any(1), mean_error, np.nan)
    return Flights(returns, mean_error, lengths, failed, info_names, info_sums, info_ends)


def _column_of(compiled: CompiledScenario, name: str) -> ObservationColumn:
    """The column of an image. Raises ValueError if the scenario does not observe it."""
    for column in compiled.observation_columns:
        if column.image >= 0 and column.name == name:
            return column
    raise ValueError(f"the policy sees `{name}`, which {compiled.name} does not observe")


def _position_error(compiled: CompiledScenario, batch: Any) -> NDArray[np.float64]:
    """Distance from the goal per row [m]; nan if neither infos nor observations contain it."""
    for channels, rows in (
        (compiled.info_channels, batch.info),
        (compiled.observation_channels, batch.observation),
    ):
        if (distance := goal_distance(columns_of(channels, rows))) is not None:
            return distance
    return np.full(len(batch.reward), np.nan)


def summarize(flights: Flights) -> dict[str, Any]:
    """The figures of an evaluation; CV: standard deviation of the returns over their mean."""
    returns, errors, failed = flights.returns, flights.errors, flights.failed
    mean, deviation = float(returns.mean()), float(returns.std())
    known = errors[~np.isnan(errors)]
    steps = np.maximum(flights.lengths, 1)
    infos = {
        name: {
            "mean": _finite((flights.info_sums[:, k] / steps).mean()),
            "end": _finite(flights.info_ends[:, k].mean()),
        }
        for k, name in enumerate(flights.info_names)
    }
    return {
        "episodes": len(returns),
        "return_mean": mean,
        "return_std": deviation,
        "return_cv": deviation / abs(mean) if mean else None,
        "position_error_median": float(np.median(known)) if len(known) else None,
        "position_error_mean": float(known.mean()) if len(known) else None,
        "position_error_p95": float(np.percentile(known, 95)) if len(known) else None,
        "length_mean": float(flights.lengths.mean()),
        "success_share": float(1.0 - failed.mean()),
        "reached_share": infos[SUCCESS]["end"] if SUCCESS in infos else None,
        "infos": infos,
        "returns": returns.tolist(),
        "position_errors": [None if math.isnan(e) else e for e in errors.tolist()],
        "failed": failed.tolist(),
    }


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def evaluate_checkpoint(
    path: Path,
    episodes: int,
    seed: int,
    scenario: str | None = None,
    overrides: list[str] | None = None,
    threads: int = 0,
    plugin_path: list[str] | None = None,
) -> dict[str, Any]:
    """Evaluates a checkpoint, or a run's newest one, in the scenario in which it was trained.

    Plugins come from `plugin_path` and the default folders. Folders recorded in the checkpoint
    are not searched: a checkpoint must not choose code to run.
    """
    folder = resolve(path)
    meta = read_meta(folder)
    plugin_path = plugin_path or []
    check_plugin_path(plugin_path, "--plugin-path")
    warn_of_plugin_path(folder, meta["plugin_path"], plugin_path)
    if overrides is None:
        overrides = meta["overrides"] if scenario is None else []
    if scenario is None:
        compiled = load_recorded(folder / "meta.json", meta["scenario"], overrides, plugin_path)
    else:
        compiled = CompiledScenario(scenario, overrides, plugin_path)
    found = f"{compiled.scenario_hash:016x}"
    _warn_of_scenario(meta["scenario_hash"], found)
    stamps = {
        "checkpoint": folder.name,
        "steps": meta["steps"],
        "wall_clock": meta["wall_clock"],
        "parameter_hash": meta["parameter_hash"],
        "scenario_hash": found,
        "seed": seed,
    }
    policy = read_policy(check_file(folder, meta, "policy.h5"))
    return {**stamps, **_evaluate_fitting(compiled, policy, str(folder), episodes, seed, threads)}


def evaluate_shipped(
    scenario: str,
    episodes: int,
    seed: int,
    overrides: list[str] | None = None,
    threads: int = 0,
    plugin_path: list[str] | None = None,
) -> dict[str, Any]:
    """Evaluates the policy that is shipped for a scenario.

    Raises:
        Error: there is none; the message lists the shipped policies.
    """
    compiled = CompiledScenario(scenario, overrides or [], plugin_path or [])
    file = shipped_policy(compiled.name, str(scenario))
    policy = read_policy(file)
    found = f"{compiled.scenario_hash:016x}"
    _warn_of_scenario(str(policy.attributes["scenario_hash"]), found)
    stamps = {
        "checkpoint": SHIPPED,
        "steps": int(policy.attributes["steps"]),
        "scenario_hash": found,
        "seed": seed,
    }
    return {**stamps, **_evaluate_fitting(compiled, policy, str(file), episodes, seed, threads)}


def _warn_of_scenario(trained: str, found: str) -> None:
    if found == trained:
        return
    print(f"warning: trained on scenario {trained}, evaluated in {found}", file=sys.stderr)


def _evaluate_fitting(
    compiled: CompiledScenario, policy: Policy, where: str, episodes: int, seed: int, threads: int
) -> dict[str, Any]:
    """Evaluates a policy in a scenario. Raises ValueError if their sizes differ."""
    if compiled.horizon == 0:
        raise ValueError(f"{compiled.name} has no horizon: its episodes might never end")
    seen = policy.sizes()["observation_size"]
    if seen != compiled.observation_size:
        raise ValueError(
            f"{where}: the policy takes {seen} observations, "
            f"{compiled.name} gives {compiled.observation_size}"
        )
    for image in policy.images:
        shape = (*_column_of(compiled, image.column).shape, 1)[:3]
        if shape != image.shape:
            raise ValueError(
                f"{where}: the policy takes `{image.column}` of {image.shape}, "
                f"{compiled.name} gives {shape}"
            )
    return evaluate(compiled, policy, episodes, seed, threads)


def warn_of_plugin_path(where: Path, recorded: list[str], given: list[str]) -> None:
    """Names the recorded folders with plugins that are not given again, so are not searched."""
    searched = {os.path.realpath(folder) for folder in given}
    for folder in recorded:
        if os.path.realpath(folder) not in searched:
            name = printable(os.fsencode(folder))
            print(
                f"warning: {where} was made with plugins from `{name}`, which is not "
                "searched; if you trust this folder, give it with --plugin-path",
                file=sys.stderr,
            )


def in_our_words(error: Exception) -> str:
    """The text of an error. The loader, shared with `skybody run`, calls overrides --set."""
    if isinstance(error, UsageError):  # our own: --set is a hyper-parameter
        return str(error)
    if isinstance(error, OSError):
        return files.explain(error)
    return re.sub("^--set ", "--override ", str(error), flags=re.MULTILINE)


def _evaluate_asked(options: argparse.Namespace) -> dict[str, Any]:
    """Runs the evaluation of the command line."""
    if str(options.checkpoint) == SHIPPED:
        if options.scenario is None:
            raise ValueError("shipped: give --scenario NAME, whose policy is to fly")
        return evaluate_shipped(
            options.scenario,
            options.episodes,
            options.seed,
            options.override,
            options.threads,
            options.plugin_path,
        )
    return evaluate_checkpoint(
        options.checkpoint,
        options.episodes,
        options.seed,
        options.scenario,
        options.override,
        options.threads,
        options.plugin_path,
    )


def main(arguments: list[str] | None = None) -> int:
    """The command line."""
    parser = CommandLine(
        prog="python -P -m skybody.train.evaluate", description=(__doc__ or "").partition("\n")[0]
    )
    parser.add_argument(
        "checkpoint",
        type=Path,
        help="a checkpoint, a run folder (its newest checkpoint), or `shipped`",
    )
    parser.add_argument(
        "--episodes", type=whole(1, MOST_ENVS), default=100, help="number of episodes; default: 100"
    )
    parser.add_argument(
        "--seed",
        type=whole(0, 2**64 - 1),
        default=SEED,
        help=f"seed of the episodes; default: {SEED}",
    )
    parser.add_argument("--scenario", help="scenario; default: the checkpoint's")
    parser.add_argument(
        "--override",
        action="append",
        metavar="PATH=VALUE",
        help="override one value of the scenario; repeatable",
    )
    parser.add_argument(
        "--plugin-path",
        action="append",
        metavar="DIR",
        help="folder to search for plugins first; repeatable",
    )
    parser.add_argument(
        "--threads",
        type=whole(0, MOST_THREADS),
        default=0,
        help="number of threads; 0: one per processor",
    )
    parser.add_argument(
        "--json", type=Path, help="also write the figures of every episode to this file"
    )
    options = parser.parse_args(arguments)
    try:
        result = _evaluate_asked(options)
        if options.json:
            files.write_file(options.json, (json.dumps(result, indent=1) + "\n").encode())
    except (InputError, Error, OSError, ValueError) as error:
        return report_error(in_our_words(error))
    print(json.dumps({k: v for k, v in result.items() if not isinstance(v, list)}, indent=2))
    return 0


if __name__ == "__main__":
    run_program(main)
