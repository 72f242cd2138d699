"""Hyper-parameters, and which of them each scenario is trained with. Edit PRESETS to tune."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from skybody._native import hyperparameters
from skybody.arguments import MOST_ENVS, allowed_words

ALGORITHMS = ("fast-ppo", "gradient", "lean-ppo", "ppo")
NATIVE = ("fast-ppo", "gradient")  # in C++: they have the engine's list of hyper-parameters
DEFAULT_ALGORITHM = "fast-ppo"


class UsageError(ValueError):
    """A wrong option or input file of the user's; the text is the whole message."""


@dataclass(frozen=True)
class Hyperparameters:
    """What both learners are told; `steps` are steps of one environment."""

    envs: int = 64  # environments that are stepped side by side
    rollout_steps: int = 128  # steps of each environment between two updates
    minibatch: int = 1024  # transitions per gradient step
    epochs: int = 5  # passes over a rollout
    value_epochs: int = 5  # the value function's, where it learns by itself (lean-ppo)
    learning_rate: float = 1e-3  # of Adam, at the beginning
    final_learning_rate: float = 0.05  # at the end, as a share of `learning_rate`; linear between
    discount: float = 0.99  # gamma
    gae_lambda: float = 0.95  # of generalized advantage estimation
    clip_range: float = 0.2  # of the ratio of probabilities
    target_kl: float = 0.0  # stop a rollout's updates beyond 1.5 times this; 0: never
    entropy_weight: float = 0.0
    value_weight: float = 0.5
    max_grad_norm: float = 0.5
    log_std: float = -1.0  # of the actions' standard deviation, at the beginning
    final_log_std: float = 0.0  # at the end: learned below the line of the two; 0: learned freely
    bounded_mean: bool = False  # actions' mean through a tanh: noise always tells about actions
    hidden: tuple[int, ...] = (64, 64)  # tanh layers, of policy and value function each
    normalize_rewards: bool = True  # divide by the deviation of the discounted return
    observation_clip: float = 10.0  # of normalized observations
    normalization_steps: int = 0  # after which observations' statistics stay; 0: they never do
    averaging_steps: int = 0  # the policy that is kept is a mean over about so many; 0: the last
    torch_threads: int = 1  # bits of the result belong to this number

    def noise_limits(self, done: float) -> dict[str, float]:
        """Least and largest log of the standard deviation after a share `done` of the steps."""
        if self.final_log_std == 0.0:
            return {"min": -math.inf, "max": math.inf}
        least = min(self.log_std, self.final_log_std)
        line = self.log_std + min(1.0, done) * (self.final_log_std - self.log_std)
        return {"min": least, "max": line}

    def normalizes(self, steps: int) -> bool:
        """Whether observations after `steps` steps still count for their statistics."""
        return self.normalization_steps == 0 or steps < self.normalization_steps

    def check(self) -> None:
        """Raises UsageError for values that no learner can work with."""
        for name, value in vars(self).items():
            finite = not isinstance(value, float) or math.isfinite(value)
            _demand(finite, name, value, "a finite number")
        for name in (
            "envs",
            "rollout_steps",
            "minibatch",
            "epochs",
            "value_epochs",
            "torch_threads",
        ):
            _demand(getattr(self, name) >= 1, name, getattr(self, name), "at least 1")
        _demand(self.envs <= MOST_ENVS, "envs", self.envs, f"at most {MOST_ENVS}")
        for name in ("learning_rate", "max_grad_norm", "observation_clip", "clip_range"):
            _demand(getattr(self, name) > 0, name, getattr(self, name), "above 0")
        for name in ("discount", "gae_lambda", "final_learning_rate"):
            _demand(0 <= getattr(self, name) <= 1, name, getattr(self, name), "0 to 1")
        for name in ("target_kl", "entropy_weight", "value_weight"):
            _demand(getattr(self, name) >= 0, name, getattr(self, name), "at least 0")
        for name in ("normalization_steps", "averaging_steps"):
            _demand(getattr(self, name) >= 0, name, getattr(self, name), "at least 0")
        _demand(min(self.hidden, default=1) >= 1, "hidden", self.hidden, "sizes of at least 1")
        rollout = self.envs * self.rollout_steps
        allowed = f"2 to envs * rollout_steps = {rollout}"
        _demand(2 <= self.minibatch <= rollout, "minibatch", self.minibatch, allowed)


def _native(algorithm: str) -> Any:
    """The engine's list for an algorithm of NATIVE, as the other learners have theirs."""

    def check(hyper: Any) -> None:
        """Raises UsageError for values that the learner cannot work with."""
        try:
            hyperparameters(algorithm, vars(hyper))
        except ValueError as error:
            raise UsageError(str(error)) from None

    fields = [(name, type(value), value) for name, value in hyperparameters(algorithm).items()]
    return dataclasses.make_dataclass(
        "NativeHyperparameters", fields, frozen=True, namespace={"check": check}
    )()


# What differs from the defaults above: first an algorithm's own ("*"), then a scenario's besides.
_HOVER_LEARN: dict[str, Any] = {
    "discount": 0.98,
    "final_log_std": -2.7,
    "bounded_mean": True,
    "normalization_steps": 1_500_000,
    "averaging_steps": 300_000,
}
PRESETS: dict[tuple[str, str], dict[str, Any]] = {
    # One pass: a second one fits noise of the first one's advantages, and in the end little else.
    ("*", "lean-ppo"): {"envs": 256, "rollout_steps": 32, "epochs": 1},
    ("*", "gradient"): {"envs": 32, "learning_rate": 6e-3, "max_grad_norm": 1.0},
    ("hover_learn", "fast-ppo"): _HOVER_LEARN,
    ("hover_learn", "gradient"): {
        "envs": 128,
        "rollout_steps": 32,
        "learning_rate": 6e-3,
        "max_grad_norm": 1.0,
        "normalization_steps": 200_000.0,
        "averaging_steps": 80_000.0,
        "reward_weight": 0.3,
        "approach_speed": 3.5,
    },
    ("hover_learn", "lean-ppo"): _HOVER_LEARN,
    ("hover_learn", "ppo"): {"minibatch": 512, "epochs": 2, **_HOVER_LEARN},
}

HORIZON = 0.64  # s, over which `gradient` goes back: less, and nothing has moved yet
MOST_HORIZON = 640  # transitions, which are remembered

# Environment steps of a run that was told no number.
TOTAL_STEPS: dict[tuple[str, str], int] = {
    ("hover_learn", "fast-ppo"): 9_000_000,
    ("hover_learn", "gradient"): 1_750_000,
    ("hover_learn", "lean-ppo"): 9_000_000,
    ("hover_learn", "ppo"): 15_000_000,
}


def total_steps(scenario: str, algorithm: str) -> int:
    """Environment steps of a scenario (its name) and an algorithm, where nobody says."""
    return TOTAL_STEPS.get((scenario, algorithm), 1_000_000)


def preset(scenario: str, algorithm: str, action_seconds: float | None = None) -> Hyperparameters:
    """The hyper-parameters for a scenario (its name) and an algorithm of ALGORITHMS.

    `action_seconds`: how long an action lasts; `gradient` then looks HORIZON ahead where the
    scenario has no preset of its own.
    """
    layers = (PRESETS.get((name, algorithm), {}) for name in ("*", scenario))
    changes = {key: value for layer in layers for key, value in layer.items()}
    if algorithm == "gradient" and action_seconds and (scenario, algorithm) not in PRESETS:
        changes["rollout_steps"] = min(MOST_HORIZON, max(1, round(HORIZON / action_seconds)))
    made: Hyperparameters = dataclasses.replace(_defaults(algorithm), **changes)
    return made


def _defaults(algorithm: str) -> Any:
    return _native(algorithm) if algorithm in NATIVE else Hyperparameters()


def with_settings(base: Hyperparameters, settings: Sequence[str]) -> Hyperparameters:
    """`base` with texts `key=value` applied. Raises UsageError for what does not fit."""
    fields = {field.name: getattr(base, field.name) for field in dataclasses.fields(base)}
    changes: dict[str, Any] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals:
            raise UsageError(f"--set {setting}: write KEY=VALUE")
        if key not in fields:
            hint = allowed_words(key, fields)
            raise UsageError(f"--set {setting}: no hyper-parameter `{key}`{hint}")
        changes[key] = _parse(setting, text, fields[key])
    return dataclasses.replace(base, **changes)


def from_dict(values: dict[str, Any], algorithm: str) -> Hyperparameters:
    """The inverse of dataclasses.asdict, after a way through JSON. Raises KeyError for others."""
    defaults = _defaults(algorithm)
    known = {field.name for field in dataclasses.fields(defaults)}
    if other := known ^ set(values):
        raise KeyError(f"hyper-parameters of another version: {', '.join(sorted(other))}")
    made: Hyperparameters = dataclasses.replace(
        defaults, **{**values, "hidden": tuple(values["hidden"])}
    )
    return made


def _parse(setting: str, text: str, like: Any) -> Any:
    try:
        if isinstance(like, bool):
            return {"true": True, "false": False}[text.lower()]
        if isinstance(like, tuple):
            return tuple(int(size) for size in text.strip("[]()").split(",") if size.strip())
        if isinstance(like, str):
            return text
        return int(text) if isinstance(like, int) else float(text)
    except (ValueError, KeyError):
        form = {bool: "true or false", tuple: "sizes as 64,64", int: "an integer"}
        wanted = form.get(type(like), "a number")
        raise UsageError(f"--set {setting}: `{text}` is not {wanted}") from None


def _demand(good: bool, name: str, value: object, allowed: str) -> None:
    if not good:
        raise UsageError(f"hyper-parameter {name} = {value}: allowed is {allowed}")
