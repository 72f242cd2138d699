"""Attitudes of flights without poses: by the gyroscope, levelled by the accelerometer."""

from __future__ import annotations

import numpy as np

from skybody.imports.channels import Samples
from skybody.look.flight import Array

from . import rotation
from .record import Mean, Record
from .screening import good_at

LEVEL = 8.0  # time over which the accelerations of a flight cancel, nearly [s]


def attitudes(record: Record) -> Samples:
    """Attitudes, W from B, of a flight with a gyroscope; the direction of north is arbitrary.

    Without an accelerometer they are relative to the first one.
    """
    found = integrated(record)
    return found if record.force is None else levelled(record, found)


def integrated(record: Record) -> Samples:
    """Attitudes by the gyroscope alone, from none at the start."""
    assert record.gyro is not None
    return Samples(record.gyro.time, turned(record.gyro.time, record.gyro.values))


def turned(time: Array, rates: Array) -> Array:
    """Attitudes since the first row by body rates [rad/s], quaternions w x y z, (rows, 4)."""
    steps = np.diff(time)[:, None] * 0.5 * (rates[1:] + rates[:-1])
    found = np.empty((len(time), 4))
    found[0] = (1.0, 0.0, 0.0, 0.0)
    for row, turn in enumerate(rotation.of_vector(steps)):
        found[row + 1] = rotation.product(found[row], turn)
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))


def levelled(record: Record, attitude: Samples) -> Samples:
    """The same attitudes with the mean specific force of LEVEL upwards.

    In the mean over some seconds a flight does not accelerate: its specific force is that against
    gravity.
    """
    assert record.force is not None
    time, turns = attitude.time, attitude.values
    force = Mean(record.force).at(time)
    good = good_at(record, time)[:, None].astype(float)
    push = np.where(good > 0.0, into_world(turns, force), 0.0)
    sums = Mean(Samples(time, np.concatenate([push, good], axis=1)))
    mean = sums(time - 0.5 * LEVEL, LEVEL)[:, :3]
    size = np.linalg.norm(mean, axis=1, keepdims=True)
    up = np.where(size > 1e-9, mean / np.maximum(size, 1e-9), (0.0, 0.0, 1.0))
    # The shortest turn of `up` to z.
    half = np.stack([1.0 + up[:, 2], up[:, 1], -up[:, 0], np.zeros(len(up))], axis=1)
    half[:, 0] = np.maximum(half[:, 0], 1e-6)
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    return Samples(time, rotation.product(half, turns))


def into_world(turns: Array, vectors: Array) -> Array:
    """Vectors of B in W."""
    return rotation.into_body(rotation.inverse(turns), vectors)
