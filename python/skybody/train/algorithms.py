"""The table of learners."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from skybody.arguments import allowed_words
from skybody.train.hyperparameters import Hyperparameters, UsageError, native_defaults

if TYPE_CHECKING:
    from skybody.train.learner import Learner


@dataclass(frozen=True)
class Algorithm:
    """A learner; its key in ALGORITHMS is the value of `--algo`."""

    summary: str  # for --help
    defaults: Callable[[], Any]  # its hyper-parameters, with a method check()
    # arguments: compiled, hyper, seed, threads, total_steps; imports its packages itself
    make: Callable[..., Learner]
    # in C++: NumPy checkpoints, averages its policy itself, needs no PyTorch
    is_native: bool = False
    sees_images: bool = False  # else scenarios that observe images are refused


def _fast_ppo(*arguments: Any) -> Learner:
    from skybody.train.native_learners import FastPpo

    return FastPpo(*arguments)


def _gradient(*arguments: Any) -> Learner:
    from skybody.train.native_learners import GradientLearner

    return GradientLearner(*arguments)


def _sb3_ppo(*arguments: Any) -> Learner:
    from skybody.train.sb3_ppo import Sb3Ppo

    return Sb3Ppo(*arguments)


ALGORITHMS: dict[str, Algorithm] = {
    "fast-ppo": Algorithm(
        "PPO in C++", lambda: native_defaults("fast-ppo"), _fast_ppo, True, sees_images=True
    ),
    "gradient": Algorithm(
        "gradient descent through the dynamics, in C++",
        lambda: native_defaults("gradient"),
        _gradient,
        True,
        sees_images=True,
    ),
    "ppo": Algorithm("PPO of Stable-Baselines3", Hyperparameters, _sb3_ppo),
}
DEFAULT_ALGORITHM = "fast-ppo"
NATIVE = tuple(name for name, algorithm in ALGORITHMS.items() if algorithm.is_native)

# Removed learners, with the error message for each.
GONE = {"lean-ppo": "has gone: `fast-ppo` learns by the same method, several times as quick"}


def algorithm_of(name: str) -> Algorithm:
    """The learner of that name. Raises UsageError, with the nearest name, if there is none."""
    if name in GONE and name not in ALGORITHMS:
        raise UsageError(f"the learner `{name}` {GONE[name]}")
    if name not in ALGORITHMS:
        raise UsageError(f"no learner `{name}`{allowed_words(name, ALGORITHMS)}")
    return ALGORITHMS[name]


def summaries() -> str:
    """Summaries of all learners, for --help."""
    rows = (
        f"{name}{' (default)' if name == DEFAULT_ALGORITHM else ''}: {algorithm.summary}"
        for name, algorithm in ALGORITHMS.items()
    )
    return "; ".join(rows)
