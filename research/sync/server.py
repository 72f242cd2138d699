"""The simulator's process: `skybody ros1`, `skybody ros2`, or the same node on Gazebo Transport.

python -m research.sync.server ros2 --out rows.npy [--free]

With --free the physics steps follow the clock on the wall; otherwise each wrench makes 10 steps.
"""

from __future__ import annotations

import argparse
import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from skybody.ros.bridge_map import BridgeMap
from skybody.ros.messages import AnyMessage
from skybody.ros.threaded_node import ThreadedNode

from research.sync import native
from research.sync.link import fill_wrench, state_of
from research.sync.recorded import RecordedBridge, RecordedNode, bridge_map
from research.sync.work import ODOMETRY, WRENCH, Reals

Ended = Callable[[], None]


def serve_ros2(bridge: RecordedBridge, factor: float | None, ended: Ended) -> None:
    """Runs the node of `skybody ros2`."""
    from skybody.ros2 import node

    class Recorded(RecordedNode, node.Node):
        pass

    node.load_rclpy().init(args=[])
    with node.until_shutdown():
        serve_until_end(Recorded(bridge, bridge_map(), "skybody", factor), ended)


def serve_ros1(bridge: RecordedBridge, factor: float | None, ended: Ended) -> None:
    """Runs the node of `skybody ros1`."""
    from skybody.ros1 import node

    class Recorded(RecordedNode, node.Node):
        pass

    serve_until_end(Recorded(bridge, bridge_map(), "skybody", factor), ended)


def serve_gazebo(bridge: RecordedBridge, factor: float | None, ended: Ended) -> None:
    """Runs the same node on Gazebo Transport."""
    serve_until_end(GazeboNode(bridge, bridge_map(), factor), ended)


def serve_until_end(node: Any, ended: Ended) -> None:
    """Saves the start, says that it is ready, and runs the node until its process ends."""
    node.ended = ended
    node.acts()["save"]()
    print("ready", flush=True)
    node.spin()


class GazeboNode(RecordedNode, ThreadedNode):
    """The node on Gazebo Transport."""

    def __init__(self, bridge: RecordedBridge, table: BridgeMap, factor: float | None) -> None:
        super().__init__(bridge, table, factor, lambda _: AnyMessage)
        self._odometry = native.Publisher(native.GAZEBO, ODOMETRY, is_wrench=False)
        take = self.locked(functools.partial(self.take, 0))

        def act(word: str, wrench: Reals) -> None:
            take(fill_wrench(AnyMessage(), word, wrench))

        native.take_wrenches(native.GAZEBO, WRENCH, act)

    def is_over(self) -> bool:
        """As ThreadedNode: it ends with its process."""
        return False

    def _publish(self, number: int, message: Any) -> None:
        stamp = message.header.stamp
        row = np.concatenate([[stamp.sec + 1e-9 * stamp.nanosec], state_of(message)])
        self._odometry.send_odometry(row)

    def _publish_clock(self, message: Any) -> None:
        raise NotImplementedError("the map has no clock")

    def _warn(self, text: str) -> None:
        raise RuntimeError(text)


SERVERS = {"ros2": serve_ros2, "ros1": serve_ros1, "gazebo": serve_gazebo}


def main() -> None:
    """Serves until the process is ended."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("middleware", choices=SERVERS)
    parser.add_argument("--free", action="store_true")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    bridge = RecordedBridge(options.free)
    factor = 1.0 if options.free else None
    SERVERS[options.middleware](bridge, factor, lambda: bridge.write(options.out))


if __name__ == "__main__":
    main()
