"""Gazebo Transport in Python: gazebo.cpp, compiled at its first use."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np

from research.sync.work import Reals

SOURCE = Path(__file__).with_name("gazebo.cpp")
LIBRARY = Path(__file__).resolve().parents[2] / ".peers/sync/libgazebo_sync.so"
PACKAGES = ("ignition-transport11", "ignition-msgs8")
LOCAL = {"IGN_IP": "127.0.0.1"}  # only the loopback interface

_Take = ctypes.CFUNCTYPE(None, ctypes.c_char_p, ctypes.POINTER(ctypes.c_double))
_See = ctypes.CFUNCTYPE(None, ctypes.POINTER(ctypes.c_double))
_kept: list[object] = []  # functions that the library calls live as long as the process


def is_there() -> bool:
    """Whether the headers of Gazebo Transport are installed."""
    try:
        found = subprocess.run(["pkg-config", "--exists", *PACKAGES], check=False)
    except OSError:
        return False
    return found.returncode == 0


def build() -> None:
    """Compiles the library if its source has changed."""
    if LIBRARY.exists() and LIBRARY.stat().st_mtime >= SOURCE.stat().st_mtime:
        return
    LIBRARY.parent.mkdir(parents=True, exist_ok=True)
    flags = subprocess.run(
        ["pkg-config", "--cflags", "--libs", *PACKAGES], capture_output=True, text=True, check=True
    ).stdout.split()
    compiler = ["g++", "-std=c++17", "-O2", "-shared", "-fPIC", "-o", str(LIBRARY)]
    subprocess.run([*compiler, str(SOURCE), *flags], check=True)


def library() -> ctypes.CDLL:
    """The loaded library."""
    made = ctypes.CDLL(str(LIBRARY))
    made.sync_publisher.restype = ctypes.c_void_p
    return made


class Publisher:
    """Sends wrenches or odometry to a topic."""

    def __init__(self, topic: str, is_wrench: bool) -> None:
        self._library = library()
        publisher = self._library.sync_publisher(topic.encode(), ctypes.c_bool(is_wrench))
        self._publisher = ctypes.c_void_p(publisher)

    def send_wrench(self, word: str, wrench: Reals) -> None:
        """Sends a wrench (6,) under a word."""
        self._library.sync_send_wrench(self._publisher, word.encode(), _pointer(wrench))

    def send_odometry(self, row: Reals) -> None:
        """Sends time [s] and state (13,) as one row."""
        self._library.sync_send_odometry(self._publisher, _pointer(row))


def take_wrenches(topic: str, act: Callable[[str, Reals], None]) -> None:
    """Calls `act` with word and wrench of each message, in a thread of the library."""
    made = _Take(lambda word, row: act(word.decode(), _row(row, 6)))
    _kept.append(made)
    library().sync_take_wrenches(topic.encode(), made)


def take_odometry(topic: str, act: Callable[[float, Reals], None]) -> None:
    """Calls `act` with time [s] and state of each message, in a thread of the library."""

    def see(pointer: ctypes._Pointer[ctypes.c_double]) -> None:
        row = _row(pointer, 14)
        act(float(row[0]), row[1:])

    made = _See(see)
    _kept.append(made)
    library().sync_take_odometry(topic.encode(), made)


def _pointer(row: Reals) -> ctypes._Pointer[ctypes.c_double]:
    values = np.ascontiguousarray(row, np.float64)
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def _row(pointer: ctypes._Pointer[ctypes.c_double], size: int) -> Reals:
    return np.array(pointer[:size], np.float64)
