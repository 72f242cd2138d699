"""Lines of a flight: trails of robots, goals, and paths that goals follow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from .lines import Lines
from .motion import Array, Motion
from .shapes import IDENTITY, Color

GOAL: Color = (0.05, 0.55, 0.25)
WIDTH = 4.0  # of trails at their robots [pixels of 1080 rows]
PARTS = 90  # most parts of a trail
MOST_JUMPS = 4  # of a goal with a path
JUMP = 8.0  # a path is broken where a step is that many times as long as the median
NEAR = 4  # of so many steps on both sides,
SHORT = 0.01  # and longer than this share of all of it


class Trails:
    """The ways of the robots' bases in the last seconds."""

    def __init__(
        self,
        motion: Motion,
        bases: Sequence[int],
        seconds: float,
        value: str,
        colors: Sequence[Color],
    ) -> None:
        """Prepares the colours.

        Args:
            bases: a body of each robot.
            seconds: length of the trails [s].
            value: `speed` or `error` (distance from the goal) gives the colour; empty: the robot.
            colors: of the robots.
        """
        self._motion, self._seconds, self._colors = motion, seconds, colors
        self._bases = list(bases)
        self._value = {"speed": self._speeds, "error": self._errors}.get(value)
        self._most = 0.0

    def add(self, lines: Lines, time: float) -> None:
        """Adds the trails at a time [s]."""
        position = self._motion.at(time)[0]
        rows = self._motion.stretch(max(time - self._seconds, 0.0), time, PARTS)
        bodies = self._motion.rows("bodies")[rows]
        age = np.append(self._motion.time[rows], time) - time + self._seconds
        share = np.clip(age / self._seconds, 0.0, 1.0)
        values = self._values(bodies, rows)
        for k, base in enumerate(self._bases):
            points = np.concatenate([bodies[:, base, :3], position[None, base]])
            color = self._colors[k] if values is None else blends(values[:, k])
            lines.add(points, WIDTH * (0.35 + 0.65 * share), color, share)

    def _values(self, bodies: Array, rows: NDArray[np.intp]) -> Array | None:
        """Shares of the greatest value of the flight, (rows + 1, robots)."""
        if self._value is None or len(rows) == 0:
            return None
        if self._most == 0.0:
            view = self._motion.overview
            self._most = max(float(np.nanmax(self._value(view.bodies, view.goals))), 1e-9)
        values = self._value(bodies, self._motion.goals_in(rows)) / self._most
        return np.concatenate([values, values[-1:]])

    def _speeds(self, bodies: Array, goals: Mapping[str, Array]) -> Array:
        return np.asarray(np.linalg.norm(bodies[:, self._bases, 7:10], axis=-1))

    def _errors(self, bodies: Array, goals: Mapping[str, Array]) -> Array:
        return distances(self._motion.body_names, self._bases, bodies, goals)


def distances(
    names: Sequence[str], bases: Sequence[int], bodies: Array, goals: Mapping[str, Array]
) -> Array:
    """Distance of each base from its goal [m], rows x bases; 0 without a goal.

    Args:
        names: of all bodies.
        bases: indices of bodies.
        bodies: rows x bodies x 13.
        goals: by the name of the body, rows x 4.
    """
    columns = []
    for base in bases:
        place, goal = bodies[:, base, :3], goals.get(names[base])
        columns.append(
            np.zeros(len(place)) if goal is None else np.linalg.norm(place - goal[:, :3], axis=1)
        )
    return np.stack(columns, axis=1)


def blends(shares: Array) -> Array:
    """From blue (0) over green and yellow to red (1), (n, 3)."""
    stops = np.array(
        [[0.13, 0.35, 0.85], [0.12, 0.68, 0.55], [0.95, 0.80, 0.15], [0.90, 0.18, 0.12]]
    )
    at = np.nan_to_num(np.clip(shares, 0.0, 1.0)) * (len(stops) - 1)
    return np.stack([np.interp(at, range(len(stops)), stop) for stop in stops.T], axis=-1)


def add_goals(
    lines: Lines, goals: Mapping[str, Array], size: float, color: Color | None = None
) -> None:
    """Adds a cross at each goal.

    Args:
        goals: position (W) [m] and yaw [rad].
        size: of the robots [m].
    """
    for goal in goals.values():
        if np.isfinite(goal[:3]).all():
            arms = 0.3 * size * IDENTITY
            lines.add_pairs(goal[:3] - arms, goal[:3] + arms, 3.0, color or GOAL)


class Paths:
    """The whole ways of the goals that move."""

    def __init__(self, motion: Motion, color: Color | None = None) -> None:
        """Finds them.

        Args:
            color: in place of that of goals.
        """
        goals = [goal[:, :3] for goal in motion.overview.goals.values()]
        paths = [(path, breaks(path)) for path in goals if moves(path)]
        self._paths = [(path, firsts) for path, firsts in paths if firsts.sum() <= MOST_JUMPS + 1]
        self._color = color or GOAL

    def add(self, lines: Lines, time: float) -> None:
        """Adds a faint line along each way; it is the same at all times."""
        for path, firsts in self._paths:
            lines.add(path, 2.5, self._color, 0.55, firsts)


def moves(path: Array) -> bool:
    """Whether a goal goes along a path, rather than from place to place."""
    known = path[np.isfinite(path).all(axis=1)]
    steps = np.linalg.norm(np.diff(known, axis=0), axis=1)
    return bool(np.mean(steps > 0.0) > 0.2) if len(steps) > 0 else False


def breaks(path: Array) -> Array:
    """1 at points to which no line leads: the goal has jumped."""
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    if len(steps) == 0:
        return np.ones(len(path), np.uint8)
    near = np.lib.stride_tricks.sliding_window_view(np.pad(steps, NEAR, "edge"), 2 * NEAR + 1)
    beside = np.median(near, axis=1)  # is not raised by a jump away and back
    least = SHORT * np.nansum(steps)
    return np.concatenate([[1], (steps > JUMP * beside) & (steps > least)]).astype(np.uint8)
