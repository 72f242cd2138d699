"""A bridge and nodes that note which action each physics step obeys, and when."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from skybody import Simulation
from skybody.ros.bridge import Bridge
from skybody.ros.bridge_map import BridgeMap, Row
from skybody.ros.node import Node

from research.sync.work import END, ODOMETRY, RESTORE, SCENARIO, SEED, STEPS, WRENCH, step_of

# trial, action, physics steps before, time at the step's start and end [s], position before [m]
COLUMNS = ("trial", "action", "step", "begin", "end", "x", "y", "z")


def bridge_map() -> BridgeMap:
    """The topics."""
    odometry = Row(ODOMETRY, "nav_msgs/msg/Odometry", "odometry")
    wrench = Row(WRENCH, "geometry_msgs/msg/WrenchStamped", "wrench")
    return BridgeMap([odometry], [wrench], "wrench", clock=False)


class RecordedBridge(Bridge):
    """Notes a row of COLUMNS for each step.

    Args:
        is_free: a step is one physics step, by the clock on the wall; else it is an action.
    """

    def __init__(self, is_free: bool) -> None:
        repeat = f"stepping.action_repeat={1 if is_free else STEPS}"
        simulation = Simulation(SCENARIO, "wrench", overrides=[repeat], seed=SEED)
        super().__init__(simulation, bridge_map())
        self.rows: list[tuple[float, ...]] = []
        self.trial = -1
        self._action = -1

    def take(self, number: int, message: Any) -> str:
        """As Bridge; the message's frame is the number of the action."""
        problem = super().take(number, message)
        if not problem:
            self._action = int(message.header.frame_id)
        return problem

    def advance(self) -> None:
        """As Bridge."""
        simulation = self.simulation
        if simulation.terminated or simulation.truncated:
            raise RuntimeError("the vehicle has left the space of its task")
        step, position = step_of(simulation.time), simulation.base().position.tolist()
        begin = time.perf_counter()
        super().advance()
        end = time.perf_counter()
        self.rows.append((self.trial, self._action, step, begin, end, *position))

    def write(self, path: Path) -> None:
        """Writes all rows; the file appears when it is complete."""
        part = path.with_suffix(".part.npy")
        np.save(part, np.array(self.rows, np.float64).reshape(-1, len(COLUMNS)))
        part.rename(path)


class RecordedNode(Node):
    """Part of a node whose wrenches may also begin a trial or end all."""

    bridge: RecordedBridge
    ended: Callable[[], None] = staticmethod(lambda: None)

    def take(self, number: int, message: Any) -> None:
        """As Node, or an order: `restore TRIAL`, `end`."""
        order, _, trial = message.header.frame_id.partition(" ")
        if order == RESTORE:
            self.bridge.trial = int(trial)
            self._restore()
        elif order == END:
            self.ended()
        else:
            super().take(number, message)
