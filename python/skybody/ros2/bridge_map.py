"""The map of a ROS 2 bridge: which topic has which type and which part of the simulation."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from skybody import InputError

from .commands import COMMANDS
from .states import STATES

KEYS = {"control", "publish", "command", "clock"}
ROW = {"topic", "type", "from", "to", "robot", "body", "rate", "frame"}


@dataclass(frozen=True)
class Row:
    """A topic."""

    topic: str
    type: str  # such as sensor_msgs/msg/Imu
    part: str  # of the simulation: a row of STATES or COMMANDS, or a sensor's channel
    robot: str = ""  # empty: the only one
    body: str = ""  # of `pose`, `odometry`: ROBOT.LINK; empty: the robot's base
    rate: float = 0.0  # per second of simulated time, at most; 0: after each step
    frame: str = ""  # header.frame_id; empty: that of the row of STATES


@dataclass(frozen=True)
class BridgeMap:
    """All topics of a bridge."""

    publish: list[Row] = field(default_factory=list)
    command: list[Row] = field(default_factory=list)
    control: str | None = None  # as of skybody.Simulation; None: the scenario's controllers
    clock: bool = True


def read_map(path: Path) -> BridgeMap:
    """Reads a map.

    Raises:
        InputError: every mistake, with the file and the row.
    """
    try:
        content = yaml.safe_load(path.read_text())
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except yaml.YAMLError as error:
        raise InputError(f"{path}: is no YAML: {error}") from None
    if not isinstance(content, dict):
        raise InputError(f"{path}: a map has the keys {', '.join(sorted(KEYS))}")
    if unknown := set(content) - KEYS:
        raise InputError(
            f"{path}: unknown key {sorted(unknown)}; allowed: {', '.join(sorted(KEYS))}"
        )
    publish = [row_of(path, entry, "from") for entry in content.get("publish") or []]
    command = [row_of(path, entry, "to") for entry in content.get("command") or []]
    check(path, publish, command)
    return BridgeMap(publish, command, content.get("control"), bool(content.get("clock", True)))


def row_of(path: Path, entry: Any, part: str) -> Row:
    """A row of the file."""
    if not isinstance(entry, dict) or set(entry) - ROW or not {"topic", "type", part} <= set(entry):
        raise InputError(
            f"{path}: {entry!r} is no row; a row has topic, type, {part}, and may have "
            f"{', '.join(sorted(ROW - {'topic', 'type', 'from', 'to'}))}"
        )
    values = {key: entry[key] for key in ROW & set(entry) - {"from", "to", "rate"}}
    return Row(part=str(entry[part]), rate=float(entry.get("rate", 0.0)), **values)


def check(path: Path, publish: list[Row], command: list[Row]) -> None:
    """Compares parts and types with the tables."""
    for row in publish:
        types = STATES[row.part].types if row.part in STATES else None
        if types is not None and row.type not in types:
            raise InputError(
                f"{path}: {row.topic}: `{row.part}` as {row.type}; allowed: {', '.join(types)}"
            )
    for row in command:
        if row.part not in COMMANDS:
            raise InputError(
                f"{path}: {row.topic}: no command `{row.part}`; there are: {', '.join(COMMANDS)}"
            )
        if row.type not in COMMANDS[row.part].readers:
            allowed = ", ".join(COMMANDS[row.part].readers)
            raise InputError(f"{path}: {row.topic}: {row.type}; allowed: {allowed}")
    topics = [row.topic for row in (*publish, *command)]
    if twice := {topic for topic in topics if topics.count(topic) > 1}:
        raise InputError(f"{path}: topics are named twice: {', '.join(sorted(twice))}")
