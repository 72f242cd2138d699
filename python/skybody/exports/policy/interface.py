"""Inputs and outputs of a policy by name, from the scenario's observation and action."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skybody import CompiledScenario, InputError
from skybody._native import ObservationColumn
from skybody.train.policy_file import Agent, Policy

from .commands import Value, values_of

# Columns of the task kit whose values are actions of the steps before, the newest first.
PAST_ACTIONS = re.compile(r"actions? .*in \[-1, 1\]; -1 (at a reset|before the first)")
BEFORE_THE_FIRST = -1.0  # past actions at the beginning of an episode
KEYWORDS = [
    "auto",
    "break",
    "case",
    "char",
    "const",
    "continue",
    "default",
    "do",
    "double",
    "else",
    "enum",
    "extern",
    "float",
    "for",
    "goto",
    "if",
    "inline",
    "int",
    "long",
    "register",
    "restrict",
    "return",
    "short",
    "signed",
    "sizeof",
    "static",
    "struct",
    "switch",
    "typedef",
    "union",
    "unsigned",
    "void",
    "volatile",
    "while",
    "class",
    "new",
    "delete",
    "this",
    "template",
    "operator",
    "private",
    "public",
    "protected",
    "bool",
    "true",
    "false",
]


@dataclass(frozen=True)
class Signal:
    """Values of a column among the network's inputs."""

    name: str  # a C identifier
    column: str
    unit: str  # SI; empty: a pure number
    meaning: str
    low: float
    high: float
    first: int  # among the network's inputs
    count: int
    actions: range | None = None  # past actions: which of the outputs they are; None: an input


@dataclass(frozen=True)
class Image:
    """An image that the policy sees."""

    name: str
    column: str
    shape: tuple[int, int, int]  # height, width, channels
    dtype: str  # of a pixel: float32, uint8, uint16
    unit: str
    meaning: str
    low: float  # pixels are clipped to this range
    high: float


@dataclass(frozen=True)
class Output:
    """One value of the command."""

    name: str
    unit: str
    meaning: str
    low: list[float]  # of the action -1; of each robot that shares the policy, or one for all
    high: list[float]  # of the action +1


@dataclass(frozen=True)
class Interface:
    """Inputs and outputs of one evaluation: of one robot, if robots share the policy."""

    signals: list[Signal]
    images: list[Image]
    outputs: list[Output]
    period: float  # s from one evaluation to the next
    robots: list[str]  # that share it, in the order of the policy's agents; else empty
    columns: list[list[str]]  # of each of these robots: its columns in the order of `signals`

    @property
    def ranges_differ(self) -> bool:
        """Whether robots that share the policy have different ranges of actions."""
        return any(len(output.low) > 1 for output in self.outputs)

    @property
    def inputs(self) -> list[Signal]:
        """Signals that the caller gives."""
        return [signal for signal in self.signals if signal.actions is None]

    @property
    def past_actions(self) -> list[Signal]:
        """Signals that are past actions, kept in the state."""
        return [signal for signal in self.signals if signal.actions is not None]


def identifier(text: str) -> str:
    """A C identifier made of a name."""
    name = re.sub(r"\W", "_", text, flags=re.ASCII)
    return f"{name}_" if name in KEYWORDS else f"_{name}" if name[:1].isdigit() else name


def unique(names: Iterable[str], taken: Iterable[str] = ()) -> list[str]:
    """The names; a repeated one gets a number."""
    result: list[str] = []
    for name in names:
        number, free = 2, name
        while free in result or free in taken:
            free, number = f"{name}_{number}", number + 1
        result.append(free)
    return result


def interface_of(policy: Policy, compiled: CompiledScenario) -> Interface:
    """The interface of a policy in a scenario that it fits.

    Raises:
        InputError: inputs of a shared policy are parts of columns.
    """
    agents = policy.agents
    first = agents[0] if agents else None
    columns = [column for column in compiled.observation_columns if not column.privileged]
    rows = [column for column in columns if column.image < 0]
    places = first.observation.tolist() if first else list(range(compiled.observation_size))
    outputs_of = [agent.action.tolist() for agent in agents] or [list(range(compiled.action_size))]
    entries = outputs_of[0]
    seen = _columns_at(places, rows)
    robot = compiled.robots[seen[0].robot] + "." if first else ""
    names = unique(identifier(column.name.removeprefix(robot)) for column in seen)
    signals, place = [], 0
    for name, column in zip(names, seen, strict=True):
        actions = _past_actions(compiled, column, entries)
        signals.append(_signal(name, column, place, actions))
        place += column.shape[0]
    return Interface(
        signals,
        _images(policy, columns, names),
        _outputs(compiled, outputs_of),
        compiled.dt * compiled.action_repeat,
        *_sharing(agents, rows, compiled.robots),
    )


def _columns_at(
    places: Sequence[int], rows: Sequence[ObservationColumn]
) -> list[ObservationColumn]:
    """The columns whose values are at these places of the row, in order."""
    starts = {column.first: column for column in rows}
    found, at = [], 0
    while at < len(places):
        column = starts.get(places[at])
        end = at + (column.shape[0] if column else 1)
        if column is None or list(places[at:end]) != list(range(places[at], places[at] + end - at)):
            raise InputError(
                f"entry {places[at]} of the observation is not the beginning of a whole column: "
                "policies whose inputs are parts of columns cannot be exported"
            )
        found.append(column)
        at = end
    return found


def _outputs(compiled: CompiledScenario, rows: Sequence[Sequence[int]]) -> list[Output]:
    """The outputs of the first robot's entries, with the ranges of all robots."""
    first = {c.robot for c in compiled.action_channels if c.first in rows[0]}
    values: dict[int, Value] = {}
    low, high = np.zeros(compiled.action_size), np.zeros(compiled.action_size)
    for channel in compiled.action_channels:
        prefix = f"{compiled.robots[channel.robot]}_" if len(first) > 1 else ""
        own = slice(channel.first, channel.first + channel.count)
        low[own], high[own] = channel.low, channel.high
        for k, value in enumerate(values_of(compiled, channel)):
            values[channel.first + k] = replace(value, name=identifier(prefix + value.name))
    lows, highs = low[np.asarray(rows)], high[np.asarray(rows)]
    if (lows == lows[0]).all() and (highs == highs[0]).all():
        lows, highs = lows[:1], highs[:1]
    names = unique(values[entry].name for entry in rows[0])
    return [
        Output(name, values[entry].unit, values[entry].meaning, list(lows[:, k]), list(highs[:, k]))
        for k, (name, entry) in enumerate(zip(names, rows[0], strict=True))
    ]


def _past_actions(
    compiled: CompiledScenario, column: ObservationColumn, entries: Sequence[int]
) -> range | None:
    """The outputs whose past values a column has; None: it has other values."""
    if column.source != "task" or not PAST_ACTIONS.match(column.doc):
        return None
    own = [c for c in compiled.action_channels if c.robot == column.robot and c.count > 0]
    size = sum(channel.count for channel in own)
    if not own or column.shape[0] % size or own[0].first not in entries:
        return None
    begin = entries.index(own[0].first)
    return range(begin, begin + size)


def _signal(name: str, column: ObservationColumn, first: int, actions: range | None) -> Signal:
    return Signal(
        name, column.name, column.unit, column.doc, column.low, column.high, first,
        column.shape[0], actions,
    )  # fmt: skip


def _images(
    policy: Policy, columns: Sequence[ObservationColumn], taken: Sequence[str]
) -> list[Image]:
    found = {column.name: column for column in columns if column.image >= 0}
    names = unique((identifier(image.column) for image in policy.images), taken)
    images = []
    for name, image in zip(names, policy.images, strict=True):
        column = found[image.column]
        images.append(
            Image(
                name, image.column, image.shape, column.dtype, column.unit, column.doc,
                image.low, image.high,
            )
        )  # fmt: skip
    return images


def _sharing(
    agents: Sequence[Agent], rows: Sequence[ObservationColumn], robots: Sequence[str]
) -> tuple[list[str], list[list[str]]]:
    """The robots that share a policy, and the columns of each."""
    columns = [_columns_at(agent.observation.tolist(), rows) for agent in agents]
    names = [robots[seen[0].robot] for seen in columns]
    return names, [[column.name for column in seen] for seen in columns]
