"""The policy's end of ROS 1, on rospy."""

from __future__ import annotations

from typing import Any

from research.sync.link import ThreadedLink, fill_wrench, state_of
from research.sync.work import ODOMETRY, WRENCH, Reals


class Ros1Link(ThreadedLink):
    """A node of ROS 1."""

    def __init__(self) -> None:
        super().__init__()
        import rospy
        from geometry_msgs.msg import WrenchStamped
        from nav_msgs.msg import Odometry

        self._rospy, self._message = rospy, WrenchStamped
        rospy.init_node("policy", argv=[], disable_signals=True)
        self._wrenches = rospy.Publisher(WRENCH, WrenchStamped, queue_size=10)
        rospy.Subscriber(ODOMETRY, Odometry, self._take, queue_size=10, tcp_nodelay=True)

    def send(self, word: str, wrench: Reals) -> None:
        """As Link."""
        self._wrenches.publish(fill_wrench(self._message(), word, wrench))

    def close(self) -> None:
        """As Link."""
        self._rospy.signal_shutdown("the trials are over")

    def _take(self, message: Any) -> None:
        self.keep(message.header.stamp.to_sec(), state_of(message))
