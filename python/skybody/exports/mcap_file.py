"""MCAP with Foxglove's schemas: transforms, poses, odometry, shapes, images and plots."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import BinaryIO

import foxglove
from foxglove import channels
from foxglove import messages as fox
from foxglove.mcap import MCAPWriteOptions

from . import foxglove_messages as made
from .about import SCENARIO, about
from .frames import frame_of, topic_of
from .images import pictures
from .order import Stream, Timed, events, in_order
from .table import NANO, Block, Table
from .values import Values
from .world import World

ABOUT = "skybody"  # metadata: about()
PARAMETERS = "skybody parameters"  # metadata: values drawn for the episode, by path


def write(table: Table, path: Path, options: argparse.Namespace) -> None:
    """Writes all messages in the order of their times; docs/exports.md lists the topics."""
    context = foxglove.Context()
    settings = MCAPWriteOptions(compression_threads=0, disable_seeking=True)
    with path.open("wb") as file:
        output = Output(file)
        with foxglove.open_mcap(output, context=context, writer_options=settings) as writer:
            writer.write_metadata(ABOUT, about(table, SCENARIO))
            drawn = {path: repr(value) for path, value in table.flight.drawn.items()}
            writer.write_metadata(PARAMETERS, drawn)
            world = World(table)
            write_shapes(world, round(table.ends[0] * NANO), context)
            streams = streams_of(table, world, context)
            between = [logs(table, context), images(table, options.images, context)]
            for time, channel, message in in_order(table, streams, between):
                channel.log(message, log_time=round(time * NANO))
                output.check()
        output.check()


class Output:
    """A file for foxglove-sdk, which prints an error for each write that fails."""

    def __init__(self, file: BinaryIO) -> None:
        self._file, self._place = file, 0
        self._error: OSError | None = None

    def write(self, data: bytes | bytearray) -> int:
        """Writes, unless it has failed."""
        if self._error is None:
            try:
                self._file.write(data)
            except OSError as error:
                self._error = error
        self._place += len(data)
        return len(data)

    def seek(self, offset: int, whence: int = 0) -> int:
        """The place: nothing else is asked with `disable_seeking`."""
        return self._place

    def flush(self) -> None:
        """Nothing: the file is closed at the end."""

    def check(self) -> None:
        """Raises the error of the first write that failed."""
        if self._error is not None:
            raise self._error


def write_shapes(world: World, stamp: int, context: foxglove.Context) -> None:
    """Writes the shapes of bodies and obstacles, once."""
    if world.parts:
        scene = channels.SceneUpdateChannel("/scene", context=context)
        entities = [made.entity(part, stamp) for part in world.parts]
        scene.log(fox.SceneUpdate(entities=entities), log_time=stamp)


def logs(table: Table, context: foxglove.Context) -> Iterator[Timed]:
    """The events of the episode."""
    channel = channels.LogChannel("/events", context=context)
    for time, text in events(table):
        stamp = made.stamp_of(round(time * NANO))
        yield time, channel, fox.Log(timestamp=stamp, level=fox.LogLevel.Info, message=text)


def images(table: Table, camera: str | None, context: foxglove.Context) -> Iterator[Timed]:
    """The pictures, with the lens and the place of their camera."""
    if camera is None:
        return
    image = channels.CompressedImageChannel("/camera/image", context=context)
    lens = channels.CameraCalibrationChannel("/camera/calibration", context=context)
    place = channels.FrameTransformsChannel("/camera/tf", context=context)
    for time, picture in pictures(table, camera):
        stamp = round(time * NANO)
        yield time, place, made.eye(picture, stamp)
        yield time, lens, made.calibration(stamp)
        yield time, image, made.image(picture, stamp)


# --- rows ---------------------------------------------------------------------------------------


def streams_of(table: Table, world: World, context: foxglove.Context) -> list[Stream]:
    """All channels with messages for rows."""
    found = body_streams(table, context) if table.robots else []
    if "goal" in table.series:
        for k, name in enumerate(table.series["goal"].items):
            goal = channels.PoseInFrameChannel(
                topic_of("goal", name), context=context, metadata={"goal": name}
            )
            found.append((goal, partial(made.goals, goal=k)))
    if world.has_lines:
        lines = channels.SceneUpdateChannel("/couplings", context=context)
        found.append((lines, partial(made.couplings, world=world)))
    rest = [name for name in table.series if name not in ("bodies", "goal")]
    return found + [plot_stream(table, name, context) for name in rest]


def body_streams(table: Table, context: foxglove.Context) -> list[Stream]:
    """Transforms of all bodies, the pose of each robot's base, the odometry of each body."""
    names = table.series["bodies"].items
    frames = [frame_of(name) for name in names]
    transforms = channels.FrameTransformsChannel("/tf", context=context)
    found: list[Stream] = [(transforms, partial(made.transforms, frames=frames))]
    for robot, bodies in table.robots.items():
        pose = channels.PoseInFrameChannel(f"{topic_of(robot)}/pose", context=context)
        found.append((pose, partial(made.base, body=bodies[0])))
        for k in bodies:
            topic = topic_of(robot if k == bodies[0] else names[k])
            odometry = channels.OdometryChannel(
                f"{topic}/odometry", context=context, metadata={"body": names[k]}
            )
            found.append((odometry, partial(made.odometry, body=k, frame=frames[k])))
    return found


def plot_stream(table: Table, name: str, context: foxglove.Context) -> Stream:
    """The values of a dataset, by name; the channel's metadata describes its columns."""
    series = table.series[name]
    values = Values(series)
    schema = foxglove.Schema(name=values.name, encoding="protobuf", data=values.schema)
    about_columns = {"columns": series.columns, "units": series.units, "type": series.type.str}
    channel = foxglove.Channel(
        topic_of("log", name),
        schema=schema,
        message_encoding="protobuf",
        context=context,
        metadata={"dataset": name} | {k: json.dumps(v) for k, v in about_columns.items()},
    )
    width = len(series.paths)

    def messages(block: Block) -> Iterator[bytes]:
        return values.encode(block.real(name).reshape(-1, width))

    return channel, messages
