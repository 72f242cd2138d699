"""Hyper-parameters of the learners, their checks and their parsing."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from skybody._native import MOST_LAYERS, hyperparameter_rows, hyperparameters
from skybody.arguments import allowed_words
from skybody.command_line import parse_whole

SAME_KEYS = "fast-ppo"  # its ranges also hold for keys of the same name in other learners
STEPS_KEY = "total_steps"  # the only key of presets that is not a hyper-parameter


class UsageError(ValueError):
    """A wrong option or input file of the user; the text is the whole message.

    Attributes:
        key: of the hyper-parameter of a learner in Python that is out of range; else None.
    """

    def __init__(self, message: str, key: str | None = None) -> None:
        super().__init__(message)
        self.key = key


@dataclass(frozen=True)
class Hyperparameters:
    """Hyper-parameters of a learner in PyTorch; `steps` are steps of one environment.

    Keys that also exist in `fast-ppo` have the same meaning (`hyperparameter_rows`) and ranges.
    """

    envs: int = 64  # environments stepped in parallel
    rollout_steps: int = 128  # steps of each environment between two updates
    minibatch: int = 1024  # transitions per gradient step
    epochs: int = 5  # passes over a rollout
    learning_rate: float = 1e-3  # of Adam, at the beginning
    final_learning_rate: float = 0.05  # of Adam, at the start
    discount: float = 0.99  # share of `learning_rate` at the end; linear
    gae_lambda: float = 0.95  # of generalized advantage estimation
    clip_range: float = 0.2  # of the ratio of probabilities
    target_kl: float = 0.0  # stop a rollout's updates beyond 1.5 times this; 0: never
    entropy_weight: float = 0.0
    value_weight: float = 0.5
    max_grad_norm: float = 0.5  # maximum gradient norm; 0: no limit
    log_std: float = -1.0  # log of the actions' standard deviation at the start
    final_log_std: float = 0.0  # upper bound at the end, linear from `log_std`; 0: no bound
    bounded_mean: bool = False  # tanh on the mean of actions: noise then always has an effect
    hidden: tuple[int, ...] = (64, 64)  # tanh layers of the policy, and of the value function
    normalize_rewards: bool = True  # divide by the deviation of the discounted return
    observation_clip: float = 10.0  # of normalized observations
    normalization_steps: int = 0  # observation statistics freeze after these; 0: never
    averaging_steps: int = 0  # length of the mean that is kept as policy; 0: the last policy
    torch_threads: int = 1  # the bits of the result depend on this number

    def noise_limits(self, done: float) -> dict[str, float]:
        """Limits of the log of the standard deviation after a share `done` of the steps."""
        if self.final_log_std == 0.0:
            return {"min": -math.inf, "max": math.inf}
        least = min(self.log_std, self.final_log_std)
        line = self.log_std + min(1.0, done) * (self.final_log_std - self.log_std)
        return {"min": least, "max": line}

    def normalizes(self, steps: int) -> bool:
        """Whether observations after `steps` steps update the statistics."""
        return self.normalization_steps == 0 or steps < self.normalization_steps

    def check(self) -> None:
        """Raises UsageError for values that no learner can work with."""
        for name, value in vars(self).items():
            finite = not isinstance(value, float) or math.isfinite(value)
            _demand(finite, name, value, "a finite number")
        for name, least, largest, _ in hyperparameter_rows(SAME_KEYS):
            for value in _numbers(getattr(self, name, None)):
                allowed = f"{_plain(least)} to {_plain(largest)}"
                _demand(least <= value <= largest, name, value, allowed)
        _demand(self.torch_threads >= 1, "torch_threads", self.torch_threads, "at least 1")
        allowed = f"at most {MOST_LAYERS - 1}, as a policy file has {MOST_LAYERS} layers"
        sizes = f"{len(self.hidden)} sizes"
        _demand(len(self.hidden) < MOST_LAYERS, "hidden", sizes, f"{allowed} with the last one")
        rollout = self.envs * self.rollout_steps
        allowed = f"2 to envs * rollout_steps = {rollout}"
        _demand(2 <= self.minibatch <= rollout, "minibatch", self.minibatch, allowed)


@functools.cache
def native_defaults(algorithm: str) -> Any:
    """Default hyper-parameters of a learner in C++, as a dataclass."""

    def check(hyper: Any) -> None:
        """Raises UsageError for values that the learner does not accept."""
        try:
            hyperparameters(algorithm, vars(hyper))
        except ValueError as error:
            raise UsageError(str(error)) from None

    fields = [(name, type(value), value) for name, value in hyperparameters(algorithm).items()]
    return dataclasses.make_dataclass(
        "NativeHyperparameters", fields, frozen=True, namespace={"check": check}
    )()


def with_settings(base: Hyperparameters, settings: Sequence[str]) -> Hyperparameters:
    """`base` with settings `key=value` applied. Raises UsageError for an invalid one."""
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals:
            raise UsageError(f"--set {setting}: write KEY=VALUE")
        if key == STEPS_KEY:
            raise UsageError(f"--set {setting}: that is an option, --total-steps {text}")
        base = with_value(base, key, text, f"--set {setting}")
    return base


def with_value(
    base: Hyperparameters, key: str, text: str, where: str, others: Sequence[str] = ()
) -> Hyperparameters:
    """`base` with one value, given as a string.

    Args:
        where: place of the value, for messages.
        others: keys besides hyper-parameters that are allowed there, for messages.

    Raises:
        UsageError: there is no such key, or the string is not a value of it.
    """
    fields = {field.name: getattr(base, field.name) for field in dataclasses.fields(base)}
    if key not in fields:
        of_scenario = "; `--override` sets a value of the scenario"
        if "." in key:
            hint = f"{of_scenario}, `--set` a hyper-parameter"
        else:
            hint = allowed_words(key, [*fields, *others])
            hint += of_scenario if where.startswith("--set") else ""
        raise UsageError(f"{where}: no hyper-parameter `{key}`{hint}")
    return dataclasses.replace(base, **{key: _parse(where, text, fields[key])})


def from_dict(values: dict[str, Any], defaults: Any) -> Hyperparameters:
    """The inverse of dataclasses.asdict, from JSON.

    Args:
        defaults: of the learner.

    Raises:
        ValueError: these are not its hyper-parameters.
    """
    known = {field.name for field in dataclasses.fields(defaults)}
    if other := known ^ set(values):
        raise ValueError(
            f"hyper-parameters of another learner or version: {', '.join(sorted(other))}"
        )
    wrong = [name for name, value in values.items() if not _is_like(value, getattr(defaults, name))]
    if wrong:
        raise ValueError(f"`hyper.{wrong[0]}` is no such value")
    made: Hyperparameters = dataclasses.replace(
        defaults, **{**values, "hidden": tuple(values["hidden"])}
    )
    return made


def _is_like(value: Any, default: Any) -> bool:
    """Whether a value from JSON has the type of its default."""
    if isinstance(default, tuple):
        return isinstance(value, list) and all(type(size) is int for size in value)
    return type(value) is type(default) or (isinstance(default, float) and type(value) is int)


def whole_number(text: str, where: str) -> int:
    """A whole number, also as 2e6. Raises UsageError for other strings."""
    try:
        return parse_whole(text)
    except ValueError:
        raise UsageError(f"{where}: `{text}` is not an integer") from None


def _parse(where: str, text: str, like: Any) -> Any:
    try:
        if isinstance(like, bool):
            return {"true": True, "false": False}[text.lower()]
        if isinstance(like, tuple):
            inner = text.strip("[]() ")
            return tuple(int(size) for size in inner.split(",")) if inner else ()
        if isinstance(like, str):
            return text
        return whole_number(text, where) if isinstance(like, int) else float(text)
    except UsageError:
        raise
    except (ValueError, KeyError):
        form = {bool: "true or false", tuple: "sizes as 64,64"}
        wanted = form.get(type(like), "a number")
        raise UsageError(f"{where}: `{text}` is not {wanted}") from None


def _numbers(value: Any) -> tuple[float, ...]:
    """The numbers to which a range applies: each of a list; none of a bool."""
    if isinstance(value, tuple):
        return value
    return (value,) if isinstance(value, (int, float)) and not isinstance(value, bool) else ()


def _plain(limit: float) -> str:
    return f"{int(limit)}" if limit.is_integer() and abs(limit) < 1e9 else f"{limit:g}"


def _demand(good: bool, name: str, value: object, allowed: str) -> None:
    if not good:
        raise UsageError(f"hyper-parameter {name} = {value}: allowed is {allowed}", name)
