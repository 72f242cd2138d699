"""`skybody onboard MISSION --ros2`: a node of ROS 2 that feeds the program onboard.

skybody onboard racing.mission --ros2 --odometry /mavros/odometry --fifo 50
"""

from __future__ import annotations

import argparse
import socket
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from skybody import Error
from skybody.command_line import CommandLine, report_error
from skybody.program import INTERRUPTED, run_program
from skybody.ros.messages import message_class
from skybody.ros2.node import REMEDY, load_rclpy

from .odometry import FILLS, imu_of, state_of
from .packets import read_command
from .program import running

HOST = "127.0.0.1"
DEPTH = 1  # of queues: the newest message counts
LOOK = 0.2  # longest wait for an answer before a look at the program [s]


def parser() -> argparse.ArgumentParser:
    """Options of the bridge; others are the program's."""
    made = CommandLine(
        prog="skybody onboard --ros2",
        description="Feeds `skybody onboard` from ROS 2 (docs/onboard.md). Other options are "
        "passed on to the program: see `skybody onboard --help`.",
    )
    add = made.add_argument
    add("mission", type=Path, help="file of `skybody export --to onboard`")
    add("--name", default="skybody_onboard", help="of the node; default: skybody_onboard")
    odometry = "nav_msgs/msg/Odometry; default: /odometry"
    add("--odometry", default="/odometry", metavar="TOPIC", help=odometry)
    add("--imu", metavar="TOPIC", help="sensor_msgs/msg/Imu; default: none")
    add("--command", default="/command", metavar="TOPIC", help="default: /command")
    add(
        "--type",
        default=next(iter(FILLS)),
        choices=list(FILLS),
        help="of the command; default: std_msgs/msg/Float64MultiArray, in physical units",
    )
    return made


class Bridge:
    """Passes poses on to the program, and its commands to a topic."""

    def __init__(self, node: Any, options: argparse.Namespace, port: int) -> None:
        """Makes publisher and subscriptions.

        Raises:
            InputError: a message is not installed.
        """
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect((HOST, port))
        self._socket.settimeout(LOOK)
        self._sequence = 0
        self._fill = FILLS[options.type]
        self._class = message_class(options.type, REMEDY)
        self._publisher = node.create_publisher(self._class, options.command, DEPTH)
        odometry = message_class("nav_msgs/msg/Odometry", REMEDY)
        node.create_subscription(odometry, options.odometry, self._taker(state_of), DEPTH)
        if options.imu:
            imu = message_class("sensor_msgs/msg/Imu", REMEDY)
            node.create_subscription(imu, options.imu, self._taker(imu_of), DEPTH)

    def _taker(self, pack: Any) -> Any:
        def take(message: Any) -> None:
            try:
                self._socket.send(pack(message, self._sequence))
            except ConnectionRefusedError:
                return  # the program has ended, which the main loop notices
            self._sequence += 1

        return take

    def publish_answers(self, ended: threading.Event) -> None:
        """Publishes commands until the program ends. For a thread of its own."""
        while not ended.is_set():
            try:
                answer = read_command(self._socket.recv(4096))
            except TimeoutError:
                continue
            except OSError:
                return
            message = self._class()
            self._fill(message, answer)
            self._publisher.publish(message)


def spin(options: argparse.Namespace, rest: Sequence[str]) -> int:
    """Runs program and node until one of them ends."""
    rclpy = load_rclpy()
    rclpy.init(args=[])
    ended = threading.Event()
    try:
        with running(options.mission, rest) as (port, process):
            node = rclpy.create_node(options.name)
            bridge = Bridge(node, options, port)
            thread = threading.Thread(target=bridge.publish_answers, args=(ended,), daemon=True)
            thread.start()
            print(f"node     /{options.name}: {options.odometry} to {options.command}", flush=True)
            while process.poll() is None and rclpy.ok():
                rclpy.spin_once(node, timeout_sec=LOOK)
            ended.set()
            thread.join()
    except KeyboardInterrupt:
        print("interrupted")
        return INTERRUPTED
    finally:
        ended.set()
        rclpy.try_shutdown()
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command."""
    options, rest = parser().parse_known_args(arguments)
    try:
        return spin(options, rest)
    except (Error, ValueError) as error:
        return report_error(str(error))


if __name__ == "__main__":
    run_program(main)
