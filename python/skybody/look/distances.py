"""Distances of points from the surfaces of shapes."""

from __future__ import annotations

import numpy as np

from .motion import Array
from .shapes import BOX, CAPSULE, CYLINDER, GROUND, SPHERE, Block


def surface_distances(shapes: Block, k: int, points: Array) -> Array:
    """Distance of points (n, 3), W [m], from shape k; below 0 inside; of a mesh infinite."""
    kind, half = int(shapes.kinds[k]), shapes.halves[k]
    local = (points - shapes.positions[k]) @ shapes.axes[k]
    around = np.hypot(local[:, 0], local[:, 1])
    if kind == BOX:
        return beyond(np.abs(local) - half)
    if kind == SPHERE:
        return np.asarray(np.linalg.norm(local, axis=1) - half[0])
    if kind == CYLINDER:
        return beyond(np.stack([around - half[0], np.abs(local[:, 2]) - half[2]], axis=1))
    if kind == CAPSULE:
        above = np.maximum(np.abs(local[:, 2]) - half[2], 0.0)
        return np.asarray(np.hypot(around, above) - half[0])
    return np.asarray(local[:, 2]) if kind == GROUND else np.full(len(points), np.inf)


def beyond(outside: Array) -> Array:
    """Distance from a product of intervals, given how far each coordinate is outside of its own."""
    far = np.linalg.norm(np.maximum(outside, 0.0), axis=1)
    return np.asarray(far + np.minimum(outside.max(axis=1), 0.0))
