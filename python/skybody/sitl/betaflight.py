"""Packets of Betaflight's SITL: state out, motors in, radio channels out. Pure functions."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

from .frames import Array, Home, to_enu, to_frd, to_ned_from_frd
from .vehicle import Reading

STATE = struct.Struct("<18d")
MOTORS = struct.Struct("<4f")
RADIO = struct.Struct("<d16H")
CHANNELS = 16
LOW, MIDDLE, HIGH = 1000, 1500, 2000  # of a channel [us]


def encode_state(reading: Reading, home: Home, stamp: float) -> bytes:
    """The state packet: time, rates, specific force, attitude, velocity, place, pressure.

    Rates are in FRD. The specific force has the opposite sign of B's, which Betaflight takes back.
    The attitude is NED from FRD, the velocity east, north, up, the place longitude, latitude and
    altitude.

    Args:
        stamp: time for Betaflight's clock [s].
    """
    latitude, longitude, altitude = home.place(reading.fix_position)
    return STATE.pack(
        stamp,
        *to_frd(reading.angular_rate),
        *-reading.specific_force,
        *to_ned_from_frd(reading.rotation),
        *to_enu(reading.fix_velocity),
        longitude,
        latitude,
        altitude,
        reading.pressure,
    )


def decode_motors(packet: bytes) -> Array:
    """The motor packet: shares of the greatest speed, Betaflight's motors 2, 3, 4 and 1.

    Raises:
        ValueError: it is no such packet.
    """
    if len(packet) != MOTORS.size:
        raise ValueError(f"a packet has {len(packet)} bytes; Betaflight's of motors have 16")
    return np.array(MOTORS.unpack(packet))


def encode_radio(time: float, channels: Sequence[float]) -> bytes:
    """The packet of radio channels: roll, pitch, throttle, yaw, then switches.

    Args:
        time: [s].
        channels: at most 16 [us], limited to 1000..2000; those that are left out are low.
    """
    values = [round(min(max(value, LOW), HIGH)) for value in channels]
    return RADIO.pack(time, *values, *[LOW] * (CHANNELS - len(values)))
