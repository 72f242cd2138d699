"""Shapes in the world, as the renderer takes them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from skybody._native import Mesh, Renderer

from .flight import Array

BOX, SPHERE, CYLINDER, CAPSULE, GROUND, MESH = range(6)
IDENTITY = np.eye(3)
SUN = np.array([-0.48, -0.36, 0.8])

Color = tuple[float, float, float]


@dataclass
class Shapes:
    """A growing list of shapes, as the renderer takes it."""

    kinds: list[int] = field(default_factory=list)
    positions: list[Array] = field(default_factory=list)
    axes: list[Array] = field(default_factory=list)
    halves: list[tuple[float, float, float]] = field(default_factory=list)
    colors: list[Color] = field(default_factory=list)
    checkers: list[Color] = field(default_factory=list)
    squares: list[float] = field(default_factory=list)
    shadows: list[bool] = field(default_factory=list)
    meshes: list[object] = field(default_factory=list)  # Mesh or None

    def add(
        self,
        kind: int,
        position: Array,
        axes: Array,
        half: tuple[float, float, float],
        color: Color,
        *,
        shadow: bool = True,
        mesh: Mesh | None = None,
        checker: tuple[Color, float] | None = None,
    ) -> None:
        """Adds a shape.

        Args:
            position, axes: of its frame, W [m], and W from it.
            half: half the edges of a box; radius in x and half the length in z [m].
            shadow: whether it casts one.
            checker: colour and edge [m] of every other square of the ground.
        """
        self.kinds.append(kind)
        self.positions.append(position)
        self.axes.append(axes)
        self.halves.append(half)
        self.colors.append(color)
        self.checkers.append(checker[0] if checker else color)
        self.squares.append(checker[1] if checker else 0.0)
        self.shadows.append(shadow)
        self.meshes.append(mesh)

    def add_line(
        self, start: Array, end: Array, radius: float, color: Color, *, shadow: bool
    ) -> None:
        """Adds a capsule from point to point, W [m]."""
        along = end - start
        length = float(np.linalg.norm(along))
        axes = towards(along / length) if length > 0.0 else IDENTITY
        half = (radius, radius, 0.5 * length)
        self.add(CAPSULE, 0.5 * (start + end), axes, half, color, shadow=shadow)

    def __len__(self) -> int:
        return len(self.kinds)

    def draw(self, renderer: Renderer, eye: Array, axes: Array, rgb: NDArray[np.uint8]) -> None:
        """Draws a picture.

        Args:
            eye, axes: position of the camera, W [m], and W from right, down, forward.
            rgb: the result (height, width, 3).
        """
        renderer.draw(
            eye,
            np.ascontiguousarray(axes),
            np.array(self.kinds, np.int32),
            np.array(self.positions).reshape(-1, 3),
            np.array(self.axes).reshape(-1, 3, 3),
            np.array(self.halves, np.float64).reshape(-1, 3),
            np.array(self.colors, np.float32).reshape(-1, 3),
            np.array(self.checkers, np.float32).reshape(-1, 3),
            np.array(self.squares, np.float32),
            np.array(self.shadows, np.uint8),
            self.meshes,
            SUN,
            rgb,
        )


def towards(z: Array) -> Array:
    """A rotation whose third column is a unit vector."""
    aside = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = np.cross(aside, z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])
