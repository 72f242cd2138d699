"""The columns of a log of another program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from skybody import InputError
from skybody.arguments import allowed_words
from skybody.exports.frames import finite
from skybody.look.flight import Array

from .map_file import Columns

MOST_NAMED = 60  # columns in a message


@dataclass(frozen=True)
class Samples:
    """Values at times that increase."""

    time: Array  # [s]
    values: Array  # (samples, columns)


@dataclass
class Channels:
    """All columns of a log, each with its times."""

    path: Path
    columns: Mapping[str, Array]  # by name, (samples,)
    times: Mapping[str, Array]  # of each column [s]
    # For messages: the place of a sample, such as `line 7`.
    place_of: str = "sample {}"
    first_place: int = 1
    kinds: Mapping[str, str] = field(default_factory=dict)  # of MCAP: schemas by topic
    notes: list[str] = field(default_factory=list)  # remarks for the user
    # Of columns that are no numbers: the first cell that is none, with its place.
    words: Mapping[str, str] = field(default_factory=dict)

    def has(self, columns: Columns) -> bool:
        """Whether all of some columns are there."""
        return all(name in self.columns for name in columns.names)

    def samples(self, columns: Columns, *, bridge: bool, may_be_nan: bool = False) -> Samples:
        """Columns that were sampled together.

        Args:
            columns: of a quantity; their factor is not applied.
            bridge: samples with NaN are left out.
            may_be_nan: NaN has a meaning.

        Raises:
            InputError: a column is missing, has other times than the rest, times that go back, or
                NaN.
        """
        for name in columns.names:
            if name not in self.columns:
                raise self._missing(columns, name)
        time = self.times[columns.names[0]]
        if any(not np.array_equal(self.times[name], time) for name in columns.names):
            raise InputError(
                f"{self.path}: {columns.place}: {', '.join(columns.names)} have different times"
            )
        values = np.stack([self.columns[name] for name in columns.names], axis=1)
        self._check_times(columns, time)
        known = finite(values) | may_be_nan
        if not known.all() and not bridge:
            row = int(np.argmin(known))
            name = columns.names[int(np.argmin(np.isfinite(values[row])))]
            raise InputError(
                f"{self.path}: {self._place(row)}: `{name}` is {values[row].min():g}, and "
                f"{np.count_nonzero(~known)} of {len(known)} samples are not finite; remove them, "
                "or write `gaps: interpolate` in the map"
            )
        known[1:] &= np.diff(time) > 0.0  # of equal times the first one counts
        if not known.any():
            raise InputError(f"{self.path}: {columns.place}: {columns.names[0]} has no samples")
        return Samples(time[known], values[known])

    def _check_times(self, columns: Columns, time: Array) -> None:
        if not np.isfinite(time).all():
            row = int(np.argmin(np.isfinite(time)))
            raise InputError(f"{self.path}: {self._place(row)}: the time is not finite")
        steps = np.diff(time)
        if (steps < 0.0).any():
            row = int(np.argmax(steps < 0.0)) + 1
            raise InputError(
                f"{self.path}: {self._place(row)}: the time of {columns.names[0]} goes back from "
                f"{time[row - 1]:.15g} to {time[row]:.15g} s; sort the log, or cut it there"
            )

    def _place(self, row: int) -> str:
        return self.place_of.format(row + self.first_place)

    def _missing(self, columns: Columns, name: str) -> InputError:
        if name in self.words:
            return InputError(
                f"{self.path}: {self.words[name]} is no number, in `{name}` for {columns.place}; "
                "correct it, or leave the cell empty"
            )
        names = sorted(self.columns)
        more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
        hint = allowed_words(name, names).partition(" Allowed")[0]
        return InputError(
            f"{self.path}: no column `{name}` for {columns.place}{hint} There are: "
            f"{', '.join(names[:MOST_NAMED])}{more}"
        )
