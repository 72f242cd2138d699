"""A bag of ROS 2: odometry, transforms, IMU, goals, rotors, markers."""

from __future__ import annotations

import argparse
import errno
import os
import sqlite3
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, Literal

from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer

from . import ros_messages as made
from .about import about
from .frames import frame_of, topic_of
from .images import pictures
from .order import Timed, events, in_order
from .ros_messages import TYPES
from .sensors import imus
from .table import NANO, Block, Table
from .world import World

VERSION: Literal[8] = 8  # of bags: the greatest one that ROS 2 Humble reads
NEVER = QosTime(0, 0)
LATCHED = Qos(  # the last message also reaches those who subscribe later
    QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL, NEVER, NEVER,
    QosLiveliness.AUTOMATIC, NEVER, False,
)  # fmt: skip

# A topic, its type, and its messages of the rows of a block.
Topic = tuple[str, str, Callable[[Block], Iterator[Any]]]


def write(table: Table, path: Path, options: argparse.Namespace) -> None:
    """Writes a folder with all messages; docs/exports.md lists the topics."""
    plugin = StoragePlugin.MCAP if options.storage == "mcap" else StoragePlugin.SQLITE3
    try:
        with Writer(path, version=VERSION, storage_plugin=plugin) as writer:
            for key, text in about(table).items():
                writer.set_custom_data(key, text)
            bag, world = Bag(writer), World(table)
            write_shapes(bag, world, round(table.ends[0] * NANO))
            write_messages(bag, table, topics_of(table, world), options.images)
    except sqlite3.OperationalError as error:
        if error.sqlite_errorcode == sqlite3.SQLITE_FULL:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)) from None
        raise OSError(str(error)) from None


class Bag:
    """A bag that is being written."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer
        self._connections: dict[str, Connection] = {}

    def add_topic(self, topic: str, kind: str, qos: tuple[Qos, ...] = ()) -> None:
        """Adds a topic of a type such as `nav_msgs/Odometry`."""
        package, _, name = kind.partition("/")
        self._connections[topic] = self.writer.add_connection(
            topic, f"{package}/msg/{name}", typestore=TYPES, offered_qos_profiles=qos
        )

    def add(self, topic: str, stamp: int, message: Any) -> None:
        """Writes a message at a time [ns]."""
        connection = self._connections[topic]
        self.writer.write(connection, stamp, TYPES.serialize_cdr(message, connection.msgtype))


def write_shapes(bag: Bag, world: World, stamp: int) -> None:
    """Writes the shapes of bodies and obstacles, once."""
    if world.parts:
        bag.add_topic("/markers", "visualization_msgs/MarkerArray", (LATCHED,))
        bag.add("/markers", stamp, made.markers(world.parts, stamp))


def write_messages(bag: Bag, table: Table, topics: list[Topic], camera: str | None) -> None:
    """Writes all other messages in the order of their times."""
    between: list[Iterator[Timed]] = []
    if table.flight.events:
        bag.add_topic("/events", "rcl_interfaces/Log")
        between.append(logs(table))
    if camera:
        bag.add_topic("/camera/camera_info", "sensor_msgs/CameraInfo")
        bag.add_topic("/camera/image/compressed", "sensor_msgs/CompressedImage")
        bag.add_topic("/camera/tf", "tf2_msgs/TFMessage")
        between.append(images(table, camera))
    for topic, kind, _ in topics:
        bag.add_topic(topic, kind)
    streams = [(topic, messages) for topic, _, messages in topics]
    for time, topic, message in in_order(table, streams, between):
        bag.add(topic, round(time * NANO), message)


def logs(table: Table) -> Iterator[Timed]:
    """The events of the episode."""
    for time, text in events(table):
        yield time, "/events", made.log(round(time * NANO), text)


def images(table: Table, camera: str) -> Iterator[Timed]:
    """The pictures, with the lens and the place of their camera."""
    for time, picture in pictures(table, camera):
        stamp = round(time * NANO)
        yield time, "/camera/tf", made.eye(picture, stamp)
        yield time, "/camera/camera_info", made.lens(stamp)
        yield time, "/camera/image/compressed", made.image(picture, stamp)


# --- rows ---------------------------------------------------------------------------------------


def topics_of(table: Table, world: World) -> list[Topic]:
    """All topics with messages for rows."""
    found = body_topics(table) if table.robots else []
    if "goal" in table.series:
        for k, name in enumerate(table.series["goal"].items):
            topic = topic_of("goal", name)
            found.append((topic, "geometry_msgs/PoseStamped", partial(made.goals, goal=k)))
    for dataset, word in (("rotor_speed", "rotors"), ("rotor_command", "rotor_commands")):
        found += rotor_topics(table, dataset, word)
    for name, (force, rate) in imus(table).items():
        messages = partial(made.imu, force=force, rate=rate, frame=name)
        found.append((topic_of(name), "sensor_msgs/Imu", messages))
    if world.has_lines:
        messages = partial(made.couplings, world=world)
        found.append(("/couplings", "visualization_msgs/MarkerArray", messages))
    for name, series in table.series.items():
        if name not in ("bodies", "goal", "rotor_speed", "rotor_command"):
            names = [path.removeprefix(f"{name}/") for path in series.paths]
            messages = partial(made.numbers, dataset=name, names=names)
            found.append((topic_of("log", name), "std_msgs/Float64MultiArray", messages))
    return found


def body_topics(table: Table) -> list[Topic]:
    """Transforms of all bodies, and the odometry of each."""
    names = table.series["bodies"].items
    frames = [frame_of(name) for name in names]
    found: list[Topic] = [
        ("/tf", "tf2_msgs/TFMessage", partial(made.transforms, frames=frames)),
    ]
    for robot, bodies in table.robots.items():
        for k in bodies:
            topic = f"{topic_of(robot if k == bodies[0] else names[k])}/odometry"
            messages = partial(made.odometry, body=k, frame=frames[k])
            found.append((topic, "nav_msgs/Odometry", messages))
    return found


def rotor_topics(table: Table, dataset: str, word: str) -> Iterator[Topic]:
    """The speeds of each robot's rotors."""
    columns = table.series[dataset].columns if dataset in table.series else ()
    robots = [name.partition(".")[0] for name in columns]
    for robot in dict.fromkeys(robots):
        mine = [k for k, name in enumerate(robots) if name == robot]
        names = [columns[k].partition(".")[2] for k in mine]
        messages = partial(made.speeds, dataset=dataset, columns=mine, names=names)
        yield f"{topic_of(robot)}/{word}", "sensor_msgs/JointState", messages
