"""Recorded flights: states by motion capture, motor commands, battery voltage, setpoints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from skybody import InputError
from skybody.identify.attitude import turned
from skybody.imports import motion
from skybody.imports.channels import Channels
from skybody.imports.flight import Imported, build
from skybody.imports.map_file import Columns, Map, find_map, read_map
from skybody.imports.sources import source_of

Reals = NDArray[np.float64]
ENDINGS = (".csv", ".csv.gz")
# Setpoints of the onboard attitude controller, as the firmware logs them: degrees, pitch positive
# nose up, and the collective thrust in units of PWM.
SETPOINT = tuple(f"pid_controller_{name}" for name in ("roll", "pitch", "yaw", "cmd_thrust"))
MOTORS = ("front_right", "back_right", "back_left", "front_left")  # m1 to m4 of the vehicle
MOST_PWM = 65535.0


@dataclass(frozen=True)
class Recorded:
    """A flight of one vehicle, one row per sample of the motion capture."""

    name: str
    time: Reals  # since the first row [s]
    states: Reals  # (rows, 13): position (W), quaternion w x y z, velocity (W), rates (B)
    pwm: Reals  # (rows, 4), in the order of MOTORS, 0 to MOST_PWM
    voltage: Reals  # of the battery [V]; NaN: not recorded
    specific_force: Reals  # (rows, 3), B [m/s^2]
    setpoint: Reals | None  # (rows, 4): roll, pitch, yaw [rad], thrust [share]; None: not recorded
    has_pose: bool = True  # False: states have attitudes by the gyroscope, positions are 0


def files_of(paths: list[Path]) -> list[Path]:
    """The flights of folders and files.

    Raises:
        InputError: a path does not exist, or there is no flight.
    """
    found: list[Path] = []
    for path in paths:
        if not path.exists():
            raise InputError(f"{path}: no such file or folder")
        inside = sorted(path.iterdir()) if path.is_dir() else [path]
        found += [file for file in inside if file.name.endswith(ENDINGS) or file == path]
    if not found:
        raise InputError(f"{', '.join(map(str, paths))}: no flight; allowed: *.csv, *.csv.gz")
    return found


def read(path: Path, map_name: str) -> Recorded:
    """Reads a flight by the reader of `skybody import`.

    Args:
        path: a CSV file.
        map_name: a map file or the name of a shipped map (docs/imports.md).

    Raises:
        InputError: the file is not usable, or lacks poses, motor commands, voltage or IMU.
    """
    used = read_map(find_map(map_name))
    channels = source_of(path).read(path, used)
    name = path.name.partition(".")[0]
    made = build(channels, used, name, 0.0, math.inf)
    rotors = used.robots[0].rotors
    if made.bodies is None or rotors is None or not set(MOTORS) <= set(rotors.names):
        raise InputError(f"{path}: needs poses and the motor commands of {', '.join(MOTORS)}")
    order = [rotors.names.index(motor) for motor in MOTORS]
    return Recorded(
        name,
        made.time,
        made.bodies[:, 0],
        at_rows(channels, used, rotors.columns)[:, order],
        sensor(path, made, "battery.voltage")[:, 0],
        sensor(path, made, "imu.specific_force", 3),
        setpoint_of(channels, used),
    )


@dataclass(frozen=True)
class Stretch:
    """A part of a log without poses, by the log's own clock."""

    path: Path
    first: float  # [s]
    last: float  # [s]


def read_stretch(stretch: Stretch) -> Recorded:
    """Reads a part of a log of gyroscope, accelerometer and motor commands, without poses.

    Attitudes are relative to the one at the beginning, by the gyroscope.

    Raises:
        InputError: the file is not usable.
    """
    path = stretch.path
    source = source_of(path)
    used = read_map(find_map(source.map))
    channels = source.read(path, used)
    name = f"{path.name.partition('.')[0]}, {stretch.first:g} to {stretch.last:g} s"
    begin = min(float(times[0]) for times in channels.times.values())
    first, last = stretch.first - begin, stretch.last - begin
    made = build(channels, used, path.name.partition(".")[0], first, last)
    rotors = used.robots[0].rotors
    if rotors is None or not set(MOTORS) <= set(rotors.names):
        raise InputError(f"{path}: needs the motor commands of {', '.join(MOTORS)}")
    order = [rotors.names.index(motor) for motor in MOTORS]
    times = made.origin + made.time
    pwm = motion.at(channels.samples(rotors.columns, bridge=False), times)[:, order]
    rates = sensor(path, made, "imu.angular_rate", 3)
    states = np.zeros((len(times), 13))
    states[:, 3:7], states[:, 10:] = turned(made.time, rates), rates
    force = sensor(path, made, "imu.specific_force", 3)
    none = np.full(len(times), np.nan)
    return Recorded(name, made.time, states, pwm, none, force, None, False)


def at_rows(channels: Channels, used: Map, columns: Columns) -> Reals:
    """Values of columns at the rows of the poses, (rows, columns)."""
    place = used.robots[0].position
    assert place is not None  # there are poses
    rows = channels.samples(place, bridge=used.bridges_gaps).time
    samples = channels.samples(columns, bridge=used.bridges_gaps)
    return columns.factor * motion.held(samples, rows)


def sensor(path: Path, made: Imported, name: str, count: int = 1) -> Reals:
    """A sensor of the map, (rows, count)."""
    names = [name] if count == 1 else [f"{name}[{k}]" for k in range(count)]
    if missing := [name for name in names if name not in made.sensors]:
        raise InputError(f"{path}: the map has no sensor `{missing[0]}`")
    return np.stack([made.sensors[name][0] for name in names], axis=1)


def setpoint_of(channels: Channels, used: Map) -> Reals | None:
    """Setpoints of the onboard controller; None: not recorded, or only zeros."""
    if any(name not in channels.columns for name in SETPOINT):
        return None
    values = at_rows(channels, used, Columns("setpoint", SETPOINT))
    if not values[:, 3].any():
        return None
    turns = np.radians(values[:, :3]) * [1.0, -1.0, 1.0]
    return np.concatenate([turns, values[:, 3:] / MOST_PWM], axis=1)
