"""Keyword options of all environment constructors: type, default and meaning, declared once.

A class or function takes a set of options by `@takes(KIND)`, where KIND is one of the TypedDicts
below, and `**options: Unpack[KIND]`. Its body finds all of them in `options`; an option that the
caller left out has its default.
"""

from __future__ import annotations

import functools
import inspect
import os
import textwrap
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum
from typing import Annotated, Any, Literal, TypedDict, TypeVar, get_args, get_type_hints

import numpy as np

from .arguments import allowed_words, word_error

Order = Literal["fixed", "arrival"]
Autoreset = Literal["next_step", "same_step", "disabled"]


@dataclass(frozen=True)
class Option:
    """Default and description of an option, attached to its type."""

    default: Any
    doc: str


# Options that several TypedDicts share.
_SEED = (
    "key of all random numbers until a reset with another seed; environment i draws from (seed, i)."
)
Seed = Annotated[int, Option(0, _SEED)]
SeedOrNone = Annotated[
    int | None,
    Option(
        None,
        _SEED + " None: a reset without a seed uses one from the system, as in Gymnasium.",
    ),
]
EnvId = Annotated[
    int, Option(0, "number of the environment, the second half of the key (seed, env_id).")
]
DictObservations = Annotated[
    bool,
    Option(
        False,
        "observations are dictionaries of arrays, by column name; always so with images.",
    ),
]
AutoresetOption = Annotated[
    Autoreset | Enum,
    Option(
        "next_step",
        "behaviour at the end of an episode, as a word or as Gymnasium's AutoresetMode. "
        '"next_step": the next action is ignored and the environment reset; "same_step": reset at '
        "once, and the infos contain the last observation of the ended episode as `final_obs`; "
        '"disabled": the caller resets.',
    ),
]


class ScenarioOptions(TypedDict, total=False):
    """Changes to the scenario, and the folders of its plugins."""

    overrides: Annotated[
        Iterable[str], Option((), '"PATH=VALUE" each, as for `skybody run --set`.')
    ]
    plugin_path: Annotated[
        Iterable[str | os.PathLike[str]],
        Option((), "folders to search for plugins before the default ones."),
    ]


class SimulationOptions(ScenarioOptions, total=False):
    """Options of `Simulation`."""

    seed: Seed
    env_id: EnvId


class EnvOptions(ScenarioOptions, total=False):
    """Options of `SkybodyEnv` and `ParallelEnv`: one environment."""

    seed: SeedOrNone
    env_id: EnvId
    dict_observations: DictObservations


class ThreadedOptions(ScenarioOptions, total=False):
    """Options of all classes that step many environments."""

    seed: Seed
    num_threads: Annotated[
        int, Option(0, "number of threads, including the caller's; 0: one per processor.")
    ]
    pin_threads: Annotated[
        bool, Option(False, "pin each worker to a separate processor, if the system allows it.")
    ]


class SimulationPoolOptions(ThreadedOptions, total=False):
    """Options of `SimulationPool`."""

    first_env_id: Annotated[int, Option(0, "environment i draws from (seed, first_env_id + i).")]


class TaskOptions(ThreadedOptions, total=False):
    """Options of `PythonTaskVectorEnv`."""

    autoreset: AutoresetOption


class PooledOptions(ThreadedOptions, total=False):
    """Options of all classes that step a native pool; `SkybodyVecEnv` takes exactly these."""

    dict_observations: DictObservations
    keep_hash: Annotated[
        bool, Option(False, "compute a trajectory hash of each environment, for `hash`.")
    ]


class BatchOptions(PooledOptions, total=False):
    """Options of both `Pool` and `SkybodyVectorEnv`."""

    autoreset: AutoresetOption
    infos: Annotated[
        bool,
        Option(
            True,
            "whether infos contain info values (the task's, then those of other plugins); if not, "
            "tasks need not compute them.",
        ),
    ]
    debug: Annotated[
        bool,
        Option(
            False,
            "raise BufferError instead of recycling memory that is still referenced, and fill "
            "recycled memory with NaN.",
        ),
    ]


class PoolOptions(BatchOptions, total=False):
    """Options of `make_pool` and `Pool`."""

    order: Annotated[
        Order,
        Option(
            "arrival",
            '"arrival": in order of completion; "fixed": by id, cyclically, so that partial '
            "batches are the same in every run.",
        ),
    ]
    batch_size: Annotated[
        int, Option(0, "number of rows of one `recv`, at most num_envs; 0: num_envs.")
    ]


class VectorOptions(BatchOptions, total=False):
    """Options of `make_vec` and `SkybodyVectorEnv`."""

    joint: Annotated[
        bool,
        Option(
            False,
            "for teams of equal robots: observations and actions are (num_envs, agents, width), "
            "views of the same memory, with the team's reward; a single robot is a team of one.",
        ),
    ]


def options_of(kind: type) -> dict[str, tuple[Any, Option]]:
    """Type and Option of each key of a TypedDict of options."""
    hints = get_type_hints(kind, include_extras=True)
    return {name: get_args(hint) for name, hint in hints.items()}


def order_word(order: str) -> Order:
    """Returns `order`. Raises ValueError for an unknown word."""
    words: tuple[Order, ...] = get_args(Order)
    for word in words:
        if order == word:
            return word
    raise word_error("order", order, words)


def autoreset_word(autoreset: str | Enum) -> Autoreset:
    """The word for a word, for Gymnasium's AutoresetMode, or for its value.

    Raises:
        ValueError: an unknown mode.
    """
    value = getattr(autoreset, "value", autoreset)
    words: tuple[Autoreset, ...] = get_args(Autoreset)
    for word in words:
        if value in (word, word.title().replace("_", "")):
            return word
    raise word_error("autoreset", autoreset, words)


Taker = TypeVar("Taker", bound=Callable[..., Any])


def takes(kind: type) -> Callable[[Taker], Taker]:
    """Decorates a function or class that takes `**options` of `kind`.

    The body finds all options in `options`, with defaults for those that a call leaves out. The
    signature and the documentation (`help`) list each option. An unknown keyword raises a TypeError
    with the nearest option's name. A flag with a value other than True or False raises a TypeError.
    """
    options = options_of(kind)

    def decorated(taker: Taker) -> Taker:
        is_class = inspect.isclass(taker)
        function = vars(taker)["__init__"] if is_class else taker
        filling = _filling(function, taker.__name__, options)
        if not is_class:
            filling.__doc__ = _documented(taker.__doc__, options)
            return filling  # type: ignore[return-value]
        setattr(taker, "__init__", filling)  # noqa: B010 (mypy refuses the assignment)
        taker.__doc__ = _documented(taker.__doc__, options)
        return taker

    return decorated


def _filling(
    function: Callable[..., Any], name: str, options: dict[str, tuple[Any, Option]]
) -> Callable[..., Any]:
    """Wraps `function`: adds the defaults of the options that a call leaves out."""
    signature = inspect.signature(function)
    own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
    flags = [key for key, (kind, _) in options.items() if kind is bool]
    keywords = [*(p.name for p in own if p.name != "self"), *options]
    defaults = {key: option.default for key, (_, option) in options.items()}

    @functools.wraps(function)
    def filled(*arguments: Any, **given: Any) -> Any:
        for keyword in given:
            if keyword not in keywords:
                hint = allowed_words(keyword, keywords)
                # Python's own wording: TorchRL, for example, searches for it.
                said = f"{name}() got an unexpected keyword argument '{keyword}'"
                raise TypeError(said + hint)
        for flag in flags:
            if flag in given and not isinstance(given[flag], (bool, np.bool_)):
                raise TypeError(f"{flag} is {given[flag]!r}; it must be True or False")
        return function(*arguments, **{**defaults, **given})

    added = [
        inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=option.default, annotation=t)
        for key, (t, option) in options.items()
    ]
    vars(filled)["__signature__"] = signature.replace(parameters=[*own, *added])
    return filled


def _documented(text: str | None, options: dict[str, tuple[Any, Option]]) -> str:
    """A docstring with a section for the options, before its section Raises."""
    lines = ["Keyword Args:"]
    for name, (_, option) in options.items():
        lines += textwrap.wrap(
            f"{name}: {option.doc}", 96, initial_indent=" " * 4, subsequent_indent=" " * 8
        )
    before, raises, after = inspect.cleandoc(text or "").partition("\nRaises:\n")
    return before.rstrip() + "\n\n" + "\n".join(lines) + "\n" + raises + after
