"""CSV: a row of names, then rows of numbers; also `.csv.gz`."""

from __future__ import annotations

import csv
import gzip
import io
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from skybody import InputError
from skybody.look.flight import Array

from .channels import Channels
from .map_file import Map


def read(path: Path, used: Map) -> Channels:
    """Reads the columns of numbers; others are left out.

    Raises:
        InputError: the map names no time, there are no rows, or a row has another length.
    """
    if used.time is None:
        raise InputError(f"{used.file}: time: is missing: a CSV has no times but in a column")
    with opened(path) as file:
        rows = csv.reader(file)
        names = [name.strip() for name in next(rows, [])]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise InputError(f"{path}: line 1: columns occur twice: {', '.join(twice)}")
        notes: list[str] = []
        data = list(complete(path, rows, len(names), notes))
    if not data:
        raise InputError(f"{path}: has no rows of numbers below its names")
    columns: dict[str, Array] = {}
    words: dict[str, str] = {}
    for k, name in enumerate(names):
        cells = [row[k] for row in data]
        if (numbers := numbers_of(cells)) is not None:
            columns[name] = numbers
        else:
            words[name] = first_word(cells, k + 1)
    time = used.time.names[0]
    channels = Channels(path, columns, dict.fromkeys(columns, np.zeros(0)), "line {}", 2, {}, notes)
    channels.words = words
    if time not in columns:
        channels.samples(used.time, bridge=False)  # says that it is missing
    seconds = used.time.factor * columns[time]
    channels.times = dict.fromkeys(columns, seconds)
    return channels


@contextmanager
def opened(path: Path) -> Iterator[io.TextIOBase]:
    """The text of a file. Raises InputError if it cannot be read."""
    try:
        with (
            path.open("rb") as file,
            (
                gzip.open(file, "rt", encoding="utf-8-sig", newline="")
                if path.suffix == ".gz"
                else io.TextIOWrapper(file, encoding="utf-8-sig", newline="")
            ) as text,
        ):
            yield text
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except EOFError:
        raise InputError(f"{path}: is cut short: its compressed data has no end") from None
    except zlib.error as error:
        raise InputError(f"{path}: its compressed data is damaged ({error})") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: is no text in UTF-8") from None
    except csv.Error as error:
        raise InputError(f"{path}: is no CSV: {error}") from None


def complete(
    path: Path, rows: Iterator[list[str]], width: int, notes: list[str]
) -> Iterator[list[str]]:
    """The rows of the right length; a last row that is cut short is left out, with a note."""
    short = 0
    for line, row in enumerate(rows, start=2):
        if short:
            raise InputError(f"{path}: line {short}: has another number of cells than the names")
        if len(row) == width:
            yield row
        elif row:
            short = line
    if short:
        notes.append(f"{path}: line {short} is cut short and left out")


def numbers_of(cells: list[str]) -> Array | None:
    """A column; empty cells are NaN. None: it is no column of numbers."""
    try:
        return np.array([float(cell) if cell.strip() else np.nan for cell in cells])
    except ValueError:
        return None


def first_word(cells: list[str], column: int) -> str:
    """The place of a cell that is no number, and its text: a column of `numbers_of` None."""
    row = next(k for k, cell in enumerate(cells) if numbers_of([cell]) is None)
    return f"line {row + 2}, cell {column}: `{cells[row]}`"
