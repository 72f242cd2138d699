"""The TensorBoard event file of a run, written without TensorBoard.

A file is a sequence of records: length (8 bytes, little-endian), its checksum, the bytes of an
`Event`, their checksum (TensorFlow, `lib/io/record_writer.h`). The checksum is CRC-32C (RFC 3720,
appendix B.4), masked: rotated right by 15 bits, plus 0xa282ead8. `Event` is a Protocol Buffers
message (`tensorflow/core/util/event.proto`); a field is its number times 8 plus its wire type, then
its value. Importing TensorBoard would take longer than some trainings.
"""

from __future__ import annotations

import contextlib
import os
import socket
import struct
import time
from collections.abc import Mapping
from pathlib import Path

from skybody.train import files

VARINT, DOUBLE, BYTES, FLOAT = 0, 1, 2, 5  # wire types
WALL_TIME, STEP, FILE_VERSION, SUMMARY, SESSION_LOG = 1, 2, 3, 5, 7  # fields of Event
VALUE = 1  # of Summary
TAG, SIMPLE_VALUE = 1, 2  # of Summary.Value
STATUS, START = 1, 1  # of SessionLog, and its value: events beyond this step are dropped
VERSION = "brain.Event:2"  # of the format
POLYNOMIAL = 0x82F63B78  # of CRC-32C, its bits reversed


class EventFile:
    """Curves by name."""

    def __init__(self, run: Path, first_step: int) -> None:
        """Begins a new file in `run`; curves of earlier files end before `first_step`.

        Raises OSError, which names the run's folder.
        """
        self._run = run
        began, number = int(time.time()), time.perf_counter_ns()
        name = f"events.out.tfevents.{began:010d}.{socket.gethostname()}.{os.getpid()}.{number}"
        with files.naming(run):
            self._file = (run / name).open("xb")
        self._write(_field(FILE_VERSION, BYTES) + _counted(VERSION.encode()))
        status = _field(STATUS, VARINT) + _varint(START)
        self._write(_at(first_step) + _field(SESSION_LOG, BYTES) + _counted(status))

    def add(self, values: Mapping[str, float], step: int) -> None:
        """Adds a point to each curve. Raises OSError, which names the run's folder."""
        summary = b"".join(_value(name, value) for name, value in values.items())
        self._write(_at(step) + _field(SUMMARY, BYTES) + _counted(summary))

    def _write(self, event: bytes) -> None:
        content = _field(WALL_TIME, DOUBLE) + struct.pack("<d", time.time()) + event
        length = struct.pack("<Q", len(content))
        record = length + _checksum(length) + content + _checksum(content)
        with files.naming(self._run):
            self._file.write(record)
            self._file.flush()

    def close(self) -> None:
        """Closes the file; added values are already written."""
        with contextlib.suppress(OSError):
            self._file.close()


def _at(step: int) -> bytes:
    return _field(STEP, VARINT) + _varint(step)


def _value(name: str, value: float) -> bytes:
    tag = _field(TAG, BYTES) + _counted(name.encode())
    return _field(VALUE, BYTES) + _counted(
        tag + _field(SIMPLE_VALUE, FLOAT) + struct.pack("<f", value)
    )


def _field(number: int, wire_type: int) -> bytes:
    return _varint(number << 3 | wire_type)


def _counted(content: bytes) -> bytes:
    return _varint(len(content)) + content


def _varint(value: int) -> bytes:
    """Varint: seven bits per byte, lowest first; the eighth bit is set in all but the last."""
    content = bytearray()
    while value > 0x7F:
        content.append(value & 0x7F | 0x80)
        value >>= 7
    content.append(value)
    return bytes(content)


def _checksum(content: bytes) -> bytes:
    crc = 0xFFFFFFFF
    for byte in content:
        crc = _TABLE[(crc ^ byte) & 0xFF] ^ crc >> 8
    crc ^= 0xFFFFFFFF
    masked = ((crc >> 15 | crc << 17) + 0xA282EAD8) & 0xFFFFFFFF
    return struct.pack("<I", masked)


def _table_entry(byte: int) -> int:
    for _ in range(8):
        byte = byte >> 1 ^ (POLYNOMIAL if byte & 1 else 0)
    return byte


_TABLE = tuple(map(_table_entry, range(256)))
