"""Axes of ROS and of PX4 against ours.

Ours and ROS (REP 103): world with z up, body x forward, y left, z up; quaternions are w x y z
here and x y z w in messages. PX4: world north, east, down, where W's x axis is north, and body
forward, right, down.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skybody.exports.frames import FLIP

Reals = NDArray[np.float64]


def flipped(vector: ArrayLike) -> Reals:
    """A vector from PX4's axes to ours, of the world or of the body; also the reverse."""
    return np.asarray(np.asarray(vector, np.float64) * FLIP)


def yaw_of(quaternion: ArrayLike) -> float:
    """Heading of a quaternion w x y z about W's z axis [rad]."""
    w, x, y, z = np.asarray(quaternion, np.float64)
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
