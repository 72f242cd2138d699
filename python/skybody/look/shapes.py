"""Shapes and lines in the world, as the renderer takes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skybody._native import Mesh, Renderer, Sky

from .lines import Lines
from .motion import Array

BOX, SPHERE, CYLINDER, CAPSULE, GROUND, MESH = range(6)
IDENTITY = np.eye(3)
UP = IDENTITY[2]
SKY = Sky(
    sun=np.array([-0.48, -0.36, 0.8]),
    direct=0.60,
    ambient=0.50,
    zenith=(0.56, 0.72, 0.89),
    horizon=(0.92, 0.94, 0.96),
    haze=70.0,
)

Color = tuple[float, float, float]


@dataclass(frozen=True)
class Block:
    """n shapes as arrays, one row a shape; Renderer.draw() describes them."""

    kinds: NDArray[np.int32]
    positions: Array
    axes: Array
    halves: Array
    colors: NDArray[np.float32]
    checkers: NDArray[np.float32]
    squares: NDArray[np.float32]
    shadows: NDArray[np.uint8]
    meshes: list[Mesh | None]

    @staticmethod
    def of(
        kinds: ArrayLike,
        positions: Array,
        axes: ArrayLike,
        halves: ArrayLike,
        colors: ArrayLike,
        *,
        shadow: bool = True,
        meshes: Sequence[Mesh | None] | None = None,
        checkers: Sequence[tuple[Color, float] | None] = (),
    ) -> Block:
        """Shapes of equal or different kinds; a value that is given once holds for all.

        Args:
            positions, axes: of their frames, W [m], (n, 3), and W from them, (n, 3, 3).
            halves: half the edges of a box; radius in x and half the length in z [m].
            shadow: whether they cast one.
            checkers: colour and edge [m] of every other square of planes.
        """
        n = len(positions)
        paints = np.broadcast_to(np.asarray(colors, np.float32), (n, 3))
        others, squares = paints.copy(), np.zeros(n, np.float32)
        for k, checker in enumerate(checkers):
            if checker is not None:
                others[k], squares[k] = checker
        return Block(
            np.broadcast_to(np.asarray(kinds, np.int32), n),
            np.asarray(positions, np.float64),
            np.broadcast_to(np.asarray(axes, np.float64), (n, 3, 3)),
            np.broadcast_to(np.asarray(halves, np.float64), (n, 3)),
            paints,
            others,
            squares,
            np.full(n, shadow, np.uint8),
            list(meshes) if meshes is not None else [None] * n,
        )

    def at(self, positions: Array, axes: Array) -> Block:
        """The same shapes elsewhere."""
        return Block(**{**self._parts(), "positions": positions, "axes": axes})

    def _parts(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}


class Shapes:
    """A growing list of shapes and lines."""

    def __init__(self) -> None:
        self._blocks: list[Block] = []
        self.lines = Lines()

    def add(self, *blocks: Block) -> None:
        """Adds shapes."""
        self._blocks += blocks

    def __len__(self) -> int:
        return sum(len(block.kinds) for block in self._blocks)

    def draw(self, renderer: Renderer, eye: Array, axes: Array, rgb: NDArray[np.uint8]) -> None:
        """Draws a picture.

        Args:
            eye, axes: position of the camera, W [m], and W from right, down, forward.
            rgb: the result (height, width, 3).
        """

        def joined(name: str) -> NDArray[Any]:
            return np.concatenate([getattr(block, name) for block in self._blocks])

        renderer.draw(
            eye,
            np.ascontiguousarray(axes),
            joined("kinds"),
            joined("positions"),
            joined("axes"),
            joined("halves"),
            joined("colors"),
            joined("checkers"),
            joined("squares"),
            joined("shadows"),
            [mesh for block in self._blocks for mesh in block.meshes],
            *self.lines.arrays(renderer.height),
            SKY,
            rgb,
        )


def tubes(
    starts: Array, ends: Array, radius: ArrayLike, color: ArrayLike, *, shadow: bool = True
) -> Block:
    """Capsules between points (n, 3), W [m]."""
    along = ends - starts
    length = np.linalg.norm(along, axis=-1)
    is_known = (length > 0.0)[:, None]
    axes = towards(np.where(is_known, along, UP) / np.where(is_known, length[:, None], 1.0))
    radii = np.broadcast_to(np.asarray(radius, np.float64), len(starts))
    halves = np.stack([radii, radii, 0.5 * length], axis=-1)
    return Block.of(CAPSULE, 0.5 * (starts + ends), axes, halves, color, shadow=shadow)


def towards(z: Array) -> Array:
    """Rotations whose third columns are unit vectors (..., 3), (..., 3, 3)."""
    aside = np.where(np.abs(z[..., :1]) < 0.9, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    x = np.cross(aside, z)
    x = x / np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=-1)


def spins(angles: Array) -> Array:
    """Rotations about z by some angles [rad], (n, 3, 3)."""
    c, s = np.cos(angles), np.sin(angles)
    zero, one = np.zeros_like(c), np.ones_like(c)
    rows = [[c, -s, zero], [s, c, zero], [zero, zero, one]]
    return np.moveaxis(np.array(rows), -1, 0)
