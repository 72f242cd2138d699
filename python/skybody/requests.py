"""What callers may ask randomizable parameters to become, in words that C++ reads."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

from .arguments import text

When: TypeAlias = Literal["next_step", "next_reset"]


class Draw(TypedDict, total=False):
    """A value that is drawn anew for each environment."""

    distribution: Literal["uniform", "log_uniform", "normal", "choice"]
    """What it is drawn from; "uniform" where it is left out."""
    range: Sequence[float]
    """[low, high]: of uniform and log_uniform; where a normal distribution is cut off."""
    mean: float
    """Of a normal distribution."""
    deviation: float
    """Of a normal distribution, its standard deviation before it is cut off."""
    values: Sequence[float]
    """What a choice is among."""
    weights: Sequence[float]
    """Of these values, adding up to 1; left out: all alike."""
    form: Literal["value", "scale", "shift"]
    """What is drawn is the value itself, a factor on the nominal value, or added to it."""
    shared: bool
    """One draw for all values that the path names, not one for each."""


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
    """Raises ValueError for what is neither "next_step" nor "next_reset"."""
    if when not in ("next_step", "next_reset"):
        raise ValueError(f'when is {when!r}; it must be "next_step" or "next_reset"')
    return when == "next_reset"


def request_lines(changes: Mapping[str, Change]) -> list[str]:
    """One line for each value or draw, as `read_param_change` in core/env takes it.

    Raises:
        TypeError, ValueError: naming the path and what is wrong.
    """
    lines: list[str] = []
    for path, change in changes.items():
        text("path", path)
        if isinstance(change, Mapping):
            lines.append(f"{path} {_draw_words(path, change)}")
            continue
        values = np.asarray(change, dtype=np.float64)
        if values.ndim == 0:
            lines.append(f"{path} value each constant {_number(path, values)}")
        elif values.ndim == 1 and values.size > 0:
            lines += [
                f"{path}[{k}] value each constant {_number(path, v)}" for k, v in enumerate(values)
            ]
        else:
            raise ValueError(f"{path} is given values of shape {values.shape}; give (n,) or one")
    return lines


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
    values = draw.get("values", ())
    given = {"weights": [1.0 / len(values)] * len(values)} if kind == "choice" and values else {}
    numbers: list[str] = []
    for key in _NUMBERS[kind]:
        if key not in draw and key not in given:
            raise ValueError(f"{path} needs {key!r} for distribution {kind!r}")
        value = np.atleast_1d(np.asarray(draw.get(key, given.get(key)), dtype=np.float64))
        if key == "range" and value.shape != (2,):
            raise ValueError(f"{path} has a range of {value.size} numbers; write [low, high]")
        numbers += [_number(path, v) for v in value]
    shared = "shared" if draw.get("shared", False) else "each"
    return f"{form} {shared} {kind} {' '.join(numbers)}"
