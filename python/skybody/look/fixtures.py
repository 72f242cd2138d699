"""Shapes fixed to bodies, or standing in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skybody._native import Mesh

from .motion import Array
from .shapes import CAPSULE, IDENTITY, Block, Color


@dataclass(frozen=True)
class Fixed:
    """A shape fixed to a body, or standing in the world."""

    kind: int
    body: int  # -1: the world
    position: Array
    axes: Array
    half: tuple[float, float, float]
    color: Color
    mesh: Mesh | None = None
    corners: Array | None = None  # of the mesh's triangles, (n, 3, 3), in the shape's frame [m]
    checker: tuple[Color, float] | None = None  # colour and edge [m] of other squares of a plane


class Fixtures:
    """Some such shapes as arrays."""

    def __init__(self, shapes: Sequence[Fixed], color: Color | None = None) -> None:
        """Prepares the arrays.

        Args:
            color: in place of their own.
        """
        self.bodies = np.array([shape.body for shape in shapes], np.intp)
        self.block = Block.of(
            np.array([shape.kind for shape in shapes], np.int32),
            np.array([shape.position for shape in shapes]).reshape(-1, 3),
            np.array([shape.axes for shape in shapes]).reshape(-1, 3, 3),
            np.array([shape.half for shape in shapes]).reshape(-1, 3),
            np.array([color or shape.color for shape in shapes]).reshape(-1, 3),
            meshes=[shape.mesh for shape in shapes],
            checkers=[None if color else shape.checker for shape in shapes],
        )

    def at(self, position: Array, axes: Array) -> Block:
        """The shapes at the poses of their bodies.

        Args:
            position, axes: of all bodies, W [m], and W from B.
        """
        places = np.concatenate([position, np.zeros((1, 3))])  # of the world, number -1
        turns = np.concatenate([axes, IDENTITY[None]])[self.bodies]
        offsets = (turns @ self.block.positions[..., None])[..., 0]
        return self.block.at(places[self.bodies] + offsets, turns @ self.block.axes)


def corners_of(shape: Fixed) -> Array:
    """Corners of a box about a shape in its frame: of a body, or W [m]."""
    if shape.corners is not None:
        flat = shape.corners.reshape(-1, 3)
        return np.asarray(shape.position + flat @ shape.axes.T)
    half = np.array(shape.half) + (shape.kind == CAPSULE) * np.array([0.0, 0.0, shape.half[0]])
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    return np.asarray(shape.position + (signs * half) @ shape.axes.T)
