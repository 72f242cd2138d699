"""The rows of a flight in blocks: their number does not matter for the memory that is needed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import h5py
import numpy as np
from numpy.typing import NDArray

from skybody import InputError
from skybody.look.flight import Array, Flight, texts

MOST_ROWS = 1024  # that are read at a time: the greatest number in a chunk of the log
MOST_VALUES = 1 << 19  # that are read at a time
ITEMS = ("bodies", "goal")  # datasets with a middle index
NANO = 10**9  # nanoseconds in a second
POSE = slice(0, 7)  # of the 13 values of a body: position, quaternion w x y z


@dataclass(frozen=True)
class Series:
    """A dataset of an episode, with a row for each time."""

    name: str
    columns: tuple[str, ...]  # distinct; none: one value a row
    units: tuple[str, ...]  # of the columns
    items: tuple[str, ...]  # middle index, distinct: bodies or goals; none: no such index
    type: np.dtype[np.generic]

    @cached_property
    def paths(self) -> list[str]:
        """Name of each value of a row: DATASET/COLUMN, DATASET/ITEM.COLUMN, or DATASET."""
        if not self.columns:
            return [self.name]
        heads = [f"{item}." for item in self.items] or [""]
        return [f"{self.name}/{head}{column}" for head in heads for column in self.columns]

    @cached_property
    def unit_of_each(self) -> list[str]:
        """Unit of each value of a row, as `paths`."""
        return list(self.units) * max(len(self.items), 1) or [""]


@dataclass(frozen=True)
class Block:
    """Some rows that follow one another."""

    time: Array  # since the reset [s], (rows,)
    values: dict[str, NDArray[np.generic]]  # by dataset, each (rows, ...)

    def stamps(self, per_second: int) -> NDArray[np.int64]:
        """Times in whole parts of a second, rounded, such as 10**9 for nanoseconds."""
        return np.round(self.time * per_second).astype(np.int64)

    def real(self, name: str) -> Array:
        """The values of a dataset as float64."""
        return np.asarray(self.values[name], dtype=np.float64)


@dataclass(frozen=True)
class Span:
    """The rows that are exported."""

    first: float = 0.0  # [s]
    last: float = np.inf  # [s]
    every: int = 1  # each n-th row


class Table:
    """The datasets of an episode that have a row for each time."""

    def __init__(self, flight: Flight, span: Span = Span(), only: Sequence[str] = ()) -> None:
        """Reads the descriptions of the datasets.

        Args:
            flight: the episode.
            span: its rows that count.
            only: names of datasets; none: all.

        Raises:
            InputError: there are no rows, no such datasets, or datasets of different lengths.
        """
        self.flight = flight
        self._rows = _rows_of(flight, span)
        found = {name: _series_of(name, data) for name, data in _datasets(flight)}
        for name in only:
            if name not in found:
                raise InputError(f"no dataset `{name}`; there are: {', '.join(found)}")
        self.series = {name: s for name, s in found.items() if not only or name in only}

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self._rows)

    @property
    def ends(self) -> tuple[float, float]:
        """Times of the first and the last row [s]."""
        return float(self.flight.time[self._rows[0]]), float(self.flight.time[self._rows[-1]])

    @cached_property
    def robots(self) -> dict[str, list[int]]:
        """Indices of each robot's bodies by its name, the base first."""
        found: dict[str, list[int]] = {}
        if "bodies" in self.series:
            for k, name in enumerate(self.series["bodies"].items):
                found.setdefault(name.partition(".")[0], []).append(k)
        return found

    def blocks(self, *names: str) -> Iterator[Block]:
        """The rows in order.

        Args:
            names: datasets to read; none: all.
        """
        chosen = [name for name in names or self.series if name in self.series]
        width = sum(len(self.series[name].paths) for name in chosen)
        block = min(max(MOST_VALUES // max(width, 1), 1), MOST_ROWS)
        for begin in range(0, len(self._rows), block):
            rows = self._rows[begin : begin + block]
            window = slice(rows.start, rows[-1] + 1, rows.step)
            values = {name: self.flight.data[name][window] for name in chosen}
            yield Block(self.flight.time[window], values)


def _rows_of(flight: Flight, span: Span) -> range:
    time = flight.time
    if len(time) == 0:
        raise InputError(f"{flight.path}: episode {flight.episode} has no rows")
    if not (np.isfinite(time).all() and (np.diff(time) > 0.0).all()):
        raise InputError(f"{flight.path}: its times do not increase from row to row")
    first, last = np.searchsorted(time, [span.first, np.nextafter(span.last, np.inf)])
    if first == last:
        raise InputError(
            f"no rows from {span.first:g} to {span.last:g} s; the flight has {time[0]:g} to "
            f"{time[-1]:g} s"
        )
    return range(int(first), int(last), span.every)


def _datasets(flight: Flight) -> Iterator[tuple[str, h5py.Dataset]]:
    """Datasets with a row for each time, poses first. Raises InputError for a cut log."""
    names = [n for n in flight.data if n not in ("time", "params", "events")]
    for name in sorted(names, key=lambda n: (n not in ITEMS, n)):
        rows = len(flight.data[name])
        if rows != len(flight.time):
            raise InputError(
                f"{flight.path}: is cut short: `{name}` has {rows} rows, `time` has "
                f"{len(flight.time)}"
            )
        yield name, flight.data[name]


def _series_of(name: str, data: h5py.Dataset) -> Series:
    def attribute(key: str) -> tuple[str, ...]:
        return tuple(texts(data.attrs[key])) if key in data.attrs else ()

    columns, items = distinct(attribute("columns")), distinct(attribute("items"))
    return Series(name, columns, attribute("units"), items, data.dtype)


def distinct(names: Sequence[str]) -> tuple[str, ...]:
    """The names, with `_2`, `_3` ... after those that have occurred before, ahead of any `[k]`."""
    count: dict[str, int] = {}
    found = []
    for name in names:
        count[name] = count.get(name, 0) + 1
        base, bracket, rest = name.partition("[")
        found.append(name if count[name] == 1 else f"{base}_{count[name]}{bracket}{rest}")
    return tuple(found)
