"""The values of a dataset as messages of Protocol Buffers, with names as in the log."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

from skybody.look.flight import Array

from .table import Series

Field = descriptor_pb2.FieldDescriptorProto
PACKAGE = "skybody"
DOUBLE = struct.Struct("<d")


class Values:
    """Messages with a field for each value of a row.

    Dots of a name become nested messages, `NAME[0]`, `NAME[1]` ... one repeated field: column
    `failed.tilt` is field `tilt` of field `failed`.
    """

    def __init__(self, series: Series) -> None:
        """Makes the message type `skybody.DATASET` of a dataset."""
        self.name = f"{PACKAGE}.{series.name}"
        file = descriptor_pb2.FileDescriptorProto(
            name=f"{PACKAGE}/{series.name}.proto", package=PACKAGE, syntax="proto3"
        )
        root = file.message_type.add(name=series.name)
        prefix = f"{series.name}/" if series.columns else ""
        self._groups = [
            (_add(root, name), indices)
            for name, indices in _grouped([p.removeprefix(prefix) for p in series.paths]).items()
        ]
        self.schema = descriptor_pb2.FileDescriptorSet(file=[file]).SerializeToString()
        pool = descriptor_pool.DescriptorPool()
        pool.Add(file)
        self._type = message_factory.GetMessageClass(pool.FindMessageTypeByName(self.name))
        # All messages have the same bytes but for the numbers: found by a message of marks.
        marks = 1.0 + np.arange(1, len(series.paths) + 1) * 2.0**-40
        template = self._message(marks.tolist())
        self._template = np.frombuffer(template, np.uint8)
        first = np.array([template.index(mark) for mark in map(DOUBLE.pack, marks)], np.intp)
        self._places = (first[:, None] + np.arange(DOUBLE.size)).ravel()

    def encode(self, rows: Array) -> Iterator[bytes]:
        """The messages of some rows of values, (rows, values)."""
        messages = np.tile(self._template, (len(rows), 1))
        messages[:, self._places] = np.ascontiguousarray(rows, "<f8").view(np.uint8)
        return map(bytes, messages)

    def decode(self, messages: Sequence[bytes]) -> Array:
        """The rows of values of messages of encode()."""
        found = np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), -1)
        return np.ascontiguousarray(found[:, self._places]).view("<f8")

    def _message(self, row: Sequence[float]) -> bytes:
        message = self._type()
        for (path, field, repeated), indices in self._groups:
            part: Any = message
            for name in path:
                part = getattr(part, name)
            if repeated:
                getattr(part, field).extend([row[k] for k in indices])
            else:
                setattr(part, field, row[indices[0]])
        return bytes(message.SerializeToString())


def _grouped(names: Sequence[str]) -> dict[str, list[int]]:
    """Places of the values of each field: `x[0]`, `x[1]` are one field, `x[]`."""
    found: dict[str, list[int]] = {}
    for k, name in enumerate(names):
        found.setdefault(re.sub(r"\[\d+\]$", "[]", name), []).append(k)
    return found


def _add(root: Any, name: str) -> tuple[list[str], str, bool]:
    """Adds a field, and messages on its way; gives these, its name and whether it is repeated."""
    repeated = name.endswith("[]")
    words = [_word(word) for word in name.removesuffix("[]").split(".")]
    part, path = root, []
    for word in words[:-1]:
        while any(f.name == word and f.type != Field.TYPE_MESSAGE for f in part.field):
            word += "_"
        nested = f"{word}_values"
        if not any(f.name == word for f in part.field):
            part.nested_type.add(name=nested)
            part.field.add(
                name=word, number=len(part.field) + 1, label=Field.LABEL_OPTIONAL,
                type=Field.TYPE_MESSAGE, type_name=nested,
            )  # fmt: skip
        part = next(m for m in part.nested_type if m.name == nested)
        path.append(word)
    leaf = words[-1]
    while any(f.name == leaf for f in part.field):
        leaf += "_"
    label = Field.LABEL_REPEATED if repeated else Field.LABEL_OPTIONAL
    part.field.add(name=leaf, number=len(part.field) + 1, label=label, type=Field.TYPE_DOUBLE)
    return path, leaf, repeated


def _word(text: str) -> str:
    """A name of a field."""
    clean = re.sub(r"\W", "_", text, flags=re.ASCII) or "_"
    return f"_{clean}" if clean[0].isdigit() else clean
