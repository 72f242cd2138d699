"""ULog, the log of PX4: pose, velocity and rotor speeds of each robot, in NED and FRD.

A file of the format at <https://docs.px4.io/main/en/dev_log/ulog_file_format>: a header,
definitions of the topics, then messages.
"""

from __future__ import annotations

import argparse
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skybody import InputError

from .about import about
from .order import events
from .table import Block, Table
from .ulog_topics import MICRO, Topic, topics_of

MAGIC = bytes([0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35, 0x01])  # "ULog", 01 12 35, version 1
NO_FLAGS = bytes(40)
MOST_INSTANCES = 255  # of a topic
INFORMATION = ord("6")  # level of a logged text
TYPES = {"uint64_t": "<u8", "uint32_t": "<u4", "float": "<f4", "bool": "?"}


def write(table: Table, path: Path, options: argparse.Namespace) -> None:
    """Writes the topics; docs/exports.md has their fields.

    Raises:
        InputError: there are no bodies, or too many robots.
    """
    if not table.robots:
        raise InputError(f"{table.flight.path}: has no bodies; PX4's topics are of a vehicle")
    if len(table.robots) > MOST_INSTANCES:
        raise InputError(f"{len(table.robots)} robots; allowed in a ULog: {MOST_INSTANCES}")
    topics = topics_of(table)
    with path.open("wb") as file:
        file.write(MAGIC + struct.pack("<Q", round(table.ends[0] * MICRO)))
        for kind, content in definitions(table, topics):
            file.write(struct.pack("<H", len(content)) + kind + content)
        for block in table.blocks():
            file.write(rows_of(topics, block).tobytes())


def definitions(table: Table, topics: list[Topic]) -> Iterator[tuple[bytes, bytes]]:
    """Types and contents of the messages before the rows."""
    yield b"B", NO_FLAGS
    for key, text in about(table).items():
        name = f"char[{len(text.encode())}] {key}".encode()
        yield b"I", bytes([len(name)]) + name + text.encode()
    for definition in dict.fromkeys(topic.definition for topic in topics):
        yield b"F", definition.encode()
    for number, topic in enumerate(topics):
        yield b"A", struct.pack("<BH", topic.instance, number) + topic.name.encode()
    for time, text in events(table):
        yield b"L", struct.pack("<BQ", INFORMATION, round(time * MICRO)) + text.encode()


def rows_of(topics: list[Topic], block: Block) -> NDArray[np.void]:
    """The messages of a block: a row has one of each topic."""
    layouts = [layout_of(topic, number) for number, topic in enumerate(topics)]
    rows = np.zeros(len(block.time), [item for layout in layouts for item in layout.descr])
    for number, (topic, layout) in enumerate(zip(topics, layouts, strict=True)):
        rows[f"{number}.size"] = layout.itemsize - 3  # without itself and the type
        rows[f"{number}.type"] = ord("D")
        rows[f"{number}.id"] = number
        rows[f"{number}.timestamp"] = block.stamps(MICRO)
        for name, values in topic.values(block).items():
            rows[f"{number}.{name}"] = values
    return rows


def layout_of(topic: Topic, number: int) -> np.dtype[np.void]:
    """A message of a topic under the number of its subscription."""
    head = [("size", "<u2"), ("type", "u1"), ("id", "<u2"), ("timestamp", "<u8")]
    fields = [(name, TYPES[kind], (n,) if n > 1 else ()) for kind, name, n in topic.fields]
    return np.dtype(
        [(f"{number}.{name}", kind) for name, kind in head]
        + [(f"{number}.{name}", kind, shape) for name, kind, shape in fields]
    )
