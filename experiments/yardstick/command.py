#!/usr/bin/env python3
"""`skybody train` with the yardstick `lean-ppo`, which is no longer a learner of Skybody.

    .venv/bin/python experiments/yardstick/command.py hover_learn --algo lean-ppo [OPTIONS]

The same options, run folder and guarantees. learn_table.py runs it, so that rates of the current
learners are compared with one that does not change, on the same machine in the same run.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from skybody.program import run_program
from skybody.train.__main__ import main
from skybody.train.algorithms import ALGORITHMS, Algorithm
from skybody.train.hyperparameters import Hyperparameters

NAME = "lean-ppo"
TOTAL_STEPS = 9_000_000  # of a run on hover_learn
SETTINGS = (  # its hyper-parameters there
    "discount=0.98",
    "final_log_std=-2.7",
    "bounded_mean=true",
    "normalization_steps=1.5e6",
    "averaging_steps=3e5",
)


@dataclass(frozen=True)
class LeanHyperparameters(Hyperparameters):
    """Hyper-parameters of a learner in PyTorch; the value function has its own."""

    envs: int = 256
    rollout_steps: int = 32
    # One pass: a second one fits noise of the first one's advantages, and at the end little else.
    epochs: int = 1
    value_epochs: int = 5


def _make(*arguments: Any) -> Any:
    from lean_ppo import LeanPpo  # beside this file, which is the program

    return LeanPpo(*arguments)


ALGORITHMS[NAME] = Algorithm("lean PPO in Python, a yardstick", LeanHyperparameters, _make)


if __name__ == "__main__":
    run_program(main)
