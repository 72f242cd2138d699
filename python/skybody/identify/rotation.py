"""Quaternions w x y z of many rows: products, and rotations as vectors."""

from __future__ import annotations

import numpy as np

from skybody.look.flight import Array


def product(a: Array, b: Array) -> Array:
    """Products of quaternions, (..., 4)."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def inverse(a: Array) -> Array:
    """Inverses of unit quaternions."""
    return np.asarray(a * np.array([1.0, -1.0, -1.0, -1.0]))


def of_vector(vector: Array) -> Array:
    """Quaternions of rotation vectors [rad], (..., 3)."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    half = 0.5 * angle
    factor = 0.5 * np.sinc(half / np.pi)
    return np.concatenate([np.cos(half), factor * vector], axis=-1)


def vector_of(a: Array) -> Array:
    """Rotation vectors [rad] of unit quaternions, up to pi."""
    signed = np.where(a[..., :1] < 0.0, -a, a)
    sine = np.linalg.norm(signed[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, signed[..., :1])
    return np.asarray(
        np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0) * signed[..., 1:]
    )


def into_body(a: Array, vectors: Array) -> Array:
    """Vectors of W in axes of B, with a from B to W."""
    w, v = a[..., :1], a[..., 1:]
    cross = np.cross(v, vectors)
    return vectors - 2.0 * w * cross + 2.0 * np.cross(v, cross)
