"""Reads recorded flights: logs of other programs by a map (docs/imports.md), and flight logs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skybody import InputError
from skybody.exports.frames import FLIP, FLIP_QUATERNION
from skybody.imports import motion
from skybody.imports.channels import Channels, Samples
from skybody.imports.map_file import Columns, Map, Robot, find_map, read_map, shipped_maps
from skybody.imports.sources import source_of
from skybody.imports.topics import with_columns
from skybody.imports.units import UNITS
from skybody.look.flight import Array, Flight

from .record import SHARE, SPEED, CommandLaw, Record
from .vehicle import Vehicle

GYRO, FORCE, VOLTAGE = "imu.angular_rate", "imu.specific_force", "battery.voltage"
UNIT_OF = {"gyro": GYRO, "accelerometer": FORCE, "voltage": VOLTAGE}  # names of --unit


@dataclass(frozen=True)
class Log:
    """A log of the command line: `FILE`, or `FILE@FROM:UNTIL` with times since its start [s]."""

    path: Path
    first: float = 0.0
    last: float = float("inf")

    @classmethod
    def of(cls, text: str) -> Log:
        """Reads the argument. Raises InputError if its times are none."""
        name, mark, times = text.rpartition("@")
        if not mark or Path(text).exists():
            return cls(Path(text))
        try:
            first, last = (float(part) if part else None for part in times.split(":"))
        except ValueError:
            raise InputError(
                f"{text}: allowed behind `@`: FROM:UNTIL in s, such as @10:35"
            ) from None
        made = cls(Path(name), first or 0.0, float("inf") if last is None else last)
        if not 0.0 <= made.first < made.last:
            raise InputError(f"{text}: allowed behind `@`: FROM below UNTIL, from 0 on [s]")
        return made


def read(log: Log, vehicle: Vehicle, map_name: str, units: dict[str, str]) -> Record:
    """Reads one flight.

    Args:
        log: its file and the part that is used.
        vehicle: the nominal one.
        map_name: a map, or a shipped one; empty: the usual one of the kind of log.
        units: by the names of UNIT_OF, in place of those of the map.

    Raises:
        InputError: the log cannot be read, or lacks commands or measurements.
    """
    if not log.path.exists():
        raise InputError(f"{log.path}: no such file; logs are .csv, .ulg, .usd, .mcap or flight.h5")
    if log.path.is_dir() or log.path.suffix == ".h5":
        record = own(log.path, vehicle)
    else:
        source = source_of(log.path)
        name = map_name or source.map
        if not name:
            shipped = ", ".join(shipped_maps())
            raise InputError(f"{log.path}: --map is missing: a file, or a shipped one: {shipped}")
        used = read_map(find_map(name))
        record = Reader(source.read(log.path, used), used, vehicle, units).record()
    return part_of(record, log)


def part_of(record: Record, log: Log) -> Record:
    """The part of a flight between two times since its start."""
    begin, end = record.span()
    if end <= begin:
        raise InputError(f"{record.path}: commands and measurements have no common times")
    bad = []
    if log.first > 0.0:
        bad.append((-np.inf, begin + log.first, "before FROM"))
    if log.last < end - begin:
        bad.append((begin + log.last, np.inf, "after UNTIL"))
    return record.without(bad)


class Reader:
    """Takes the values of a map from the columns of a log."""

    def __init__(
        self, channels: Channels, used: Map, vehicle: Vehicle, units: dict[str, str]
    ) -> None:
        if len(used.robots) != 1:
            raise InputError(f"{used.file}: robots: has {len(used.robots)}; allowed here: one")
        place = f"{used.file}: robots.{used.robots[0].name}"
        self._robot: Robot = with_columns(used.robots[0], channels, place)
        self._channels, self._map, self._vehicle = channels, used, vehicle
        self._units, self._ned = units, used.frame == "ned"

    def record(self) -> Record:
        """The flight."""
        law, command = self._commands()
        robot = self._robot
        record = Record(
            self._channels.path,
            law,
            command,
            voltage=self._sensor("voltage"),
            position=self._vector(robot.position),
            quaternion=self._attitude(),
            velocity=self._velocity(),
            gyro=self._gyro(),
            force=self._sensor("accelerometer"),
        )
        if record.position is not None and record.quaternion is None:
            raise InputError(f"{self._channels.path}: has positions and no attitude")
        if record.gyro is None and record.quaternion is None:
            raise InputError(
                f"{self._channels.path}: has neither attitude nor angular rates; name their "
                f"columns in the map: `quaternion`, or sensors.{GYRO}"
            )
        if record.position is None and record.force is None:
            raise InputError(
                f"{self._channels.path}: has neither position nor accelerometer; name their "
                f"columns in the map: `position`, or sensors.{FORCE}"
            )
        return record

    def _commands(self) -> tuple[CommandLaw, Samples]:
        """The nominal law of the commands, and they themselves."""
        rotors = self._robot.rotors
        if rotors is None or not self._there(rotors.columns):
            raise InputError(
                f"{self._channels.path}: has no commands of motors: name their columns in the map: "
                f"robots.{self._robot.name}.rotor_speed"
            )
        names = self._vehicle.rotor_names
        if missing := [name for name in names if name not in rotors.names]:
            raise InputError(
                f"{self._map.file}: {rotors.columns.place}: rotor `{missing[0]}` of the model has "
                f"no column; there are: {', '.join(rotors.names)}"
            )
        samples = self._samples(rotors.columns)
        order = [rotors.names.index(name) for name in names]
        values = samples.values[:, order]
        if rotors.law.span is None:
            if rotors.law.kind != "speed":
                raise InputError(
                    f"{self._map.file}: {rotors.columns.place}: `range` is missing: the commands "
                    "at rest and at full power"
                )
            return CommandLaw(SPEED), Samples(samples.time, rotors.columns.factor * values)
        low, high = rotors.law.span
        shares = np.linspace(0.0, 1.0, 201)
        most = np.array([self._vehicle.max_speed])
        grid = (low + shares * (high - low))[:, None]
        speeds = rotors.law.speeds(grid, rotors.columns.factor, most)[:, 0]
        law = CommandLaw(SHARE, low, high, shares, speeds)
        return law, Samples(samples.time, (values - low) / (high - low))

    def _there(self, columns: Columns | None) -> bool:
        return columns is not None and (not columns.optional or self._channels.has(columns))

    def _samples(self, columns: Columns) -> Samples:
        return self._channels.samples(columns, bridge=self._map.bridges_gaps)

    def _vector(self, columns: Columns | None) -> Samples | None:
        """A vector in SI units, z up or y left."""
        if columns is None or not self._there(columns):
            return None
        samples = self._samples(columns)
        return Samples(samples.time, columns.factor * samples.values * (FLIP if self._ned else 1.0))

    def _velocity(self) -> Samples | None:
        columns = self._robot.velocity
        return self._vector(columns) if columns is not None and columns.axes == "world" else None

    def _attitude(self) -> Samples | None:
        attitude = self._robot.attitude
        if attitude is None or not self._there(attitude.columns):
            return None
        samples = self._samples(attitude.columns)
        if attitude.order:
            found = samples.values[:, attitude.order]
            place = f"{self._channels.path}: {attitude.columns.place}"
            motion.check_norms(found, place)
        else:
            found = motion.quaternions_of_angles(attitude.columns.factor * samples.values)
        found = found * (FLIP_QUATERNION if self._ned else 1.0)
        return Samples(
            samples.time, motion.quaternions_at(Samples(samples.time, found), samples.time)
        )

    def _gyro(self) -> Samples | None:
        """The gyroscope, or else the rates of the map if they are in body axes."""
        if (found := self._sensor("gyro")) is not None:
            return found
        columns = self._robot.angular_velocity
        if columns is None or columns.axes != "body":
            return None
        return self._vector(columns)

    def _sensor(self, name: str) -> Samples | None:
        columns = self._map.sensors.get(UNIT_OF[name])
        if columns is None or not self._there(columns):
            return None
        factor = UNITS[self._units[name]][0] if name in self._units else columns.factor
        samples = self._channels.samples(columns, bridge=self._map.bridges_gaps, may_be_nan=True)
        good = np.isfinite(samples.values).all(axis=1)
        flips = FLIP if self._ned and samples.values.shape[1] == 3 else 1.0
        return Samples(samples.time[good], factor * samples.values[good] * flips)


def own(path: Path, vehicle: Vehicle) -> Record:
    """A flight log of Skybody with one robot: its rotors' commands and motion, and its IMU."""
    flight = Flight(path)
    if len(flight.body_names) != 1:
        raise InputError(f"{flight.path}: has {len(flight.body_names)} bodies; allowed here: one")
    names = [name.partition(".")[2] for name in flight.rotor_names]
    if missing := [name for name in vehicle.rotor_names if name not in names]:
        raise InputError(f"{flight.path}: has no rotor `{missing[0]}` of the model")
    order = [names.index(name) for name in vehicle.rotor_names]
    speeds = np.asarray(flight.data["rotor_command"][:], dtype=np.float64)[:, order]
    time, motion_of = flight.time, flight.bodies[:, 0]

    def sensor(name: str, count: int) -> Samples | None:
        columns = [column for column, _ in flight.columns("sensors")]
        wanted = [name] if count == 1 else [f"{name}[{k}]" for k in range(count)]
        if not all(column in columns for column in wanted):
            return None
        values: Array = np.stack([flight.series(column)[0] for column in wanted], axis=1)
        good = np.isfinite(values).all(axis=1)
        return Samples(time[good], values[good])

    gyro = sensor(GYRO, 3)
    return Record(
        flight.path,
        CommandLaw(SPEED),
        # The command of a row acts from the row before on.
        Samples(time[:-1], speeds[1:]),
        voltage=sensor(VOLTAGE, 1),
        position=Samples(time, motion_of[:, :3]),
        quaternion=Samples(time, motion_of[:, 3:7]),
        velocity=Samples(time, motion_of[:, 7:10]),
        gyro=gyro if gyro is not None else Samples(time, motion_of[:, 10:13]),
        force=sensor(FORCE, 3),
    )
