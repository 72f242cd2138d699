"""For tests of `skybody sitl`: an autopilot for attitude and height, and kept messages."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skybody.sitl.messages import Messages

Array = NDArray[np.float64]

# Roll, pitch (nose up) and yaw (clockwise) torque of each motor, in the order of ArduPilot and PX4:
# front right (ccw), back left (ccw), front left (cw), back right (cw).
MIX = np.array([[-1.0, 1, 1], [1, -1, 1], [1, 1, -1], [-1, -1, -1]])


class Kept(Messages):
    """Keeps messages instead of printing them."""

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = []

    def say(self, text: str) -> None:
        self.lines.append(text)

    def port(self) -> int:
        """The port of the link's first message, as soon as it is there."""
        while not self.lines:
            time.sleep(0.01)
        return int(self.lines[0].rpartition(":")[2])


@dataclass
class HoldPilot:
    """Holds level attitude, heading and a height, from values in NED and FRD."""

    hover: float  # thrust of hover as a share of the greatest one
    height: float  # [m]
    yaw_sign: float = 1.0  # -1: rotors of the frame x-reversed
    order: tuple[int, ...] = (0, 1, 2, 3)  # of the motors in the packet
    trim: float = 0.0  # thrust that the integral has added

    def throttles(self, quaternion: Array, rates: Array, height: float, climb: float) -> Array:
        """Shares of the greatest speed.

        Args:
            quaternion: w x y z, NED from FRD.
            rates: FRD [rad/s].
            height: [m], climb: [m/s], up.
        """
        w, x, y, _ = quaternion
        tilt = 2.0 * np.sign(w) * np.array([x, y, 0.0])  # small angles: roll, pitch
        turn = -0.15 * tilt - np.array([0.03, 0.03, 0.05]) * rates
        turn[2] *= self.yaw_sign
        error = float(np.clip(self.height - height, -0.5, 0.5))
        self.trim = float(np.clip(self.trim + 2e-5 * error, -0.1, 0.1))
        lift = self.hover * (1.0 + 0.2 * error - 0.25 * climb) + self.trim
        return np.sqrt(np.clip(lift + MIX @ turn, 0.0, 1.0))[list(self.order)]
