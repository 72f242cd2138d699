"""Lines over a picture: trails, goals, arrows. They have flat colours and no shadows."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .motion import Array

HEIGHT = 1080  # of the picture whose pixels the widths are given in


class Lines:
    """A growing list of lines."""

    def __init__(self) -> None:
        self._points: list[Array] = [np.zeros((0, 3))]
        self._widths: list[NDArray[np.float32]] = [np.zeros(0, np.float32)]
        self._colors: list[NDArray[np.float32]] = [np.zeros((0, 4), np.float32)]
        self._firsts: list[NDArray[np.uint8]] = [np.zeros(0, np.uint8)]

    def add(
        self,
        points: Array,
        width: ArrayLike,
        color: ArrayLike,
        opacity: ArrayLike = 1.0,
        firsts: ArrayLike | None = None,
    ) -> None:
        """Adds a line through points.

        Args:
            points: (n, 3), W [m].
            width: [pixels of a picture with 1080 rows], of all or each of them.
            color: red, green, blue in [0, 1], of all or each, (3,) or (n, 3).
            opacity: in [0, 1], of all or each.
            firsts: 1 where a line begins; None: at the first point alone.
        """
        n = len(points)
        paint = np.empty((n, 4), np.float32)
        paint[:, :3], paint[:, 3] = color, opacity
        begins = np.zeros(n, np.uint8)
        begins[:1] = 1
        known = np.asarray(np.isfinite(points).all(axis=1))
        begins[1:] |= ~known[:-1]
        if firsts is not None:
            begins |= np.asarray(firsts, np.uint8)
        self._points.append(np.asarray(points[known], np.float64))
        self._widths.append(np.broadcast_to(np.asarray(width, np.float32), n)[known])
        self._colors.append(paint[known])
        self._firsts.append(begins[known])

    def add_pairs(
        self, starts: Array, ends: Array, width: float, color: ArrayLike, opacity: ArrayLike = 1.0
    ) -> None:
        """Adds lines between points (n, 3), W [m]."""
        points = np.stack([starts, ends], axis=1).reshape(-1, 3)
        self.add(points, width, color, opacity, np.tile([1, 0], len(starts)))

    def arrays(
        self, height: int
    ) -> tuple[Array, NDArray[np.float32], NDArray[np.float32], NDArray[np.uint8]]:
        """As the renderer takes them, for a picture of some height [pixels]."""
        widths = np.concatenate(self._widths)
        scaled = widths * np.float32(np.sqrt(height / HEIGHT))  # so that small pictures have lines
        return (
            np.concatenate(self._points),
            scaled.astype(np.float32),
            np.concatenate(self._colors),
            np.concatenate(self._firsts),
        )
