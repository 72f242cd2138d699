"""Packets of `skybody onboard`: little-endian, a header of 24 bytes, then the content.

docs/onboard.md has the table; onboard/packets.h has the same structures in C++.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

MAGIC, VERSION = b"SKYB", 1
STATE, IMU, PARAM, CONTROL, COMMAND = 1, 2, 3, 4, 16
WAITING, POLICY, SAFE, STOPPED = range(4)  # of Command.mode
REASONS = ("stale", "tilt", "fence", "bad observation", "bad command", "late", "disengaged")
BASE = -1  # of state(): the base of the vehicle

_HEADER = struct.Struct("<4sBBHIId")
_COMMAND = struct.Struct("<IIIHH")


def _packet(kind: int, sequence: int, stamp: float, content: bytes) -> bytes:
    size = _HEADER.size + len(content)
    return _HEADER.pack(MAGIC, VERSION, kind, size, sequence % 2**32, 0, stamp) + content


def state(
    sequence: int,
    stamp: float,
    position: ArrayLike,
    rotation: ArrayLike,
    velocity: ArrayLike,
    angular_velocity: ArrayLike,
    body: int = BASE,
) -> bytes:
    """Pose and twist of a body.

    Args:
        sequence: number of the packet.
        stamp: of the sender's clock [s]; greater than that of the packet before.
        position: (3,) world, z up [m].
        rotation: (4,) quaternion w x y z, world from body.
        velocity: (3,) world [m/s].
        angular_velocity: (3,) body, x forward, y left, z up [rad/s].
        body: world body index; BASE: the vehicle's base.
    """
    values = np.concatenate(
        [np.asarray(v, "<f8") for v in (position, rotation, velocity, angular_velocity)]
    )
    return _packet(STATE, sequence, stamp, struct.pack("<iI", body, 0) + values.tobytes())


def imu(
    sequence: int, stamp: float, specific_force: ArrayLike, angular_velocity: ArrayLike
) -> bytes:
    """Measurements of an IMU, both (3,) in body axes [m/s^2], [rad/s]."""
    values = np.concatenate([specific_force, angular_velocity]).astype("<f8")
    return _packet(IMU, sequence, stamp, values.tobytes())


def param(sequence: int, path: str, values: Sequence[float]) -> bytes:
    """Values of the task from a path on, such as `task.target`; at most 8.

    Raises:
        ValueError: too many values, or a path of more than 63 bytes.
    """
    name = path.encode()
    if len(name) > 63 or not 1 <= len(values) <= 8:
        raise ValueError(f"{path}: up to 8 values, and a path of up to 63 bytes")
    numbers = np.zeros(8, "<f8")
    numbers[: len(values)] = values
    content = name.ljust(64, b"\0") + struct.pack("<II", len(values), 0) + numbers.tobytes()
    return _packet(PARAM, sequence, 0.0, content)


def control(sequence: int, engage: bool) -> bytes:
    """Lets the policy take over with the next pose, or switches to the safe command."""
    return _packet(CONTROL, sequence, 0.0, struct.pack("<II", int(engage), 0))


@dataclass(frozen=True)
class Command:
    """An answer of the program."""

    sequence: int
    stamp: float  # of the pose that it answers
    mode: int  # WAITING, POLICY, SAFE, STOPPED
    reasons: tuple[str, ...]  # for the safe command, of REASONS
    signal: int  # SkybodySignal (core/plugin_abi/signals.h)
    action: NDArray[np.float32]  # (A,) in [-1, 1]
    command: NDArray[np.float64]  # in physical units


def read_command(packet: bytes) -> Command:
    """Reads an answer.

    Raises:
        ValueError: it is none.
    """
    if len(packet) < _HEADER.size + _COMMAND.size:
        raise ValueError(f"an answer of {len(packet)} bytes")
    magic, version, kind, size, sequence, _, stamp = _HEADER.unpack_from(packet)
    mode, reasons, signal, actions, commands = _COMMAND.unpack_from(packet, _HEADER.size)
    first = _HEADER.size + _COMMAND.size
    second = first + 4 * (actions + actions % 2)
    if (magic, version, kind) != (MAGIC, VERSION, COMMAND) or size != second + 8 * commands:
        raise ValueError("a packet that is no answer")
    return Command(
        sequence,
        stamp,
        mode,
        tuple(name for k, name in enumerate(REASONS) if reasons >> k & 1),
        signal,
        np.frombuffer(packet, "<f4", actions, first),
        np.frombuffer(packet, "<f8", commands, second),
    )
