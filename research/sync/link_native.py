"""The policy's end of Gazebo Transport and of Cyclone DDS."""

from __future__ import annotations

from research.sync import native
from research.sync.link import ThreadedLink
from research.sync.work import ODOMETRY, WRENCH, Reals


class NativeLink(ThreadedLink):
    """A publisher and a subscription of a library.

    Args:
        library: the middleware's.
    """

    def __init__(self, library: native.Library) -> None:
        super().__init__()
        self._wrenches = native.Publisher(library, WRENCH, is_wrench=True)
        native.take_odometry(library, ODOMETRY, self.keep)

    def send(self, word: str, wrench: Reals) -> None:
        """As Link."""
        self._wrenches.send_wrench(word, wrench)

    def close(self) -> None:
        """As Link; the library ends with the process."""


def gazebo() -> NativeLink:
    """The link of Gazebo Transport."""
    return NativeLink(native.GAZEBO)


def cyclone() -> NativeLink:
    """The link of Cyclone DDS."""
    return NativeLink(native.CYCLONE)
