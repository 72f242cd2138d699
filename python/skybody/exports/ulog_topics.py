"""PX4's topics of the rows of a flight, in NED and FRD."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from skybody.look.flight import Array, rotation_of

from .frames import FLIP, FLIP_QUATERNION, finite
from .sensors import batteries, imus
from .table import Block, Table

MICRO = 10**6
OUTPUTS = 16  # of PX4's actuator_outputs
Values = dict[str, Array]


@dataclass(frozen=True)
class Topic:
    """An instance of a topic of PX4."""

    name: str
    instance: int  # of the robot, goal or sensor
    fields: tuple[tuple[str, str, int], ...]  # type, name and number of values, behind the time
    values: Callable[[Block], Values]  # of each field, (rows,) or (rows, number)

    @property
    def definition(self) -> str:
        """Its name and fields, as ULog has them."""
        words = ["uint64_t timestamp"]
        words += [
            f"{kind}[{n}] {name}" if n > 1 else f"{kind} {name}" for kind, name, n in self.fields
        ]
        return f"{self.name}:{';'.join(words)};"


def floats(*names: str) -> tuple[tuple[str, str, int], ...]:
    """Fields of one number."""
    return tuple(("float", name, 1) for name in names)


POSITION = (
    *floats("x", "y", "z", "vx", "vy", "vz", "heading"),
    *(("bool", name, 1) for name in ("xy_valid", "z_valid", "v_xy_valid", "v_z_valid")),
)
GOAL = floats("x", "y", "z", "yaw")
ATTITUDE = (("float", "q", 4),)
RATES = (("float", "xyz", 3),)
BATTERY = floats("voltage_v", "current_a", "remaining")
IMU = (("float", "gyro_rad", 3), ("float", "accelerometer_m_s2", 3))


def topics_of(table: Table) -> list[Topic]:
    """All topics: of robots, goals, IMUs and batteries."""
    return [*of_robots(table), *of_goals(table), *of_sensors(table)]


def of_robots(table: Table) -> Iterator[Topic]:
    """The state of each robot's base, and its rotors."""
    columns = table.series["rotor_speed"].columns if "rotor_speed" in table.series else ()
    owners = [name.partition(".")[0] for name in columns]
    size = max([OUTPUTS, *(owners.count(robot) for robot in table.robots)])
    fields = (("uint32_t", "noutputs", 1), ("float", "output", size))
    for k, (robot, bodies) in enumerate(table.robots.items()):
        base = bodies[0]
        yield Topic("vehicle_local_position", k, POSITION, partial(position, body=base))
        yield Topic("vehicle_attitude", k, ATTITUDE, partial(attitude, body=base))
        yield Topic("vehicle_angular_velocity", k, RATES, partial(rates, body=base))
        if rotors := [j for j, owner in enumerate(owners) if owner == robot]:
            values = partial(outputs, rotors=rotors, size=size)
            yield Topic("actuator_outputs", k, fields, values)


def of_goals(table: Table) -> Iterator[Topic]:
    """The goals, in their order."""
    for k in range(len(table.series["goal"].items) if "goal" in table.series else 0):
        yield Topic("vehicle_local_position_setpoint", k, GOAL, partial(goal, number=k))


def of_sensors(table: Table) -> Iterator[Topic]:
    """IMUs and batteries, in their order."""
    for k, (force, rate) in enumerate(imus(table).values()):
        yield Topic("sensor_combined", k, IMU, partial(imu, force=force, rate=rate))
    for k, columns in enumerate(batteries(table)):
        yield Topic("battery_status", k, BATTERY, partial(battery, columns=columns))


# --- values -------------------------------------------------------------------------------------


def position(block: Block, body: int) -> Values:
    """Position and velocity, NED, and the angle of x from north towards east [rad]."""
    rows = block.real("bodies")[:, body]
    place, velocity = FLIP * rows[:, :3], FLIP * rows[:, 7:10]
    ahead = FLIP * rotation_of(rows[:, 3:7])[:, :, 0]
    named = {name: place[:, k] for k, name in enumerate(("x", "y", "z"))}
    named |= {name: velocity[:, k] for k, name in enumerate(("vx", "vy", "vz"))}
    named["heading"] = np.arctan2(ahead[:, 1], ahead[:, 0])
    known = finite(rows).astype(np.float64)
    return named | {name: known for kind, name, _ in POSITION if kind == "bool"}


def attitude(block: Block, body: int) -> Values:
    """Quaternion w x y z, NED from FRD."""
    return {"q": FLIP_QUATERNION * block.real("bodies")[:, body, 3:7]}


def rates(block: Block, body: int) -> Values:
    """Angular velocity, FRD [rad/s]."""
    return {"xyz": FLIP * block.real("bodies")[:, body, 10:13]}


def outputs(block: Block, rotors: Sequence[int], size: int) -> Values:
    """Rotor speeds [rad/s]."""
    speeds = np.zeros((len(block.time), size))
    speeds[:, : len(rotors)] = block.real("rotor_speed")[:, rotors]
    return {"noutputs": np.full(len(block.time), float(len(rotors))), "output": speeds}


def goal(block: Block, number: int) -> Values:
    """A goal, NED."""
    rows = block.real("goal")[:, number] * np.array([*FLIP, -1.0])
    return {name: rows[:, k] for k, (_, name, _) in enumerate(GOAL)}


def imu(block: Block, force: Sequence[int], rate: Sequence[int]) -> Values:
    """Angular rate [rad/s] and specific force [m/s^2], axes of the sensor turned as FRD."""
    rows = block.real("sensors")
    return {"gyro_rad": FLIP * rows[:, rate], "accelerometer_m_s2": FLIP * rows[:, force]}


def battery(block: Block, columns: dict[str, tuple[str, int]]) -> Values:
    """Voltage [V], current [A] and charge as a share of a full one; NaN: not known."""
    values = {name: np.full(len(block.time), np.nan) for _, name, _ in BATTERY}
    return values | {name: block.real(data)[:, k] for name, (data, k) in columns.items()}
