"""The messages of a flight in the order of their times."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from .table import Block, Table

# A channel, and its messages of the rows of a block; None for rows without one.
Stream = tuple[Any, Callable[[Block], Iterator[Any]]]
Timed = tuple[float, Any, Any]  # time [s], channel, message


def in_order(
    table: Table, streams: Sequence[Stream], between: Iterable[Iterator[Timed]] = ()
) -> Iterator[Timed]:
    """All messages; those of a row in the order of the streams.

    Args:
        table: the rows.
        streams: the messages of rows.
        between: messages at other times, each in order; made when they are due.
    """
    return heapq.merge(*between, _of_rows(table, streams), key=lambda timed: timed[0])


def _of_rows(table: Table, streams: Sequence[Stream]) -> Iterator[Timed]:
    for block in table.blocks():
        rows = [messages(block) for _, messages in streams]
        for time, *messages in zip(block.time.tolist(), *rows, strict=True):
            for (channel, _), message in zip(streams, messages, strict=True):
                if message is not None:
                    yield time, channel, message


def events(table: Table) -> Iterator[tuple[float, str]]:
    """Times [s] and texts of the events within the table."""
    first, last = table.ends
    return ((time, text) for time, text in table.flight.events if first <= time <= last)
