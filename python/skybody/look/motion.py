"""The motion of an environment over time, as it is drawn: of a flight log, or as it happens."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from skybody import CompiledScenario

from .rows import Rows

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Overview:
    """Some rows at equal distances, the first and the last among them."""

    time: Array  # [s]
    bodies: Array  # rows x bodies x 13
    rotor_speed: Array  # rows x rotors [rad/s]
    goals: dict[str, Array]  # by body: rows x 4


class Motion(ABC):
    """Rows of states of an environment, and the poses between them."""

    MOST = 2000  # rows of the overview

    # --- parts ----------------------------------------------------------------------------------

    @property
    @abstractmethod
    def compiled(self) -> CompiledScenario:
        """The scenario."""

    @property
    @abstractmethod
    def drawn(self) -> Mapping[str, float]:
        """Values of the episode's parameters by path."""

    @property
    @abstractmethod
    def time(self) -> Array:
        """Of each row, since the reset [s]."""

    @property
    @abstractmethod
    def body_names(self) -> list[str]:
        """ROBOT.LINK of each body."""

    @property
    @abstractmethod
    def goal_columns(self) -> Mapping[str, int]:
        """Index of the goal of each body that has one."""

    @property
    @abstractmethod
    def touching(self) -> NDArray[np.bool_]:
        """Rows in which something touches the ground, an obstacle or another robot."""

    @abstractmethod
    def rows(self, name: str) -> Rows:
        """Rows of `bodies`, `rotor_speed` or `goal` (docs/flight-log.md); of width 0: none."""

    @abstractmethod
    def turns(self, time: float) -> Array:
        """Angle of each rotor [rad] since the reset."""

    # --- at a time ------------------------------------------------------------------------------

    @property
    def duration(self) -> float:
        """Time of the last row, since the reset [s]."""
        return float(self.time[-1])

    def at(self, time: float) -> tuple[Array, Array]:
        """Poses between rows.

        Args:
            time: since the reset [s]; held at the ends.

        Returns:
            Positions (bodies, 3), W [m], and matrices (bodies, 3, 3), W from B.
        """
        position, quaternion = self.poses([time])
        return position[0], rotation_of(quaternion[0])

    def poses(self, times: ArrayLike) -> tuple[Array, Array]:
        """Positions (times, bodies, 3), W [m], and quaternions (times, bodies, 4), not unit."""
        wanted = np.asarray(times, np.float64)
        last = len(self.time) - 1
        row = np.clip(np.searchsorted(self.time, wanted) - 1, 0, max(last - 1, 0))
        after = np.minimum(row + 1, last)
        span = self.time[after] - self.time[row]
        share = (wanted - self.time[row]) / np.where(span > 0.0, span, 1.0)
        share = np.where(span > 0.0, np.clip(share, 0.0, 1.0), 0.0)[:, None, None]
        both = self.rows("bodies")[np.concatenate([row, after])]
        a, b = both[: len(row), :, :7], both[len(row) :, :, :7]
        nearer = np.where(np.sum(a[..., 3:] * b[..., 3:], axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
        quaternion = a[..., 3:] + share * (nearer * b[..., 3:] - a[..., 3:])
        return a[..., :3] + share * (b[..., :3] - a[..., :3]), quaternion

    def row_at(self, time: float) -> int:
        """Index of the last row that is not after a time."""
        return max(int(np.searchsorted(self.time, time, side="right")) - 1, 0)

    def rotor_speed_at(self, time: float) -> Array:
        """Of each rotor [rad/s]; none if it is not known."""
        speeds = self.rows("rotor_speed")[[self.row_at(time)]]
        return np.asarray(speeds[0])

    def goals_at(self, time: float) -> dict[str, Array]:
        """By body: position (W) [m] and yaw [rad]."""
        rows = np.array([self.row_at(time)], np.intp)
        return {name: goal[0] for name, goal in self.goals_in(rows).items()}

    def goals_in(self, rows: NDArray[np.intp]) -> dict[str, Array]:
        """By body: rows x 4, position (W) [m] and yaw [rad]; empty: there are no goals."""
        if not self.goal_columns:
            return {}
        goal = self.rows("goal")[rows]
        return {name: goal[:, k] for name, k in self.goal_columns.items()}

    def stretch(self, first: float, last: float, most: int) -> NDArray[np.intp]:
        """At most `most` + 1 rows between two times [s]; those of all stretches lie on one grid."""
        begin, end = np.searchsorted(self.time, [first, last])
        step = max(1, -(-int(end - begin) // most))
        return np.arange(-(-int(begin) // step) * step, end, step, dtype=np.intp)

    @property
    def overview(self) -> Overview:
        """Rows of all of it, at most MOST."""
        rows = np.unique(np.linspace(0, len(self.time) - 1, self.MOST).astype(np.intp))
        return Overview(
            self.time[rows],
            self.rows("bodies")[rows],
            self.rows("rotor_speed")[rows],
            self.goals_in(rows),
        )


def continuous(quaternions: Array) -> Array:
    """The same rotations (rows, ..., 4), with signs that do not jump from row to row."""
    products = np.sum(quaternions[1:] * quaternions[:-1], axis=-1, keepdims=True)
    found = quaternions.copy()
    found[1:] *= np.cumprod(np.where(products < 0.0, -1.0, 1.0), axis=0)
    return found


def rotation_of(quaternions: Array) -> Array:
    """Matrices of quaternions w x y z of any length above 0, along the last axis."""
    w, x, y, z = np.moveaxis(
        quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True), -1, 0
    )
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
