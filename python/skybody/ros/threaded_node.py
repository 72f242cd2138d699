"""A node whose callbacks come from threads of a middleware."""

from __future__ import annotations

import threading
import time
from abc import abstractmethod
from collections.abc import Callable
from typing import Any

from .bridge import Bridge
from .bridge_map import BridgeMap
from .node import Node

NAP = 0.1  # between looks at whether a node in lockstep is over [s]


class ThreadedNode(Node):
    """A node under a lock; its own thread makes the steps in real time."""

    def __init__(
        self, bridge: Bridge, table: BridgeMap, factor: float | None, find: Callable[[str], Any]
    ) -> None:
        """As Node."""
        super().__init__(bridge, table, factor, find)
        self._lock = threading.Lock()

    @abstractmethod
    def is_over(self) -> bool:
        """Whether the node has been shut down."""

    def locked(self, act: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, one thread at a time."""

        def guarded(*arguments: Any) -> Any:
            with self._lock:
                return act(*arguments)

        return guarded

    def spin(self) -> None:
        """Runs until the node is over; in real time by the clock on the wall."""
        due = time.monotonic()
        while not self.is_over():
            if self.factor is None:
                time.sleep(NAP)
                continue
            due = max(due + self.period, time.monotonic())  # late steps are not made up for
            time.sleep(max(0.0, due - time.monotonic()))
            self.locked(self.tick)()
