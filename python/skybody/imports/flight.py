"""A flight from the columns of a log."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from skybody import InputError
from skybody.exports.frames import FLIP, FLIP_QUATERNION, to_body
from skybody.look.flight import Array

from . import motion
from .channels import Channels, Samples
from .log_file import Dataset, Log
from .map_file import Columns, Map, Robot
from .scenario import World, world_of
from .topics import with_columns

POLICY = "a real flight"
BODY = ("x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz")
BODY_UNITS = ("m", "m", "m", "", "", "", "", *("m/s",) * 3, *("rad/s",) * 3)
GOAL, GOAL_UNITS = ("x", "y", "z", "yaw"), ("m", "m", "m", "rad")
IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass
class Imported:
    """A flight in the terms of a flight log (docs/flight-log.md)."""

    time: Array  # since the first row [s]
    origin: float  # time of the first row in the other log [s]
    world: World
    bodies: Array | None  # (rows, bodies, 13); None: no poses were recorded
    rotor_speed: Array | None  # (rows, rotors)
    goals: dict[str, Array] = field(default_factory=dict)  # by body, (rows, 4)
    info: dict[str, tuple[Array, str]] = field(default_factory=dict)  # values and unit
    sensors: dict[str, tuple[Array, str]] = field(default_factory=dict)

    def log(self, source: str) -> Log:
        """Its log.

        Args:
            source: name of the file that it comes from.
        """
        world, rows = self.world, len(self.time)
        rotors = [rotor.name for rotor in world.compiled.rotors]
        sets = {
            "reward": Dataset(np.zeros(rows, np.float32)),
            "status": Dataset(np.zeros(rows, np.uint64)),
        }
        if self.bodies is not None:
            sets["bodies"] = Dataset(self.bodies, BODY, BODY_UNITS, world.bodies)
        if self.goals:
            goals = np.stack(list(self.goals.values()), axis=1)
            sets["goal"] = Dataset(goals, GOAL, GOAL_UNITS, list(self.goals))
        if self.rotor_speed is not None:
            speeds = Dataset(self.rotor_speed, rotors, ["rad/s"] * len(rotors))
            sets |= {"rotor_speed": speeds, "rotor_command": speeds}
        for name, values, kind in (
            ("info", self.info, np.float32),
            ("sensors", self.sensors, np.float64),
        ):
            if values:
                columns = np.stack([column for column, _ in values.values()], axis=1)
                units = [unit for _, unit in values.values()]
                sets[name] = Dataset(columns.astype(kind), list(values), units)
        return Log(
            scenario=world.name,
            scenario_file=str(world.file),
            scenario_text=world.compiled.scenario_text,
            scenario_hash=f"{world.compiled.scenario_hash:016x}",
            policy=POLICY,
            seed="0",
            dt=float(np.median(np.diff(self.time))),
            action_repeat=1,
            bodies=world.bodies,
            rotors=rotors,
            time=self.time,
            datasets=sets,
            events=[(0.0, f"imported from {source}")],
            time_origin=self.origin,
        )


class Builder:
    """Takes the values of a map from the columns of a log."""

    def __init__(self, channels: Channels, used: Map) -> None:
        robots = [
            with_columns(robot, channels, f"{used.file}: robots.{robot.name}")
            for robot in used.robots
        ]
        self._channels, self._map = channels, replace(used, robots=tuple(robots))
        self._ned = used.frame == "ned"

    def build(self, name: str, first: float, last: float) -> Imported:
        """Makes the flight.

        Args:
            name: of the flight.
            first, last: part of the log that is used, since its first pose [s].

        Raises:
            InputError: columns are missing or not usable.
        """
        times, origin = self._times(first, last)
        states = {r.name: s for r in self._map.robots if (s := self._state(r, times)) is not None}
        if states and len(states) < len(self._map.robots):
            without = [r.name for r in self._map.robots if r.name not in states]
            raise InputError(
                f"{self._map.file}: robots.{without[0]}: has no position, as others have"
            )
        starts = {robot: state[0, :3] for robot, state in states.items()}
        world = world_of(self._map, name, starts)
        made = Imported(times - times[0], origin, world, None, self._rotor_speed(world, times))
        if states:
            made.bodies = np.stack([states[robot.name] for robot in self._map.robots], axis=1)
        else:
            path = self._channels.path
            self._note(f"{path}: has no poses; the log has sensors and rotor speeds alone")
        for k, robot in enumerate(self._map.robots if states else ()):
            head = f"{robot.name}." if len(self._map.robots) > 1 else ""
            self._add_goal(made, robot, times, k, head)
            speed = np.linalg.norm(states[robot.name][:, 7:10], axis=1)
            made.info[f"{head}speed"] = (speed, "m/s")
        self._add_sensors(made, times)
        return made

    def _note(self, text: str) -> None:
        self._channels.notes.append(text)

    # --- times ----------------------------------------------------------------------------------

    def _times(self, first: float, last: float) -> tuple[Array, float]:
        """Times of the rows, and the time of the first pose: those of the densest pose."""
        places = [c for r in self._map.robots for c in (r.position,) if c is not None]
        turns = [r.attitude.columns for r in self._map.robots if r.attitude and r.position]
        chosen = [self._samples(c) for c in (*places, *turns) if self._there(c)]
        if not chosen:
            rest = [r.rotors.columns for r in self._map.robots if r.rotors]
            rest += self._map.sensors.values()
            chosen = [self._samples(c, may_be_nan=True) for c in rest if self._there(c)]
        if not chosen:
            raise InputError(f"{self._map.file}: names no columns of the log")
        begin = max(samples.time[0] for samples in chosen)
        end = min(samples.time[-1] for samples in chosen)
        dense = max(chosen, key=lambda samples: len(samples.time)).time
        times = dense[(dense >= max(begin, begin + first)) & (dense <= min(end, begin + last))]
        if len(times) < 2:
            raise InputError(
                f"{self._channels.path}: has {len(times)} rows from {first:g} to {last:g} s of "
                f"{end - begin:g} s; allowed: at least 2"
            )
        return times, float(times[0])

    def _there(self, columns: Columns) -> bool:
        return not columns.optional or self._channels.has(columns)

    def _samples(self, columns: Columns, *, may_be_nan: bool = False) -> Samples:
        bridge = self._map.bridges_gaps
        return self._channels.samples(columns, bridge=bridge, may_be_nan=may_be_nan)

    # --- bodies ---------------------------------------------------------------------------------

    def _state(self, robot: Robot, times: Array) -> Array | None:
        """The 13 values of a body (rows, 13); None: its position was not recorded."""
        if robot.position is None or not self._there(robot.position):
            return None
        turn = self._attitude(robot, times)
        place = self._vector(robot.position, times)
        window = self._map.window
        velocity = self._in_axes(robot.velocity, times, turn, "world")
        rate = self._in_axes(robot.angular_velocity, times, turn, "body")
        if velocity is None:
            velocity = motion.derivative(times, place, window)
        if rate is None:
            rate = motion.angular_velocities(times, turn, window)
        return np.concatenate([place, turn, velocity, rate], axis=1)

    def _attitude(self, robot: Robot, times: Array) -> Array:
        if robot.attitude is None or not self._there(robot.attitude.columns):
            self._note(f"robot {robot.name} has no attitude; it is drawn level")
            return np.tile(IDENTITY, (len(times), 1))
        columns, order = robot.attitude.columns, robot.attitude.order
        samples = self._samples(columns)
        if order:
            quaternions = samples.values[:, order]
            motion.check_norms(quaternions, f"{self._channels.path}: {columns.place}")
        else:
            quaternions = motion.quaternions_of_angles(columns.factor * samples.values)
        if self._ned:
            quaternions = quaternions * FLIP_QUATERNION
        return motion.quaternions_at(Samples(samples.time, quaternions), times)

    def _vector(self, columns: Columns, times: Array) -> Array:
        """A vector with z up or y left, in SI units."""
        values = columns.factor * motion.at(self._samples(columns), times)
        return values * FLIP if self._ned else values

    def _in_axes(
        self, columns: Columns | None, times: Array, turn: Array, wanted: str
    ) -> Array | None:
        """A vector in the axes of the world or of the body; None: it was not recorded."""
        if columns is None or not self._there(columns):
            return None
        values = self._vector(columns, times)
        if columns.axes == wanted:
            return values
        return to_body(turn, values) if wanted == "body" else motion.to_world(turn, values)

    # --- rest -----------------------------------------------------------------------------------

    def _rotor_speed(self, world: World, times: Array) -> Array | None:
        """Speeds of all rotors; None: those of no robot were recorded."""
        names = [rotor.name for rotor in world.compiled.rotors]
        speeds = np.zeros((len(times), len(names)))
        known = False
        for robot in self._map.robots:
            rotors = robot.rotors
            if rotors is None or not self._there(rotors.columns):
                continue
            known = True
            there = world.rotors(robot.name)
            if unknown := [name for name in rotors.names if name not in there]:
                raise InputError(
                    f"{self._map.file}: {rotors.columns.place}: no rotor `{unknown[0]}` in the "
                    f"model; there are: {', '.join(there)}"
                )
            most = dict(zip(there, world.greatest_speeds(robot.name), strict=True))
            values = motion.held(self._samples(rotors.columns), times)
            limits = np.array([most[name] for name in rotors.names])
            found = rotors.law.speeds(values, rotors.columns.factor, limits)
            places = [names.index(f"{robot.name}.{name}") for name in rotors.names]
            speeds[:, places] = found
        return speeds if known else None

    def _add_goal(self, made: Imported, robot: Robot, times: Array, body: int, head: str) -> None:
        """The goal of a robot, and its distance, whose name begins with `head`."""
        if robot.goal is None or not self._there(robot.goal) or made.bodies is None:
            return
        place = robot.goal.factor * motion.held(self._samples(robot.goal, may_be_nan=True), times)
        yaw = np.zeros((len(times), 1))
        if robot.goal_yaw is not None and self._there(robot.goal_yaw):
            samples = self._samples(robot.goal_yaw, may_be_nan=True)
            yaw = robot.goal_yaw.factor * motion.held(samples, times)
        if self._ned:
            place, yaw = place * FLIP, -yaw
        made.goals[made.world.bodies[body]] = np.concatenate([place, yaw], axis=1)
        distance = np.linalg.norm(made.bodies[:, body, :3] - place, axis=1)
        made.info[f"{head}position_error"] = (distance, "m")

    def _add_sensors(self, made: Imported, times: Array) -> None:
        """The sensors of the map, by the name of each value."""
        for name, columns in self._map.sensors.items():
            if not self._there(columns):
                continue
            samples = self._samples(columns, may_be_nan=True)
            values = columns.factor * motion.held(samples, times)
            if columns.axes and self._ned and values.shape[1] == 3:
                values = values * FLIP
            for k, value in enumerate(values.T):
                whole = name if len(columns.names) == 1 else f"{name}[{k}]"
                made.sensors[whole] = (value, columns.unit)


def build(channels: Channels, used: Map, name: str, first: float, last: float) -> Imported:
    """Makes a flight of the columns of a log; as Builder.build()."""
    return Builder(channels, used).build(name, first, last)
