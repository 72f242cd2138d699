"""Keyword options of all environment constructors: type and meaning of each.

A constructor declares its options as keyword-only parameters of these types. An option has the same
default in all constructors, except for `seed` (`Seed` or `SeedOrNone`).
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from typing import Annotated, Any, Literal, get_args

from .arguments import allowed_words, word_error

Order = Literal["fixed", "arrival"]
Autoreset = Literal["next_step", "same_step", "disabled"]

Overrides = Annotated[Iterable[str], '"PATH=VALUE" each, as for `skybody run --set`.']
PluginPath = Annotated[
    Iterable[str | os.PathLike[str]], "folders to search for plugins before the default ones."
]
Seed = Annotated[
    int,
    "key of all random numbers until a reset with another seed; environment i draws from (seed, "
    "i).",
]
SeedOrNone = Annotated[
    int | None,
    "key of all random numbers until a reset with another seed; environment i draws from (seed, "
    "i). None: a reset without a seed uses one from the system, as in Gymnasium.",
]
EnvId = Annotated[int, "number of the environment, the second half of the key (seed, env_id)."]
FirstEnvId = Annotated[int, "environment i draws from (seed, first_env_id + i)."]
NumThreads = Annotated[int, "number of threads, including the caller's; 0: one per processor."]
PinThreads = Annotated[bool, "pin each worker to a separate processor, if the system allows it."]
Steps = Annotated[int, "greatest number of recorded transitions between two resets."]
KeepHash = Annotated[
    bool, "compute a trajectory hash of each environment, for `hash`; much slower: for checks."
]
DictObservations = Annotated[
    bool, "observations are dictionaries of arrays, by column name; always so with images."
]
AutoresetOption = Annotated[
    Autoreset | Enum,
    "behaviour at the end of an episode, as a word or as Gymnasium's AutoresetMode. "
    '"next_step": the next action is ignored and the environment reset; "same_step": reset at '
    "once, and the infos contain the last observation of the ended episode as `final_obs`; "
    '"disabled": the caller resets.',
]
Infos = Annotated[
    bool,
    "whether infos contain info values (the task's, then those of other plugins); if not, tasks "
    "need not compute them.",
]
Debug = Annotated[
    bool,
    "raise BufferError instead of recycling memory that is still referenced, and fill recycled "
    "memory with NaN.",
]
OrderOption = Annotated[
    Order,
    '"arrival": in order of completion; "fixed": by id, cyclically, so that partial batches are '
    "the same in every run.",
]
BatchSize = Annotated[int, "number of rows of one `recv`, at most num_envs; 0: num_envs."]
Joint = Annotated[
    bool,
    "for teams of equal robots: observations and actions are (num_envs, agents, width), views of "
    "the same memory, with the team's reward; a single robot is a team of one.",
]

RenderSize = Annotated[tuple[int, int], "width and height of the pictures of `render` [pixels]."]
RenderCamera = Annotated[
    str,
    "of the pictures of `render`: orbit (about the robots), chase or onboard (of the first robot), "
    "fixed.",
]


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


def refuse_unknown(taker: Callable[..., Any], unknown: Mapping[str, Any]) -> None:
    """Raises TypeError, with the nearest option's name, for keywords that `taker` does not know."""
    for keyword in unknown:
        parameters = inspect.signature(taker).parameters.values()
        known = [p.name for p in parameters if p.kind is not p.VAR_KEYWORD]
        # Python's own wording: TorchRL, for example, searches for it.
        said = f"{taker.__name__}() got an unexpected keyword argument '{keyword}'"
        raise TypeError(said + allowed_words(keyword, known))
