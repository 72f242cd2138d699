"""Middleware without Python, by ctypes: small libraries that are compiled at their first use.

gazebo.cpp is Gazebo Transport. cyclone.c is ROS 2 on the wire, by Cyclone DDS: only the policy's
end. Both have the same functions.
"""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from research.sync.work import Reals

HERE = Path(__file__).resolve().parent
BUILT = HERE.parents[1] / ".peers/sync"
# Fast DDS announces the address of the machine's network: only an interface that has it takes it.
# Without multicast, and with this machine as the only peer, all messages stay here.
_CYCLONE = (
    "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast></General><Discovery>"
    "<ParticipantIndex>auto</ParticipantIndex><Peers><Peer address='127.0.0.1'/></Peers>"
    "</Discovery></Domain></CycloneDDS>"
)
LOCAL = {"IGN_IP": "127.0.0.1", "CYCLONEDDS_URI": _CYCLONE}  # only this machine

_Take = ctypes.CFUNCTYPE(None, ctypes.c_char_p, ctypes.POINTER(ctypes.c_double))
_See = ctypes.CFUNCTYPE(None, ctypes.POINTER(ctypes.c_double))
_kept: list[object] = []  # functions that the library calls live as long as the process


@dataclass(frozen=True)
class Library:
    """A library for one middleware."""

    name: str
    sources: tuple[str, ...]  # *.idl becomes C
    packages: tuple[str, ...]  # of pkg-config
    compiler: tuple[str, ...]

    @property
    def is_there(self) -> bool:
        """Whether the headers of the middleware are installed."""
        try:
            found = subprocess.run(["pkg-config", "--exists", *self.packages], check=False)
        except OSError:
            return False
        return found.returncode == 0

    @property
    def path(self) -> Path:
        """The compiled library."""
        return BUILT / f"lib{self.name}_sync.so"

    def build(self) -> None:
        """Compiles the library if a source has changed."""
        sources = [HERE / source for source in self.sources]
        newest = max(source.stat().st_mtime for source in sources)
        if self.path.exists() and self.path.stat().st_mtime >= newest:
            return
        BUILT.mkdir(parents=True, exist_ok=True)
        for idl in (source for source in sources if source.suffix == ".idl"):
            subprocess.run(["idlc", "-t", "-o", str(BUILT), str(idl)], check=True)
        pkg_config = ["pkg-config", "--cflags", "--libs", *self.packages]
        found = subprocess.run(pkg_config, capture_output=True, text=True, check=True)
        words = [str(BUILT / f"{one.stem}.c" if one.suffix == ".idl" else one) for one in sources]
        shared = ["-O2", "-shared", "-fPIC", "-I", str(BUILT), "-o", str(self.path)]
        command = [*self.compiler, *shared, *words, *found.stdout.split()]
        subprocess.run(command, check=True)

    def load(self) -> ctypes.CDLL:
        """The loaded library."""
        made = ctypes.CDLL(str(self.path))
        made.sync_publisher.restype = ctypes.c_void_p
        return made


GAZEBO = Library(
    "gazebo", ("gazebo.cpp",), ("ignition-transport11", "ignition-msgs8"), ("g++", "-std=c++17")
)
CYCLONE = Library(
    "cyclone", ("cyclone.c", "ros2_messages.idl"), ("CycloneDDS",), ("gcc", "-std=c11")
)
LIBRARIES = {library.name: library for library in (GAZEBO, CYCLONE)}


class Publisher:
    """Sends wrenches or odometry to a topic."""

    def __init__(self, library: Library, topic: str, is_wrench: bool) -> None:
        self._library = library.load()
        publisher = self._library.sync_publisher(topic.encode(), ctypes.c_bool(is_wrench))
        self._publisher = ctypes.c_void_p(publisher)

    def send_wrench(self, word: str, wrench: Reals) -> None:
        """Sends a wrench (6,) under a word."""
        self._library.sync_send_wrench(self._publisher, word.encode(), _pointer(wrench))

    def send_odometry(self, row: Reals) -> None:
        """Sends time [s] and state (13,) as one row."""
        self._library.sync_send_odometry(self._publisher, _pointer(row))


def take_wrenches(library: Library, topic: str, act: Callable[[str, Reals], None]) -> None:
    """Calls `act` with word and wrench of each message, in a thread of the library."""
    made = _Take(lambda word, row: act(word.decode(), _row(row, 6)))
    _kept.append(made)
    library.load().sync_take_wrenches(topic.encode(), made)


def take_odometry(library: Library, topic: str, act: Callable[[float, Reals], None]) -> None:
    """Calls `act` with time [s] and state of each message, in a thread of the library."""

    def see(pointer: ctypes._Pointer[ctypes.c_double]) -> None:
        row = _row(pointer, 14)
        act(float(row[0]), row[1:])

    made = _See(see)
    _kept.append(made)
    library.load().sync_take_odometry(topic.encode(), made)


def _pointer(row: Reals) -> ctypes._Pointer[ctypes.c_double]:
    values = np.ascontiguousarray(row, np.float64)
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def _row(pointer: ctypes._Pointer[ctypes.c_double], size: int) -> Reals:
    return np.array(pointer[:size], np.float64)
