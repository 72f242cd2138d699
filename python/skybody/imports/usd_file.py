"""Logs of the Crazyflie's micro-SD deck; also `.usd.gz`.

A file is the byte 0xBC, a version, and for each type of event a number, a name and its variables;
then events: a number, a time in microseconds, the variables packed; at the end a CRC.
"""

from __future__ import annotations

import gzip
import re
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skybody import InputError
from skybody.look.flight import Array

from .channels import Channels
from .map_file import Map

MAGIC = 0xBC
VERSIONS = (1, 2)
CRC_BYTES = 4
PERIODIC = "fixedFrequency"  # the event of variables that are logged at a rate
TYPES = {  # of NumPy, by the letters of Python's struct
    "f": "<f4", "d": "<f8", "b": "<i1", "h": "<i2", "i": "<i4", "q": "<i8",
    "B": "<u1", "H": "<u2", "I": "<u4", "L": "<u4", "Q": "<u8",
}  # fmt: skip
MICRO = 1e-6


@dataclass(frozen=True)
class Event:
    """A type of event."""

    name: str
    type: np.dtype[np.void]  # with the number and the time

    def column(self, variable: str) -> str:
        """Name of a column."""
        return variable if self.name == PERIODIC else f"{self.name}.{variable}"


def read(path: Path, used: Map) -> Channels:
    """Reads the variables of all events.

    Raises:
        InputError: the file is no such log, of another version, or damaged.
    """
    if used.time is not None:
        raise InputError(f"{used.file}: time: is not for this log, which has own times")
    data = bytes_of(path)
    events, first = definitions(path, data)
    columns: dict[str, Array] = {}
    times: dict[str, Array] = {}
    notes: list[str] = []
    rows_of_all = records(path, data, events, first, notes)
    for event, rows in zip(events.values(), rows_of_all, strict=True):
        found = np.frombuffer(rows, event.type)
        seconds = found["time"] * MICRO
        for variable in event.type.names[2:] if event.type.names else ():
            columns[event.column(variable)] = found[variable].astype(np.float64)
            times[event.column(variable)] = seconds
    return Channels(path, columns, times, notes=notes)


def bytes_of(path: Path) -> bytes:
    """The content of the file."""
    try:
        data = path.read_bytes()
        return gzip.decompress(data) if path.suffix == ".gz" else data
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path}: cannot be read ({error})") from None


def definitions(path: Path, data: bytes) -> tuple[dict[int, Event], int]:
    """The types of events by their numbers, and the place of the first event."""
    try:
        magic, version, count = struct.unpack_from("<BHH", data)
    except struct.error:
        magic = version = count = 0
    if magic != MAGIC:
        raise InputError(f"{path}: is no log of the Crazyflie's micro-SD deck")
    if version not in VERSIONS:
        words = " and ".join(map(str, VERSIONS))
        raise InputError(f"{path}: is of version {version}; allowed: {words}")
    place, events = 5, {}
    try:
        for _ in range(count):
            (number,) = struct.unpack_from("<H", data, place)
            name, place = text_at(data, place + 2)
            (variables,) = struct.unpack_from("<H", data, place)
            place += 2
            fields: list[tuple[str, str]] = [("number", "<u2"), ("time", "<u8")]
            for _ in range(variables):
                word, place = text_at(data, place)
                found = re.fullmatch(rf"(.+)\(([{''.join(TYPES)}])\)", word)
                if found is None:
                    raise ValueError(f"variable `{word}` has no known type")
                fields.append((found[1], TYPES[found[2]]))
            events[number] = Event(name, np.dtype(fields))
    except (struct.error, ValueError) as error:
        raise InputError(f"{path}: is cut short or damaged in its head ({error})") from None
    return events, place


def text_at(data: bytes, place: int) -> tuple[str, int]:
    """A text that ends with a zero, and the place behind it."""
    end = data.index(0, place)
    return data[place:end].decode("ascii", "replace"), end + 1


def records(
    path: Path, data: bytes, events: dict[int, Event], place: int, notes: list[str]
) -> list[bytearray]:
    """The events of each type; those before an end that is cut off, with a note."""
    whole = zlib.crc32(data[:-CRC_BYTES]) == int.from_bytes(data[-CRC_BYTES:], "little")
    end = len(data) - CRC_BYTES if whole else len(data)
    found = {number: bytearray() for number in events}
    while place + 2 <= end:
        number = int.from_bytes(data[place : place + 2], "little")
        if number not in events:
            raise InputError(f"{path}: is damaged at byte {place}: no event has number {number}")
        size = events[number].type.itemsize
        if place + size > end:
            break
        found[number] += data[place : place + size]
        place += size
    if not whole:
        rows = sum(len(rows) // events[n].type.itemsize for n, rows in found.items())
        notes.append(f"{path}: is cut short: its CRC is missing or wrong; {rows} events are used")
    return list(found.values())
