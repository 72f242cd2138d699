"""Runs of the two processes through a middleware, and of the one process without."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import skybody

from research.common.places import ROOT
from research.common.programs import RunError, output_of
from research.sync import native
from research.sync.agent import Trials
from research.sync.counting import Counted, counted
from research.sync.in_process import DirectLink
from research.sync.work import ACTS, STEPS

LONGEST = 5.0  # of a trial, with its beginning [s]
PATIENCE = 30.0  # for the start of a process or its file [s]


OURS = Path(sys.executable)
ROS1, ROS2 = (ROOT / f".peers/{name}/bin/python" for name in ("ros1", "ros"))


@dataclass(frozen=True)
class Middleware:
    """A way from the policy's process to the simulator's."""

    agent: str  # name of the policy's end
    server: str  # name of the simulator's end
    title: str
    python: Path = OURS  # of the policy's process
    server_python: Path = OURS  # of the simulator's process
    library: native.Library | None = None

    @property
    def is_there(self) -> bool:
        """Whether it is installed."""
        pythons = self.python.exists() and self.server_python.exists()
        return pythons and (self.library is None or self.library.is_there)


MIDDLEWARES = (
    Middleware("ros2", "ros2", "ROS 2, Fast DDS", ROS2, ROS2),
    Middleware(
        "cyclone",
        "ros2",
        "ROS 2, Cyclone DDS to Fast DDS",
        server_python=ROS2,
        library=native.CYCLONE,
    ),
    Middleware("gazebo", "gazebo", "Gazebo Transport 11", library=native.GAZEBO),
    Middleware("ros1", "ros1", "ROS 1", ROS1, ROS1),
)


def free_port() -> int:
    """A port on the loopback interface that nobody uses."""
    with socket.socket() as made:
        made.bind(("127.0.0.1", 0))
        return int(made.getsockname()[1])


def environment(port: int, folder: str) -> dict[str, str]:
    """Variables that keep each middleware to itself and on the loopback interface."""
    paths = [str(ROOT), str(Path(skybody.__file__).parents[1])]
    own = {
        "PYTHONPATH": os.pathsep.join(paths),
        "ROS_DOMAIN_ID": str(os.getpid() % 90 + 1),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_IP": "127.0.0.1",
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_HOME": folder,
        "ROS_LOG_DIR": folder,
        "IGN_PARTITION": f"skybody_{os.getpid()}",
    }
    return os.environ | own | native.LOCAL


@contextlib.contextmanager
def running(command: list[str], variables: dict[str, str], first: str = "") -> Iterator[None]:
    """A process that is ended at the end.

    Args:
        first: its first line of output; empty: nobody waits for one.

    Raises:
        RunError: it says something else.
    """
    with subprocess.Popen(command, env=variables, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            if first and (line := process.stdout.readline().strip()) != first:
                raise RunError(f"{' '.join(command)} says `{line}`")
            yield
        finally:
            process.terminate()


@contextlib.contextmanager
def serving(way: Middleware, is_free: bool, rows: Path) -> Iterator[dict[str, str]]:
    """The simulator's process, and a master if the middleware needs one; their variables."""
    variables = environment(free_port(), str(rows.parent))
    if way.library is not None:
        way.library.build()
    command = [str(way.server_python), "-m", "research.sync.server", way.server]
    free = ["--free"] if is_free else []
    with contextlib.ExitStack() as stack:
        if way.server == "ros1":
            port = variables["ROS_MASTER_URI"].rpartition(":")[2]
            stack.enter_context(running(["rosmaster", "--core", "-p", port], variables))
            wait_for_port(int(port))
        words = ["--out", str(rows), *free]
        stack.enter_context(running([*command, *words], variables, "ready"))
        yield variables


def wait_for_port(port: int) -> None:
    """Waits until something listens on a port of the loopback interface.

    Raises:
        RunError: nothing does.
    """
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 1.0):
            return
        time.sleep(0.05)
    raise RunError(f"nothing listens on port {port}")


def agent_of(way: Middleware, loop: str, *words: str) -> list[str]:
    """The command of the policy's process."""
    return [str(way.python), "-m", "research.sync.agent", way.agent, "--loop", loop, *words]


def flown(way: Middleware, loop: str, trials: int, is_free: bool) -> Counted:
    """Trials through a middleware."""
    with tempfile.TemporaryDirectory() as folder:
        rows, notes = Path(folder, "rows.npy"), Path(folder, "trials.npz")
        words = ["--trials", str(trials), "--out", str(notes), *(["--free"] if is_free else [])]
        with serving(way, is_free, rows) as variables:
            output_of(agent_of(way, loop, *words), PATIENCE + LONGEST * trials, env=variables)
            until = time.monotonic() + PATIENCE
            while not rows.exists():
                if time.monotonic() > until:
                    raise RunError(f"{way.title}: the simulator has written no file")
                time.sleep(0.05)
        found = np.load(notes)
        repeat = 1 if is_free else STEPS
        return counted(np.load(rows), found["actions"], found["came"], repeat)


def flown_in_process(loop: str, trials: int) -> Counted:
    """Trials without middleware."""
    link, notes = DirectLink(), Trials()
    for trial in range(trials):
        notes.fly(link, ACTS[loop](), trial, is_free=False)
    rows = np.array(link.bridge.rows)
    return counted(rows, np.array(notes.actions), np.array(notes.came), STEPS)


def newest_rate(way: Middleware, seconds: float) -> dict[str, Any]:
    """Steps that do not wait, in real time: agent.newest_steps."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "found.json")
        words = ["--free", "--newest", str(seconds), "--out", str(out)]
        with serving(way, True, Path(folder, "rows.npy")) as variables:
            output_of(agent_of(way, "open", *words), PATIENCE + seconds, env=variables)
        return dict(json.loads(out.read_text()))
