"""Checks of common arguments: scenarios, seeds, ids. Each mistake raises one clear error."""

from __future__ import annotations

import difflib
import operator
import os
from collections.abc import Collection, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ._native import CompiledScenario

Scenario = str | os.PathLike[str] | CompiledScenario

MOST_ENVS = 2**24  # limits of the native pools
MOST_THREADS = 1024


def load(
    scenario: Scenario,
    overrides: Iterable[str],
    plugin_path: Iterable[str | os.PathLike[str]],
) -> CompiledScenario:
    """Loads a scenario by the name of a shipped one or from a YAML file; a loaded one is shared.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        TypeError: a single string in place of a list, or `scenario` is neither a string nor a path.
        ValueError: overrides or plugin_path with a compiled scenario; a folder of plugin_path that
            does not exist.
    """
    for name, given in (("overrides", overrides), ("plugin_path", plugin_path)):
        if isinstance(given, str):
            raise TypeError(f"`{name}` is one text; give a list: [{given!r}]")
    paths = [path_text("a folder of plugin_path", folder) for folder in plugin_path]
    check_plugin_path(paths, "plugin_path")
    changes = list(overrides)
    if isinstance(scenario, CompiledScenario):
        if changes or paths:
            raise ValueError(
                f"`{scenario.name}` is loaded already, overrides and plugin_path come too late: "
                "give them to CompiledScenario(...), or give the scenario's name here"
            )
        return scenario
    return CompiledScenario(path_text("scenario", scenario), changes, paths)


def path_text(name: str, value: Any) -> str:
    """A string or path as a string. Raises TypeError, which names the argument, for other types."""
    path = os.fspath(value) if isinstance(value, os.PathLike) else value
    return text(name, path, "a text or a path")


def text(name: str, value: Any, wanted: str = "a text") -> str:
    """Returns `value` if it is a string. Raises TypeError, which names the argument, otherwise."""
    if not isinstance(value, str):
        raise TypeError(f"{name} is {value!r}; it must be {wanted}")
    return value


def check_plugin_path(folders: Iterable[str], name: str) -> None:
    """Raises ValueError for a missing folder; `name` is the argument's name in the message."""
    for folder in folders:
        if not os.path.isdir(folder):
            raise ValueError(
                f"{name}: directory does not exist: {folder}; give a folder with plugins, or leave "
                "it out"
            )


def flag(name: str, value: Any) -> bool:
    """`value` as a bool. Raises TypeError, which names the argument, for other types."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} is {value!r}; it must be True or False")
    return bool(value)


def integer(name: str, value: Any) -> int:
    """`value` as an int. Raises TypeError, which names the argument, for other types."""
    try:
        return operator.index(value)
    except TypeError:
        raise TypeError(f"{name} is {value!r}; it must be an integer") from None


def integer_within(name: str, value: Any, low: int, high: int) -> int:
    """`value` as an int from `low` to `high`, so that it fits the type in C++.

    Raises:
        TypeError: it is not an integer.
        ValueError: it is out of range.
    """
    number = integer(name, value)
    if not low <= number <= high:
        raise ValueError(f"{name} is {number}; it must be from {low} to {high}")
    return number


def shape_error(name: str, array: NDArray[Any], shape: object) -> ValueError:
    """The error for an array whose shape is not `shape`, in the words of the native module."""
    return ValueError(f"{name} has shape {array.shape}; expected {shape}")


def word_error(name: str, value: Any, words: Iterable[str]) -> ValueError:
    """The error for a value that is not one of `words`."""
    return ValueError(f"{name} is {value!r}; it must be one of {', '.join(words)}")


def allowed_words(word: str, words: Collection[str]) -> str:
    """End of a message about an unknown word: the nearest match, and all of `words`."""
    nearest = difflib.get_close_matches(word, words, n=1)
    hint = f"; did you mean `{nearest[0]}`?" if nearest else "."
    return f"{hint} Allowed: {', '.join(words)}"


def check_array(
    name: str, values: ArrayLike, shape: tuple[int, ...], dtype: DTypeLike | None = None
) -> NDArray[Any]:
    """`values` as an array of this shape and dtype; nothing is converted silently.

    Raises:
        TypeError: another dtype.
        ValueError: another shape.
    """
    array = np.asarray(values)
    if dtype is not None and array.dtype != dtype:
        wanted = np.dtype(dtype).name
        raise TypeError(
            f"{name} has dtype {array.dtype}; expected {wanted}: convert with "
            f".astype(numpy.{wanted})"
        )
    if array.shape != shape:
        raise shape_error(name, array, shape)
    return array


def check_seed(seed: Any) -> int | None:
    """A seed as an int from 0 to 2**64 - 1, or None.

    Raises:
        TypeError: it is a list, or not an integer.
        ValueError: it is out of range.
    """
    if seed is None:
        return None
    try:
        value = operator.index(seed)
    except TypeError:
        raise TypeError(
            f"seed is a {type(seed).__name__}; give one integer for all environments: environment "
            "i draws its own numbers from (seed, i)"
        ) from None
    if not 0 <= value < 2**64:
        raise ValueError(f"seed is {value}; it must be from 0 to 2**64 - 1")
    return value


def env_ids(ids: ArrayLike) -> NDArray[np.int32]:
    """Ids of environments, (n,) int32. Raises TypeError if they are not integers."""
    given = np.asarray(ids)
    if given.dtype == np.int32:  # the usual case, without the slower checks
        return np.ascontiguousarray(given)
    if given.size == 0:
        return np.empty(0, np.int32)
    if not np.issubdtype(given.dtype, np.integer):
        raise TypeError(f"ids of environments are {given.dtype}; they must be integers")
    given = np.clip(given, -1, 2**31 - 1)  # an id out of range stays out of range
    return np.ascontiguousarray(given, np.int32)
