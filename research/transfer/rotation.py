"""Rotations of many bodies at once: quaternions w x y z (N, 4), matrices W from B (N, 3, 3).

NumPy alone: programs in the environments of other simulators import it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]


def product(p: Reals, q: Reals) -> Reals:
    """Quaternion p q."""
    pw, px, py, pz = np.moveaxis(p, -1, 0)
    qw, qx, qy, qz = np.moveaxis(q, -1, 0)
    return np.stack(
        [
            pw * qw - px * qx - py * qy - pz * qz,
            pw * qx + px * qw + py * qz - pz * qy,
            pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw,
        ],
        -1,
    )


def of_vector(turn: Reals) -> Reals:
    """Quaternion of a rotation vector (N, 3) [rad]."""
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    factor = 0.5 * np.sinc(angle / (2.0 * np.pi))
    return np.concatenate([np.cos(0.5 * angle), factor * turn], -1)


def matrix(q: Reals) -> Reals:
    """Matrix of a unit quaternion."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def tilted(up: Reals, yaw: Reals) -> Reals:
    """Quaternion of the heading `yaw` (N), then the shortest turn of z to `up` (N, 3)."""
    tilt = np.stack([1.0 + up[..., 2], -up[..., 1], up[..., 0], np.zeros_like(yaw)], -1)
    tilt /= np.linalg.norm(tilt, axis=-1, keepdims=True)
    nothing = np.zeros_like(yaw)
    heading = np.stack([np.cos(0.5 * yaw), nothing, nothing, np.sin(0.5 * yaw)], -1)
    return product(tilt, heading)


def of_matrix(r: Reals) -> Reals:
    """Unit quaternion, up to its sign: the largest column of q q^T, linear in the matrix."""
    w = np.array(
        [r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]]
    )
    square = np.empty((*r.shape[:-2], 4, 4))
    square[..., 0, 0] = 1.0 + np.trace(r, axis1=-2, axis2=-1)
    square[..., 0, 1:] = square[..., 1:, 0] = np.moveaxis(w, 0, -1)
    square[..., 1:, 1:] = r + np.swapaxes(r, -1, -2)
    rest = 1.0 - np.trace(r, axis1=-2, axis2=-1)
    square[..., 1:, 1:] += rest[..., None, None] * np.eye(3)
    largest = np.argmax(np.diagonal(square, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(square, largest[..., None, None], -1)[..., 0]
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))
