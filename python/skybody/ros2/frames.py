"""Axes of ROS and of PX4 against ours.

Ours and ROS (REP 103): world with z up, body x forward, y left, z up; quaternions are w x y z
here and x y z w in messages. PX4: world north, east, down and body forward, right, down (FRD);
W's x axis is taken as east and y as north (ENU).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Reals = NDArray[np.float64]
HALF = np.sqrt(0.5)
ENU_FROM_NED = np.array([0.0, HALF, HALF, 0.0])  # quaternion w x y z: a half turn about x = y


def flu_of_frd(vector: ArrayLike) -> Reals:
    """A vector in body axes, forward right down to forward left up, or back."""
    x, y, z = np.asarray(vector, np.float64)
    return np.array([x, -y, -z])


def enu_of_ned(vector: ArrayLike) -> Reals:
    """A vector in world axes, north east down to east north up, or back."""
    x, y, z = np.asarray(vector, np.float64)
    return np.array([y, x, -z])


def product(a: ArrayLike, b: ArrayLike) -> Reals:
    """Product of quaternions w x y z."""
    (aw, ax, ay, az), (bw, bx, by, bz) = np.asarray(a, np.float64), np.asarray(b, np.float64)
    return np.array(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ]
    )


def enu_flu_of_ned_frd(quaternion: ArrayLike) -> Reals:
    """World-from-body attitude w x y z of PX4's axes to ours, or back."""
    w, x, y, z = product(ENU_FROM_NED, quaternion)
    return product([w, x, y, z], [0.0, 1.0, 0.0, 0.0])  # a half turn about x: FRD from FLU


def yaw_of(quaternion: ArrayLike) -> float:
    """Heading of a quaternion w x y z about W's z axis [rad]."""
    w, x, y, z = np.asarray(quaternion, np.float64)
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def rotated_back(quaternion: ArrayLike, vector: ArrayLike) -> Reals:
    """A vector in W in the axes of a body, W from B by the quaternion w x y z."""
    w, x, y, z = np.asarray(quaternion, np.float64)
    turned = product(product([w, -x, -y, -z], [0.0, *np.asarray(vector, np.float64)]), [w, x, y, z])
    return turned[1:]
