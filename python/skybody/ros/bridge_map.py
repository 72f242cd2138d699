"""The map of a bridge to ROS: which topic has which type and which part of the simulation."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from skybody import InputError
from skybody.imports.keys import is_number, read_yaml
from skybody.simulation import CONTROL_MODES

from .commands import COMMANDS
from .states import STATES

KEYS = {"control", "publish", "command", "clock"}
MOST_RATE = 1e6  # of messages of a row, per second of simulated time
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
        InputError: the first mistake, with the file and the row.
    """
    content = read_yaml(path)
    if not isinstance(content, dict):
        raise InputError(f"{path}: a map has the keys {', '.join(sorted(KEYS))}")
    if unknown := set(content) - KEYS:
        raise InputError(
            f"{path}: unknown key {sorted(unknown)}; allowed: {', '.join(sorted(KEYS))}"
        )
    publish = rows_of(path, content, "publish", "from")
    command = rows_of(path, content, "command", "to")
    check(path, publish, command)
    control, clock = content.get("control"), content.get("clock", True)
    if not isinstance(control, str | None):
        raise InputError(f"{path}: control: is `{control}`; allowed: a text, as skybody.Simulation")
    if not isinstance(clock, bool):
        raise InputError(f"{path}: clock: is `{clock}`; allowed: true, false")
    check_control(path, control, command)
    return BridgeMap(publish, command, control, clock)


def rows_of(path: Path, content: dict[str, Any], key: str, part: str) -> list[Row]:
    """The rows of `publish` or `command`."""
    entries = content.get(key) or []
    if not isinstance(entries, list):
        raise InputError(f"{path}: {key}: is `{entries}`; allowed: a list of rows")
    return [row_of(path, entry, part) for entry in entries]


def row_of(path: Path, entry: Any, part: str) -> Row:
    """A row of the file."""
    if not isinstance(entry, dict) or set(entry) - ROW or not {"topic", "type", part} <= set(entry):
        raise InputError(
            f"{path}: {entry!r} is no row; a row has topic, type, {part}, and may have "
            f"{', '.join(sorted(ROW - {'topic', 'type', 'from', 'to'}))}"
        )
    for key in sorted(set(entry) - {"rate"}):
        if not isinstance(entry[key], str):
            raise InputError(f"{path}: {entry!r}: `{key}` is `{entry[key]}`; allowed: a text")
    rate = entry.get("rate", 0.0)
    if not is_number(rate) or not 0.0 <= rate <= MOST_RATE:
        raise InputError(
            f"{path}: {entry['topic']}: `rate` is `{rate}`; allowed: 0 to {MOST_RATE:g}"
        )
    values = {key: entry[key] for key in ROW & set(entry) - {"from", "to", "rate"}}
    values["type"] = full_type(entry["type"])
    return Row(part=entry[part], rate=float(rate), **values)


def full_type(name: str) -> str:
    """PACKAGE/msg/TYPE, of which ROS 1 writes PACKAGE/TYPE."""
    return name if name.count("/") != 1 else name.replace("/", "/msg/")


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


def check_control(path: Path, control: str | None, command: list[Row]) -> None:
    """Compares commands with the control mode; of a list of controllers the sizes tell."""
    for row in command:
        wanted = COMMANDS[row.part].control
        if wanted is not None and control in CONTROL_MODES and control != wanted:
            raise InputError(
                f"{path}: {row.topic}: `to: {row.part}` needs `control: {wanted}`; the map has "
                f"`control: {control}`"
            )
