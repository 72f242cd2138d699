"""`skybody ros2`: a scenario as a node of ROS 2.

skybody ros2 trajectory_ctbr --map map.yaml             # each command makes one step
skybody ros2 hover --map map.yaml --real-time 1         # as fast as the clock on the wall
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from skybody import InputError
from skybody.program import run_program
from skybody.ros.bridge import Bridge
from skybody.ros.bridge_map import BridgeMap
from skybody.ros.command import run, say_ready

from .node import Node, load_rclpy, until_shutdown


def spin(bridge: Bridge, table: BridgeMap, options: argparse.Namespace) -> None:
    """Runs the node until it is shut down."""
    rclpy = load_rclpy()
    rclpy.init(args=[])
    try:
        with until_shutdown():
            node = Node(bridge, table, options.name, options.real_time)
            say_ready(bridge, options)
            node.spin()
    except rclpy.exceptions.NameValidationException as error:
        words = str(error).rstrip("^ \n").split()  # of three lines, the last one a mark
        raise InputError(" ".join(words)) from None
    finally:
        rclpy.try_shutdown()


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command."""
    return run(2, load_rclpy, spin, arguments)


if __name__ == "__main__":
    run_program(main)
