"""The policy's end of a middleware: it sends wrenches, and keeps the odometry that comes."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from research.sync.work import Observation, Reals, step_of


def state_of(message: Any) -> Reals:
    """The 13 numbers of an odometry message of ROS 1 or ROS 2."""
    pose, twist = message.pose.pose, message.twist.twist
    p, q, v, w = pose.position, pose.orientation, twist.linear, twist.angular
    return np.array([p.x, p.y, p.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z])


def fill_wrench(message: Any, word: str, wrench: Reals) -> Any:
    """Writes a stamped wrench of ROS 1 or ROS 2, with a word in its frame."""
    message.header.frame_id = word
    for to, values in ((message.wrench.force, wrench[:3]), (message.wrench.torque, wrench[3:])):
        to.x, to.y, to.z = (float(value) for value in values)
    return message


class Link(ABC):
    """Messages between the policy and the simulator."""

    def __init__(self) -> None:
        self.newest: Observation | None = None
        self.came: list[Observation] = []

    @abstractmethod
    def send(self, word: str, wrench: Reals) -> None:
        """Sends a wrench (6,) under a word: the number of the action, or RESTORE, END."""

    @abstractmethod
    def spin(self, seconds: float) -> None:
        """Takes messages for at most this time; may return as soon as one has come."""

    @abstractmethod
    def close(self) -> None:
        """Ends the connection."""

    def keep(self, time_of: float, state: Reals) -> None:
        """Keeps an observation that has come.

        Args:
            time_of: of the simulation [s].
            state: (13,), as of Observation.
        """
        self.newest = Observation(step_of(time_of), state, time.perf_counter())
        self.came.append(self.newest)

    def forget(self) -> None:
        """Drops all observations."""
        self.newest = None
        self.came = []

    def spin_until(self, due: float) -> None:
        """Takes messages until time.perf_counter() is due."""
        while (left := due - time.perf_counter()) > 0.0:
            self.spin(left)

    def wait_for(self, step: int, seconds: float) -> Observation | None:
        """The newest observation once it is of this physics step; None: the time is over."""
        due = time.perf_counter() + seconds
        while (left := due - time.perf_counter()) > 0.0:
            if self.newest is not None and self.newest.step == step:
                return self.newest
            self.spin(left)
        return None


class ThreadedLink(Link):
    """A link whose messages come in a thread of the middleware."""

    def __init__(self) -> None:
        super().__init__()
        self._news = threading.Condition()
        self._count = self._seen = 0

    def keep(self, time_of: float, state: Reals) -> None:
        """As Link."""
        with self._news:
            super().keep(time_of, state)
            self._count += 1
            self._news.notify()

    def spin(self, seconds: float) -> None:
        """As Link."""
        with self._news:
            if self._count == self._seen:
                self._news.wait(seconds)
            self._seen = self._count
