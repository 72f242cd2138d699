"""Motion between and at samples: interpolation, derivatives, rotations."""

from __future__ import annotations

import numpy as np

from skybody import InputError
from skybody.look.motion import Array, continuous, rotation_of

from .channels import Samples

ORDER = 2  # of the polynomials of derivatives
LEAST_ROWS = 5  # in the window of a derivative
BLOCK_ROWS = 4096  # of derivatives that are made at once: a window takes memory for each row


def at(samples: Samples, times: Array) -> Array:
    """Values at times, linear between samples, held at the ends; (times, columns)."""
    if np.array_equal(samples.time, times):
        return samples.values
    columns = [np.interp(times, samples.time, column) for column in samples.values.T]
    return np.stack(columns, axis=1)


def held(samples: Samples, times: Array) -> Array:
    """Values at times: those of the last sample before; (times, columns)."""
    rows = np.searchsorted(samples.time, times, side="right") - 1
    return np.asarray(samples.values[np.clip(rows, 0, None)])


def quaternions_at(samples: Samples, times: Array) -> Array:
    """Unit quaternions w x y z at times, (times, 4); neighbours have near signs."""
    return normalized(at(Samples(samples.time, continuous(samples.values)), times))


def normalized(quaternions: Array) -> Array:
    """Quaternions of norm 1."""
    return np.asarray(quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True))


def check_norms(quaternions: Array, place: str) -> None:
    """Raises InputError if quaternions are far from norm 1."""
    norms = np.linalg.norm(quaternions, axis=1)
    wrong = np.abs(norms - 1.0) > 0.05
    if wrong.any():
        row = int(np.argmax(wrong))
        raise InputError(
            f"{place}: quaternion {row + 1} has norm {norms[row]:.3g}; allowed: 1 within 5 %; the "
            "columns may be others"
        )


def quaternions_of_angles(angles: Array) -> Array:
    """Quaternions w x y z of roll, pitch and yaw (z-y'-x'') [rad], (rows, 3)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(0.5 * angles.T), np.sin(0.5 * angles.T)
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        axis=1,
    )


def derivative(time: Array, values: Array, window: float) -> Array:
    """Derivatives by parabolas through the samples of a window, least squares.

    Savitzky and Golay's filter, also for times that are not equally far apart, and at the ends.

    Args:
        time: increasing [s], (rows,).
        values: (rows, columns).
        window: [s]; at least 5 rows, or all if there are fewer.
    """
    rows = len(time)
    if rows < 2:
        return np.zeros_like(values)
    step = float(np.median(np.diff(time)))
    width = min(max(LEAST_ROWS, round(window / step) | 1), rows)
    slopes = np.empty_like(values)
    for begin in range(0, rows, BLOCK_ROWS):
        some = np.arange(begin, min(begin + BLOCK_ROWS, rows))
        first = np.clip(some - width // 2, 0, rows - width)
        places = first[:, None] + np.arange(width)
        from_here = (time[places] - time[some, None]) / (step * width)  # about 1
        powers = from_here[:, :, None] ** np.arange(min(ORDER, width - 1) + 1)
        fitted = np.linalg.pinv(powers) @ values[places]  # (rows, powers, columns)
        slopes[some] = fitted[:, 1] / (step * width)
    return slopes


def angular_velocities(time: Array, quaternions: Array, window: float) -> Array:
    """Angular velocities (B) [rad/s] of unit quaternions whose signs do not jump, (rows, 3)."""
    w, x, y, z = quaternions.T
    dw, dx, dy, dz = derivative(time, quaternions, window).T
    # 2 times the vector of the conjugate quaternion by its derivative.
    return 2.0 * np.stack(
        [
            w * dx - x * dw - y * dz + z * dy,
            w * dy + x * dz - y * dw - z * dx,
            w * dz - x * dy + y * dx - z * dw,
        ],
        axis=1,
    )


def to_world(quaternions: Array, vectors: Array) -> Array:
    """Vectors with components in B as components in W, (rows, 3)."""
    return np.asarray(np.einsum("nij,nj->ni", rotation_of(quaternions), vectors))
