"""MCAP: messages of Foxglove and of ROS 2, and the files of `skybody export`."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf.message import Message
from mcap.reader import McapReader, make_reader
from mcap.records import Schema
from mcap_protobuf.decoder import DecoderFactory
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from skybody import InputError
from skybody.look.flight import Array

from .channels import Channels
from .map_file import Map
from .own_mcap import restored

NANO = 1e-9
MOST_LETTERS = 200  # of another package's message
MOST_ARRAY = 64  # numbers of an array that become columns: images and clouds have more


@contextmanager
def opened(path: Path, **settings: Any) -> Iterator[McapReader]:
    """A reader of a file. Raises InputError if the file cannot be read, there or later."""
    try:
        with path.open("rb") as file:
            yield make_reader(file, **settings)
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except Exception as error:  # of mcap, its codecs and the decoders, for damaged bytes
        problem = " ".join(str(error).split())[:MOST_LETTERS]
        raise InputError(
            f"{path}: cannot be read as MCAP ({type(error).__name__}: {problem}); it may be "
            "damaged or cut short"
        ) from None


def restore(path: Path) -> Any:
    """The flight log that a file of `skybody export` was made from; None: it is another's."""
    with opened(path) as reader:
        return restored(path, reader)


def read(path: Path, used: Map) -> Channels:
    """Reads the numbers of all messages: columns are TOPIC.FIELD.FIELD, or TOPIC.FIELD[0].

    Fields of transforms are named by their frame: `/tf.transforms[base_link].translation.x`.

    Raises:
        InputError: the file is no MCAP, or cut short.
    """
    if used.time is not None:
        raise InputError(f"{used.file}: time: is not for this log, which has own times")
    rows: dict[str, list[tuple[float, dict[str, float]]]] = {}
    kinds: dict[str, str] = {}
    with opened(path, decoder_factories=[DecoderFactory()]) as reader:
        decoders: dict[int, Any] = {}
        for schema, channel, message in reader.iter_messages():
            if channel.id not in decoders:
                decoders[channel.id] = decoder_of(schema, channel.message_encoding)
                kinds[channel.topic] = schema.name if schema else ""
            if (decode := decoders[channel.id]) is not None:
                made = decode(message.data)
                time = stamp_of(made)
                seconds = message.log_time * NANO if time is None else time
                numbers = dict(numbers_of(made, channel.topic))
                rows.setdefault(channel.topic, []).append((seconds, numbers))
    columns: dict[str, Array] = {}
    times: dict[str, Array] = {}
    for topic in rows.values():
        add_columns(topic, columns, times)
    if not columns:
        raise InputError(f"{path}: has no messages with numbers, by Protocol Buffers or CDR")
    return Channels(path, columns, times, kinds=kinds)


def decoder_of(schema: Schema | None, encoding: str) -> Any:
    """A function from the bytes of a message to the message; None: it cannot be decoded."""
    if schema is None:
        return None
    if encoding == "protobuf":
        return DecoderFactory().decoder_for(encoding, schema)
    if encoding == "cdr" and schema.encoding == "ros2msg":
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(schema.data.decode(), schema.name))
        return lambda data: store.deserialize_cdr(data, schema.name)
    return None


def stamp_of(message: Any) -> float | None:
    """The time in a message [s]; None: it has none."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    if stamp is not None:
        return float(stamp.sec + stamp.nanosec * NANO)
    stamp = getattr(message, "timestamp", None)
    if stamp is not None and hasattr(stamp, "nanos"):
        return float(stamp.seconds + stamp.nanos * NANO)
    return None


def numbers_of(value: Any, name: str) -> Iterator[tuple[str, float]]:
    """All numbers in a message by their names."""
    if isinstance(value, (bool, int, float)):
        yield name, float(value)
    elif isinstance(value, Message):
        for field in value.DESCRIPTOR.fields:
            yield from numbers_of(getattr(value, field.name), f"{name}.{field.name}")
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            if field.name != "__msgtype__":
                yield from numbers_of(getattr(value, field.name), f"{name}.{field.name}")
    elif isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, (str, bytes)):
        for k, item in enumerate(value[:MOST_ARRAY] if len(value) <= MOST_ARRAY else ()):
            place = getattr(item, "child_frame_id", None) or k
            plain = item.item() if isinstance(item, np.generic) else item
            yield from numbers_of(plain, f"{name}[{place}]")


def add_columns(
    rows: list[tuple[float, dict[str, float]]],
    columns: dict[str, Array],
    times: dict[str, Array],
) -> None:
    """Adds the columns of a topic; a number may be missing in some of its messages."""
    by_name: dict[str, tuple[list[float], list[float]]] = {}
    for seconds, numbers in rows:
        for name, number in numbers.items():
            there = by_name.setdefault(name, ([], []))
            there[0].append(seconds)
            there[1].append(number)
    for name, (at, values) in by_name.items():
        times[name], columns[name] = np.array(at), np.array(values)
