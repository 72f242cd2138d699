"""ArduPilot's JSON interface: packets of servo values in, lines of JSON out. Pure functions."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np

from .frames import Array, to_frd, to_ned, to_ned_from_frd
from .vehicle import Reading

HEAD = struct.Struct("<HHI")  # magic, frame rate [Hz], frame count
CHANNELS = {18458: 16, 29569: 32}  # by magic
PULSE_LOW, PULSE_HIGH = 1000.0, 2000.0  # of a motor, for the shares 0 and 1 [us]
LARGEST_PACKET = HEAD.size + 2 * 32


@dataclass(frozen=True)
class Servos:
    """A packet of servo values."""

    frame_rate: int  # wanted physics steps [Hz]
    frame_count: int
    pulses: tuple[int, ...]  # (16,) or (32,) [us]; 0: no output


def decode(packet: bytes) -> Servos:
    """A packet of ArduPilot.

    Raises:
        ValueError: it is no such packet.
    """
    if len(packet) < HEAD.size:
        raise ValueError(f"a packet has {len(packet)} bytes; ArduPilot's have 40 or 72")
    magic, frame_rate, frame_count = HEAD.unpack_from(packet)
    channels = CHANNELS.get(magic)
    if channels is None:
        raise ValueError(f"a packet begins with {magic}; ArduPilot's magics are 18458 and 29569")
    size = HEAD.size + 2 * channels
    if len(packet) != size:
        raise ValueError(f"a packet with magic {magic} has {len(packet)} bytes; it needs {size}")
    return Servos(frame_rate, frame_count, struct.unpack_from(f"<{channels}H", packet, HEAD.size))


def encode(servos: Servos) -> bytes:
    """The packet of servo values; the magic follows from their number."""
    magic = next(m for m, channels in CHANNELS.items() if channels == len(servos.pulses))
    head = HEAD.pack(magic, servos.frame_rate, servos.frame_count)
    return head + struct.pack(f"<{len(servos.pulses)}H", *servos.pulses)


def throttles(pulses: tuple[int, ...], motors: int) -> Array:
    """Shares in [0, 1] of the greatest speed that the first pulses mean; 0 for no output."""
    values = np.asarray(pulses[:motors], np.float64)
    return np.clip((values - PULSE_LOW) / (PULSE_HIGH - PULSE_LOW), 0.0, 1.0)


def reply(reading: Reading, more: dict[str, Any]) -> bytes:
    """The line of JSON about the vehicle, between two ends of lines.

    Args:
        more: optional fields, such as rng_1 [m] and battery (voltage [V], current [A]).
    """
    fields = {
        "timestamp": reading.time,
        "imu": {
            "gyro": to_frd(reading.angular_rate).tolist(),
            "accel_body": to_frd(reading.specific_force).tolist(),
        },
        "position": to_ned(reading.position).tolist(),
        "quaternion": to_ned_from_frd(reading.rotation).tolist(),
        "velocity": to_ned(reading.velocity).tolist(),
        **more,
    }
    return f"\n{json.dumps(fields, separators=(',', ':'))}\n".encode()
