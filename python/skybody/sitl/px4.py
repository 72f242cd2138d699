"""PX4's simulator MAVLink: messages about the vehicle out, actuator controls in. Pure functions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from .frames import (
    MICROTESLA_PER_GAUSS,
    PASCAL_PER_HECTOPASCAL,
    Array,
    Home,
    course_over_ground,
    to_frd,
    to_ned,
    to_ned_from_frd,
)
from .vehicle import Reading

# Bits of HIL_SENSOR.fields_updated
IMU_FIELDS = 0b0_0000_0011_1111
FIELD_FIELDS = 0b0_0001_1100_0000
PRESSURE_FIELDS = 0b1_1010_0000_0000  # absolute pressure, altitude, temperature

ARMED = 128  # bit of HIL_ACTUATOR_CONTROLS.mode
LOCKSTEP = 1  # bit of HIL_ACTUATOR_CONTROLS.flags
FIX_3D = 3
SATELLITES = 12
DILUTION = (60, 80)  # eph and epv of HIL_GPS [cm]
ROOM_TEMPERATURE = 15.0  # [deg C]
STANDARD_GRAVITY = 9.80665  # [m/s^2]
SYSTEM, COMPONENT = 1, 51  # of the sender


def load_mavlink() -> Any:
    """pymavlink's module of MAVLink 2's common messages.

    Raises:
        ValueError: pymavlink is not installed.
    """
    try:
        from pymavlink.dialects.v20 import common
    except ModuleNotFoundError as error:
        raise ValueError(
            f"skybody sitl px4 needs the package `{error.name}`: `pip install pymavlink`"
        ) from None
    return common


@dataclass(frozen=True)
class Controls:
    """HIL_ACTUATOR_CONTROLS."""

    throttles: Array  # (motors,) in [0, 1]; 0 if disarmed
    armed: bool
    lockstep: bool
    bad: int  # values that were not finite


def controls_of(message: Any, motors: int) -> Controls:
    """The motor values of a message HIL_ACTUATOR_CONTROLS.

    A disarmed PX4 stops all motors; a value below 0 or not finite stops its motor.
    """
    armed = bool(message.mode & ARMED)
    values = np.asarray(message.controls[:motors], np.float64)
    finite = np.isfinite(values)
    throttles = np.clip(np.where(finite & armed, values, 0.0), 0.0, 1.0)
    bad = int(np.count_nonzero(~finite)) if armed else 0
    return Controls(throttles, armed, bool(message.flags & LOCKSTEP), bad)


class Encoder:
    """Encodes messages about one vehicle."""

    def __init__(self, mavlink: Any, home: Home) -> None:
        self._mavlink = mavlink
        self._home = home
        self._sender = mavlink.MAVLink(None, srcSystem=SYSTEM, srcComponent=COMPONENT)

    def sensor(self, reading: Reading, micros: int, fields: int) -> bytes:
        """HIL_SENSOR: FRD, m/s^2, rad/s, gauss, hPa, m, deg C.

        Args:
            micros: time stamp [us].
            fields: bits of the values that are new.
        """
        return self._packed(
            "hil_sensor",
            micros,
            *to_frd(reading.specific_force).tolist(),
            *to_frd(reading.angular_rate).tolist(),
            *(to_frd(reading.field) / MICROTESLA_PER_GAUSS).tolist(),
            reading.pressure / PASCAL_PER_HECTOPASCAL,
            0.0,
            reading.pressure_altitude,
            ROOM_TEMPERATURE,
            fields,
        )

    def fix(self, reading: Reading, micros: int) -> bytes:
        """HIL_GPS: 1e-7 deg, mm, cm/s, 0.01 deg."""
        latitude, longitude, altitude = self._home.place(reading.fix_position)
        north, east, down = to_ned(reading.fix_velocity).tolist()
        return self._packed(
            "hil_gps",
            micros,
            FIX_3D,
            round(latitude * 1e7),
            round(longitude * 1e7),
            round(altitude * 1e3),
            *DILUTION,
            held(100.0 * math.hypot(north, east), 0, 65535),
            *(held(100.0 * value) for value in (north, east, down)),
            held(100.0 * course_over_ground(reading.fix_velocity), 0, 35999),
            SATELLITES,
        )

    def truth(self, reading: Reading, micros: int) -> bytes:
        """HIL_STATE_QUATERNION: the true motion; 1e-7 deg, mm, cm/s, rad/s, mg."""
        latitude, longitude, altitude = self._home.place(reading.position)
        speed = held(100.0 * float(np.linalg.norm(reading.velocity)), 0, 65535)
        milli_g = to_frd(reading.specific_force) / STANDARD_GRAVITY * 1e3
        return self._packed(
            "hil_state_quaternion",
            micros,
            to_ned_from_frd(reading.rotation).tolist(),
            *to_frd(reading.turn_rate).tolist(),
            round(latitude * 1e7),
            round(longitude * 1e7),
            round(altitude * 1e3),
            *(held(100.0 * value) for value in to_ned(reading.velocity).tolist()),
            speed,
            speed,
            *(held(value) for value in milli_g.tolist()),
        )

    def heartbeat(self) -> bytes:
        """HEARTBEAT of a simulator."""
        names = self._mavlink
        return self._packed(
            "heartbeat", names.MAV_TYPE_GENERIC, names.MAV_AUTOPILOT_INVALID, 0, 0, 0
        )

    def system_time(self, micros: int) -> bytes:
        """SYSTEM_TIME: simulated time."""
        return self._packed("system_time", micros, micros // 1000)

    def _packed(self, name: str, *values: Any) -> bytes:
        message = getattr(self._sender, f"{name}_encode")(*values)
        packed: bytes = bytes(message.pack(self._sender))
        self._sender.seq = (self._sender.seq + 1) % 256
        return packed


class Decoder:
    """Finds messages HIL_ACTUATOR_CONTROLS in a stream of bytes."""

    def __init__(self, mavlink: Any) -> None:
        self._receiver = mavlink.MAVLink(None)
        self._receiver.robust_parsing = True
        self.bad = 0  # stretches of bytes that were no message

    def take(self, data: bytes) -> list[Any]:
        """The messages HIL_ACTUATOR_CONTROLS that these bytes complete, in order."""
        messages = self._receiver.parse_buffer(data) or []
        self.bad += sum(message.get_type() == "BAD_DATA" for message in messages)
        return [m for m in messages if m.get_type() == "HIL_ACTUATOR_CONTROLS"]


def held(value: float, low: int = -32768, high: int = 32767) -> int:
    """The nearest whole number within bounds."""
    return int(min(max(round(value), low), high))
