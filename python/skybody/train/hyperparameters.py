"""What a learner is told: its hyper-parameters, their checks and their texts."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from skybody._native import MOST_LAYERS, hyperparameter_rows, hyperparameters
from skybody.arguments import allowed_words

SAME_KEYS = "fast-ppo"  # whose ranges hold for keys of the same name, too
STEPS_KEY = "total_steps"  # the one key of presets that is no hyper-parameter


class UsageError(ValueError):
    """A wrong option or input file of the user's; the text is the whole message.

    Attributes:
        key: of the hyper-parameter that is beyond its range; None where it is something else.
    """

    def __init__(self, message: str, key: str | None = None) -> None:
        super().__init__(message)
        self.key = key


@dataclass(frozen=True)
class Hyperparameters:
    """What a learner in PyTorch is told; `steps` are steps of one environment.

    Keys that `fast-ppo` has mean what they mean there (`hyperparameter_rows`), with its ranges.
    """

    envs: int = 64  # environments that are stepped side by side
    rollout_steps: int = 128  # steps of each environment between two updates
    minibatch: int = 1024  # transitions per gradient step
    epochs: int = 5  # passes over a rollout
    learning_rate: float = 1e-3  # of Adam, at the beginning
    final_learning_rate: float = 0.05  # at the end, as a share of `learning_rate`; linear between
    discount: float = 0.99  # gamma
    gae_lambda: float = 0.95  # of generalized advantage estimation
    clip_range: float = 0.2  # of the ratio of probabilities
    target_kl: float = 0.0  # stop a rollout's updates beyond 1.5 times this; 0: never
    entropy_weight: float = 0.0
    value_weight: float = 0.5
    max_grad_norm: float = 0.5  # gradients are scaled down to this norm; 0: never
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
    """The engine's list for a learner in C++, as the others have theirs."""

    def check(hyper: Any) -> None:
        """Raises UsageError for values that the learner cannot work with."""
        try:
            hyperparameters(algorithm, vars(hyper))
        except ValueError as error:
            raise UsageError(str(error), _wrong_key(algorithm, vars(hyper))) from None

    fields = [(name, type(value), value) for name, value in hyperparameters(algorithm).items()]
    return dataclasses.make_dataclass(
        "NativeHyperparameters", fields, frozen=True, namespace={"check": check}
    )()


def _wrong_key(algorithm: str, values: Mapping[str, Any]) -> str | None:
    """The key of a value that a learner in C++ refuses: the value alone, or beside the others."""
    defaults = hyperparameters(algorithm)
    for name, value in values.items():
        if not _is_possible(algorithm, {name: value}):
            return name
    for name in values:
        if _is_possible(algorithm, {**values, name: defaults[name]}):
            return name
    return None


def _is_possible(algorithm: str, values: dict[str, Any]) -> bool:
    try:
        hyperparameters(algorithm, values)
    except ValueError:
        return False
    return True


def with_settings(base: Hyperparameters, settings: Sequence[str]) -> Hyperparameters:
    """`base` with texts `key=value` applied. Raises UsageError for what does not fit."""
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
    """`base` with one value, written as a text.

    Args:
        where: it is written, for messages.
        others: keys besides hyper-parameters that are allowed there, for messages.

    Raises:
        UsageError: there is no such key, or the text is no value of it.
    """
    fields = {field.name: getattr(base, field.name) for field in dataclasses.fields(base)}
    if key not in fields:
        hint = allowed_words(key, [*fields, *others])
        raise UsageError(f"{where}: no hyper-parameter `{key}`{hint}")
    return dataclasses.replace(base, **{key: _parse(where, text, fields[key])})


def from_dict(values: dict[str, Any], defaults: Any) -> Hyperparameters:
    """The inverse of dataclasses.asdict, after a way through JSON.

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
    """Whether a value from JSON is of its default's kind."""
    if isinstance(default, tuple):
        return isinstance(value, list) and all(type(size) is int for size in value)
    return type(value) is type(default) or (isinstance(default, float) and type(value) is int)


def whole_number(text: str, where: str) -> int:
    """A whole number, also as 2e6. Raises UsageError for another text."""
    try:
        return int(text)
    except ValueError:
        pass
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not value.is_integer():
        raise UsageError(f"{where}: `{text}` is not an integer")
    return int(value)


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
    """Those that have a range: of a list each, of truths none."""
    if isinstance(value, tuple):
        return value
    return (value,) if isinstance(value, (int, float)) and not isinstance(value, bool) else ()


def _plain(limit: float) -> str:
    return f"{int(limit)}" if limit.is_integer() and abs(limit) < 1e9 else f"{limit:g}"


def _demand(good: bool, name: str, value: object, allowed: str) -> None:
    if not good:
        raise UsageError(f"hyper-parameter {name} = {value}: allowed is {allowed}", name)
