"""Flashes where something touches the ground, an obstacle or another robot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .distances import surface_distances
from .fixtures import Fixed, Fixtures, corners_of
from .lines import Lines
from .motion import Array, Motion
from .shapes import Color

LASTS = 0.3  # [s]
APART = 0.15  # least time between two flashes [s]
FLASH: Color = (1.0, 0.42, 0.04)
RAYS = np.array(
    [
        [np.cos(a) * c, np.sin(a) * c, s]
        for c, s, count in ((1.0, 0.12, 10), (0.72, 0.7, 6))
        for a in np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    ]
)


class Contacts:
    """The beginnings of contacts of a flight, and where they are."""

    def __init__(
        self, motion: Motion, bodies: Sequence[Fixed], obstacles: Sequence[Fixed], size: float
    ) -> None:
        """Finds the times.

        Args:
            bodies, obstacles: shapes that touch.
            size: of the robots [m].
        """
        self._motion, self._size = motion, size
        self._obstacles = [shape for shape in obstacles if shape.mesh is None]
        self._bodies = list(bodies)
        robots = [name.split(".")[0] for name in motion.body_names]
        self._robots = np.array([robots.index(robots[shape.body]) for shape in bodies], np.intp)
        self._rows = beginnings(motion)
        self._places: dict[int, Array] = {}

    def add(self, lines: Lines, time: float) -> None:
        """Adds the flashes at a time [s]: rays that grow and fade."""
        times = self._motion.time[self._rows]
        for row in self._rows[(times <= time) & (times > time - LASTS)]:
            age = (time - float(self._motion.time[row])) / LASTS
            place = self._place(int(row))
            near = place + self._size * (0.15 + 0.5 * age) * RAYS
            far = place + self._size * (0.35 + 0.75 * age) * RAYS
            lines.add_pairs(near, far, 4.0, FLASH, 1.0 - age)

    def _place(self, row: int) -> Array:
        """The point of a body that is nearest to something else, W [m]."""
        if row not in self._places:
            time = float(self._motion.time[row])
            self._places[row] = self._nearest(*self._motion.at(time))
        return self._places[row]

    def _nearest(self, position: Array, axes: Array) -> Array:
        shapes = Fixtures(self._bodies).at(position, axes)
        corners = [shape_corners(shape, position, axes) for shape in self._bodies]
        points = np.concatenate(corners)
        robots = np.repeat(self._robots, [len(corner) for corner in corners])
        gaps = points[:, 2].copy()  # to the ground
        standing = Fixtures(self._obstacles).block
        for k in range(len(self._obstacles)):
            gaps = np.minimum(gaps, surface_distances(standing, k, points))
        for k, robot in enumerate(self._robots):
            others = robots != robot
            gap = surface_distances(shapes, k, points[others])
            gaps[others] = np.minimum(gaps[others], gap)
        return np.asarray(points[int(np.argmin(gaps))])


def shape_corners(shape: Fixed, position: Array, axes: Array) -> Array:
    """Corners of a box about a body's shape, W [m]."""
    return np.asarray(position[shape.body] + corners_of(shape) @ axes[shape.body].T)


def beginnings(motion: Motion) -> Array:
    """Rows in which something begins to touch, some time apart."""
    touching = motion.touching
    found: list[int] = []
    for row in np.flatnonzero(touching[1:] & ~touching[:-1]) + 1:
        if not found or motion.time[row] - motion.time[found[-1]] >= APART:
            found.append(int(row))
    return np.array(found, np.intp)
