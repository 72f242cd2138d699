"""The policy's end of ROS 2, on rclpy."""

from __future__ import annotations

from typing import Any

from research.sync.link import Link, fill_wrench, state_of
from research.sync.work import ODOMETRY, WRENCH, Reals


class Ros2Link(Link):
    """A node of ROS 2."""

    def __init__(self) -> None:
        super().__init__()
        import rclpy
        from geometry_msgs.msg import WrenchStamped
        from nav_msgs.msg import Odometry

        rclpy.init(args=[])
        self._rclpy, self._message = rclpy, WrenchStamped
        self._node = rclpy.create_node("policy")
        self._executor = rclpy.executors.SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._wrenches = self._node.create_publisher(WrenchStamped, WRENCH, 10)
        self._node.create_subscription(Odometry, ODOMETRY, self._take, 10)

    def send(self, word: str, wrench: Reals) -> None:
        """As Link."""
        self._wrenches.publish(fill_wrench(self._message(), word, wrench))

    def spin(self, seconds: float) -> None:
        """As Link."""
        self._executor.spin_once(timeout_sec=seconds)

    def close(self) -> None:
        """As Link."""
        self._node.destroy_node()
        self._rclpy.try_shutdown()

    def _take(self, message: Any) -> None:
        stamp = message.header.stamp
        self.keep(stamp.sec + 1e-9 * stamp.nanosec, state_of(message))
