"""Rods, springs and ropes as they are drawn."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from skybody._native import Coupling

from .motion import Array, Motion
from .shapes import Block, Color, tubes

ROPE: Color = (0.13, 0.13, 0.14)
RADIUS = 0.006  # of rods and ropes [m]
PARTS = 16  # of a slack rope
HALVINGS = 30  # of the interval in which a rope's sag is looked for


class Couplings:
    """The couplings that an episode has."""

    def __init__(self, motion: Motion, color: Color | None = None) -> None:
        """Looks them up.

        Args:
            color: in place of their own.
        """
        self._found = [c for c in motion.compiled.couplings if is_drawn(motion, c)]
        self.names = [c.name for c in self._found]
        self._bodies = np.array([c.bodies for c in self._found], np.intp).reshape(-1, 2)
        self._points = np.array([c.points for c in self._found]).reshape(-1, 2, 3)
        lengths = [motion.drawn.get(f"couplings.{name}.length", 0.0) for name in self.names]
        is_rope = np.array([c.kind == "rope" for c in self._found], bool)
        self._lengths = np.where(is_rope, np.array(lengths, np.float64), 0.0)
        self._color = color or ROPE

    def lines(self, position: Array, axes: Array) -> list[Array]:
        """Points of each coupling, W [m].

        Args:
            position, axes: of all bodies, W [m], and W from B.
        """
        position = np.concatenate([position, np.zeros((1, 3))])  # of the world, number -1
        axes = np.concatenate([axes, np.eye(3)[None]])
        turned = (axes[self._bodies] @ self._points[..., None])[..., 0]
        ends = position[self._bodies] + turned
        return hanging(ends[:, 0], ends[:, 1], self._lengths)

    def at(self, position: Array, axes: Array) -> list[Block]:
        """The couplings as tubes."""
        parts = [part for line in self.lines(position, axes) for part in pairwise(line)]
        if not parts:
            return []
        ends = np.array(parts)
        return [tubes(ends[:, 0], ends[:, 1], RADIUS, self._color)]


def is_drawn(motion: Motion, coupling: Coupling) -> bool:
    """Whether an episode has a coupling with two ends apart."""
    present = motion.drawn.get(f"couplings.{coupling.name}.present", 1.0)
    return bool(present) and coupling.kind != "point"


def hanging(a: Array, b: Array, lengths: Array | Sequence[float]) -> list[Array]:
    """Points of some ropes between their ends: straight if taut, else a parabola of its length.

    Args:
        a, b: the ends, (n, 3) [m].
        lengths: of the ropes, (n,) [m].
    """
    wanted = np.asarray(lengths, np.float64)
    slack = wanted > np.linalg.norm(b - a, axis=-1) * (1.0 + 1e-4)
    lines = [np.stack([start, end]) for start, end in zip(a, b, strict=True)]
    if slack.any():
        curves = parabolas(a[slack], b[slack], wanted[slack])
        for k, curve in zip(np.flatnonzero(slack), curves, strict=True):
            lines[k] = curve
    return lines


def parabolas(a: Array, b: Array, lengths: Array) -> Array:
    """Points (n, PARTS + 1, 3) of slack ropes: the sag is found by halving."""
    shares = np.linspace(0.0, 1.0, PARTS + 1)[:, None]
    straight = a[:, None] + shares * (b - a)[:, None]
    below = 4.0 * shares * (1.0 - shares) * np.array([0.0, 0.0, -1.0])
    low, high = np.zeros(len(a)), np.array(lengths)  # of the sag [m]
    for _ in range(HALVINGS):
        sag = 0.5 * (low + high)
        parts = np.diff(straight + sag[:, None, None] * below, axis=1)
        is_short = np.linalg.norm(parts, axis=-1).sum(axis=1) < lengths
        low, high = np.where(is_short, sag, low), np.where(is_short, high, sag)
    return np.asarray(straight + low[:, None, None] * below)
