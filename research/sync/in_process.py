"""The simulator in the policy's own process: no middleware."""

from __future__ import annotations

from typing import Any

from skybody.ros.messages import AnyMessage

from research.sync.link import Link, fill_wrench, state_of
from research.sync.recorded import RecordedBridge, RecordedNode, bridge_map
from research.sync.work import Reals


class DirectNode(RecordedNode):
    """A node that hands its messages to a function."""

    def __init__(self, bridge: RecordedBridge, see: Any) -> None:
        super().__init__(bridge, bridge_map(), None, lambda _: AnyMessage)
        self._see = see

    def _publish(self, number: int, message: Any) -> None:
        self._see(message)

    def _publish_clock(self, message: Any) -> None:
        raise NotImplementedError("the map has no clock")

    def _warn(self, text: str) -> None:
        raise RuntimeError(text)


class DirectLink(Link):
    """The link of one process: a wrench is a step, and its odometry is there at once."""

    def __init__(self) -> None:
        super().__init__()
        self.bridge = RecordedBridge(is_free=False)
        self._node = DirectNode(self.bridge, self._take)
        self._node.acts()["save"]()

    def send(self, word: str, wrench: Reals) -> None:
        """As Link."""
        self._node.take(0, fill_wrench(AnyMessage(), word, wrench))

    def spin(self, seconds: float) -> None:
        """As Link; nothing comes by itself."""

    def close(self) -> None:
        """As Link."""

    def _take(self, message: Any) -> None:
        stamp = message.header.stamp
        self.keep(stamp.sec + 1e-9 * stamp.nanosec, state_of(message))
