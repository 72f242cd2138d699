"""Frames and names of frames in other programs."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from skybody.look.flight import Array, rotation_of

WORLD = "world"  # frame of W
CAMERA = "camera"  # frame of images
# From (x, y, z) with z up, or y left, to (x, -y, -z): W to NED (W's x is north), B to FRD.
FLIP = np.array([1.0, -1.0, -1.0])
FLIP_QUATERNION = np.array([1.0, 1.0, -1.0, -1.0])  # w x y z, for both frames at once


def frame_of(body: str) -> str:
    """Frame of a body ROBOT.LINK: ROBOT/LINK."""
    return body.replace(".", "/", 1)


def topic_of(*names: str) -> str:
    """A topic that ROS 2 accepts: words of letters, digits and `_` behind slashes."""
    words = [word for name in names for word in re.split(r"[./]", name)]
    clean = [re.sub(r"\W", "_", word, flags=re.ASCII) or "_" for word in words]
    return "/" + "/".join(f"_{word}" if word[0].isdigit() else word for word in clean)


def quaternion_of(axes: Array) -> Array:
    """Quaternion w x y z with w >= 0 of a rotation matrix (3, 3)."""
    trace = np.trace(axes)
    # 4 times the squares of w, x, y, z; the greatest one is at least 1, a safe divisor.
    squares = np.array([1.0 + trace, *(1.0 - trace + 2.0 * np.diag(axes))])
    k = int(np.argmax(squares))
    found = np.empty(4)
    turn = [axes[2, 1] - axes[1, 2], axes[0, 2] - axes[2, 0], axes[1, 0] - axes[0, 1]]
    if k == 0:
        found[1:] = turn
    else:
        found[0] = turn[k - 1]
        found[1:] = (axes + axes.T)[k - 1]
    found[k] = squares[k]
    found /= np.linalg.norm(found)
    return -found if found[0] < 0.0 else found


def finite(values: Array) -> NDArray[np.bool_]:
    """Whether all numbers along the last axis are finite."""
    return np.asarray(np.isfinite(values).all(axis=-1))


def to_body(quaternions: Array, vectors: Array) -> Array:
    """Vectors with components in W as components in B.

    Args:
        quaternions: w x y z, W from B, (..., 4).
        vectors: (..., 3).
    """
    return np.asarray(np.einsum("...ji,...j->...i", rotation_of(quaternions), vectors))


def goal_quaternions(yaw: Array) -> Array:
    """Quaternions w x y z (rows, 4) of rotations about z by angles (rows,) [rad]."""
    zero = np.zeros_like(yaw)
    return np.stack([np.cos(0.5 * yaw), zero, zero, np.sin(0.5 * yaw)], axis=-1)
