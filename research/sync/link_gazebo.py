"""The policy's end of Gazebo Transport."""

from __future__ import annotations

from research.sync import gazebo
from research.sync.link import ThreadedLink
from research.sync.work import ODOMETRY, WRENCH, Reals


class GazeboLink(ThreadedLink):
    """A node of Gazebo Transport."""

    def __init__(self) -> None:
        super().__init__()
        self._wrenches = gazebo.Publisher(WRENCH, is_wrench=True)
        gazebo.take_odometry(ODOMETRY, self.keep)

    def send(self, word: str, wrench: Reals) -> None:
        """As Link."""
        self._wrenches.send_wrench(word, wrench)

    def close(self) -> None:
        """As Link; the library ends with the process."""
