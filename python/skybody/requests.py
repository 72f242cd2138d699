"""Requested values of randomizable parameters, as text lines for C++."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

from ._native import CompiledScenario
from .arguments import text

When: TypeAlias = Literal["next_step", "next_reset"]


class Draw(TypedDict, total=False):
    """A value that is drawn separately for each environment."""

    distribution: Literal["uniform", "log_uniform", "normal", "choice"]
    """The distribution; default: "uniform"."""
    range: Sequence[float]
    """[low, high]: of uniform and log_uniform; the truncation limits of a normal distribution."""
    mean: float
    """Of a normal distribution."""
    deviation: float
    """Of a normal distribution, its standard deviation before truncation."""
    values: Sequence[float]
    """The values of a choice."""
    weights: Sequence[float]
    """Weights of these values, adding up to 1; default: equal."""
    form: Literal["value", "scale", "shift"]
    """The draw is the value itself, a factor on the nominal value, or added to it."""
    shared: bool
    """One draw for all values that the path names, instead of one for each."""


Change: TypeAlias = float | Sequence[float] | NDArray[Any] | Draw

_NUMBERS = {
    "uniform": ("range",),
    "log_uniform": ("range",),
    "normal": ("mean", "deviation", "range"),
    "choice": ("values", "weights"),
}
_FORMS = ("value", "scale", "shift")
_KEYS = ("distribution", "form", "shared", *dict.fromkeys(sum(_NUMBERS.values(), ())))


def at_reset(when: str) -> bool:
    """Whether it is "next_reset". Raises ValueError for another word than "next_step"."""
    if when not in ("next_step", "next_reset"):
        raise ValueError(f'when is {when!r}; it must be "next_step" or "next_reset"')
    return when == "next_reset"


def request_lines(compiled: CompiledScenario, changes: Mapping[str, Change]) -> list[str]:
    """One line for each value or draw, in the format of `read_param_change` in core/env.

    Raises:
        TypeError, ValueError: naming the path and the problem.
    """
    if not isinstance(changes, Mapping):
        raise TypeError(f"changes are {changes!r}; they must be a dict of paths and what they get")
    lines: list[str] = []
    for path, change in changes.items():
        text("path", path)
        if isinstance(change, Mapping):
            lines.append(f"{path} {_draw_words(path, change)}")
            continue
        values = _numbers(path, change, "a number, a list of numbers for a vector, or a draw")
        if values.ndim == 0:
            compiled.check_one_value(path)
            lines.append(f"{path} value each constant {_number(path, values)}")
        elif values.ndim == 1 and values.size > 0:
            compiled.check_vector(path, values.size)
            lines += [
                f"{path}[{k}] value each constant {_number(path, v)}" for k, v in enumerate(values)
            ]
        else:
            raise ValueError(f"{path} is given values of shape {values.shape}; give (n,) or one")
    return lines


def _numbers(path: str, given: Any, wanted: str) -> NDArray[np.float64]:
    """`given` as numbers. Raises TypeError for booleans, strings, None and ragged lists."""
    try:
        values = np.asarray(given)
    except ValueError:  # rows of different lengths
        values = np.asarray(None)
    if not np.issubdtype(values.dtype, np.integer) and not np.issubdtype(values.dtype, np.floating):
        raise TypeError(f"{path} is given {given!r}; it must be {wanted}")
    return values.astype(np.float64)


def _number(path: str, value: Any) -> str:
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{path} is given {number}; it must be finite")
    return repr(number)


def _draw_words(path: str, draw: Mapping[str, Any]) -> str:
    for key in draw:
        if key not in _KEYS:
            raise ValueError(f"{path} has {key!r}; there are {', '.join(_KEYS)}")
    kind = draw.get("distribution", "uniform")
    if kind not in _NUMBERS:
        raise ValueError(f"{path} has distribution {kind!r}; there are {', '.join(_NUMBERS)}")
    form = draw.get("form", "value")
    if form not in _FORMS:
        raise ValueError(f"{path} has form {form!r}; there are {', '.join(_FORMS)}")
    for key in draw:
        if key not in ("distribution", "form", "shared", *_NUMBERS[kind]):
            raise ValueError(f"{path} has {key!r}, which {kind} does not know")
    values = np.atleast_1d(_numbers(path, draw.get("values", 0), "`values`, a list of numbers"))
    given = {"weights": [1.0 / len(values)] * len(values)} if kind == "choice" else {}
    numbers: list[str] = []
    for key in _NUMBERS[kind]:
        if key not in draw and key not in given:
            raise ValueError(f"{path} needs {key!r} for distribution {kind!r}")
        wanted = f"numbers for {key!r}"
        value = np.atleast_1d(_numbers(path, draw.get(key, given.get(key)), wanted))
        if key == "range" and value.shape != (2,):
            raise ValueError(f"{path} has a range of {value.size} numbers; write [low, high]")
        numbers += [_number(path, v) for v in value]
        if key in ("mean", "deviation") and value.shape != (1,):
            raise ValueError(f"{path} has {value.size} numbers as {key!r}; give one")
        if key == "weights" and value.shape != values.shape:
            raise ValueError(
                f"{path} has {values.size} values and {value.size} weights; give one for each"
            )
    if not isinstance(draw.get("shared", False), bool):
        raise TypeError(f"{path} has shared {draw['shared']!r}; it must be True or False")
    shared = "shared" if draw.get("shared", False) else "each"
    return f"{form} {shared} {kind} {' '.join(numbers)}"
