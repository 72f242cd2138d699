"""`skybody ros1`: a scenario as a node of ROS 1.

skybody ros1 trajectory_ctbr --map map.yaml             # each command makes one step
skybody ros1 hover --map map.yaml --real-time 1         # as fast as the clock on the wall
"""

from __future__ import annotations

import argparse
import signal
from collections.abc import Sequence

from skybody.program import run_program
from skybody.ros.bridge import Bridge
from skybody.ros.bridge_map import BridgeMap
from skybody.ros.command import run, say_ready

from .node import Node, load_rospy


def spin(bridge: Bridge, table: BridgeMap, options: argparse.Namespace) -> None:
    """Runs the node until it is shut down."""
    rospy = load_rospy()
    # So that the master forgets the node; rospy's own handlers would also take Ctrl-C.
    signal.signal(signal.SIGTERM, lambda *_: rospy.signal_shutdown("terminated"))
    try:
        node = Node(bridge, table, options.name, options.real_time)
        say_ready(bridge, options)
        node.spin()
    finally:
        rospy.signal_shutdown("the program ends")


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command."""
    return run(1, load_rospy, spin, arguments)


if __name__ == "__main__":
    run_program(main)
