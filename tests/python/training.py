"""Helpers shared by the tests of training: a small run's command line, and the learners."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from skybody._native import CompiledScenario
from skybody.train.__main__ import main
from skybody.train.algorithms import algorithm_of

SCENARIO = "hover_learn"
HORIZON = "stepping.horizon=40"  # so that episodes are truncated within a rollout
SMALL = {"envs": 6, "rollout_steps": 50, "minibatch": 100, "epochs": 2, "hidden": (8, 8)}
ROLLOUTS = 30

both = pytest.mark.parametrize("algorithm", ["ppo", "fast-ppo"])


@contextmanager
def learner_of(
    algorithm: str,
    compiled: CompiledScenario,
    seed: int = 1,
    threads: int = 1,
    total_steps: int = 10_000,
    **changes: Any,
) -> Iterator[Any]:
    """A learner with SMALL hyper-parameters, some replaced by `changes`."""
    row = algorithm_of(algorithm)
    hyper = dataclasses.replace(row.defaults(), **{**SMALL, **changes})
    made: Any = row.make(compiled, hyper, seed, threads, total_steps)
    try:
        yield made
    finally:
        made.close()


def arguments(algorithm: str, out: Path) -> list[str]:
    """A run of ROLLOUTS rollouts with a checkpoint after every second one."""
    command = [
        SCENARIO,
        "--algo",
        algorithm,
        "--seed",
        "3",
        "--out",
        str(out),
        "--override",
        HORIZON,
    ]
    command += ["--total-steps", str(300 * ROLLOUTS), "--checkpoint-every", "600"]
    command += ["--eval-episodes", "0", "--threads", "1", "--envs", "6"]
    for setting in ("rollout_steps=50", "minibatch=100", "epochs=2", "hidden=8,8"):
        command += ["--set", setting]
    return command


def finished_run(out: Path) -> Path:
    """A short run of fast-ppo with evaluations."""
    command = arguments("fast-ppo", out)
    command[command.index("--total-steps") + 1] = "1200"
    command[command.index("--eval-episodes") + 1] = "3"
    assert main(command) == 0
    return out
