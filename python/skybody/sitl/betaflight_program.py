"""Betaflight's SITL as a child: its settings by its command line, and a network of its own."""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import os
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

HOST = "127.0.0.1"
CONSOLE = 5761  # TCP, of its first serial port
STARTS, START = 3, 10.0  # tries until the console is open, and the longest wait of each [s]
ENTRIES, ENTRY = 5, 3.0  # tries to enter it, and the longest wait of each [s]
INSIDE = "SKYBODY_SITL_NETWORK"  # is set in the network of its own
TIMER_SLACK = 29  # PR_SET_TIMERSLACK: Betaflight sleeps 50 us in each loop
FLAGS_GET, FLAGS_SET, UP = 0x8913, 0x8914, 1  # of a network interface

SETTINGS = (
    "aux 0 0 0 1700 2100 0 0",  # ARM by the first switch
    "aux 1 1 1 1700 2100 0 0",  # ANGLE by the second one
    "set failsafe_delay = 200",  # [0.1 s]
    "set acc_calibration = 0,0,0,1",  # is true of the simulated accelerometer
)


def settings_for(frame: str) -> list[str]:
    """Lines of Betaflight's console for a frame of `motors.FRAMES`."""
    mixer = "QUADP" if frame.startswith("plus") else "QUADX"
    reverse = "ON" if frame.endswith("reversed") else "OFF"
    return [*SETTINGS, f"mixer {mixer}", f"set yaw_motors_reversed = {reverse}"]


def enter_own_network(command: Sequence[str]) -> None:
    """Replaces this process by `command`, itself once more, in a network with loopback alone.

    Betaflight listens on all interfaces; there nobody reaches it.

    Raises:
        ValueError: this system does not allow it.
    """
    if os.environ.get(INSIDE):
        loopback_up()
        return
    unshare = shutil.which("unshare")
    alone = [unshare or "unshare", "--map-root-user", "--net"]
    if unshare is None or subprocess.run([*alone, "true"], capture_output=True).returncode:
        raise ValueError(
            "Betaflight listens on all interfaces, and this system gives no network of its own "
            "(`unshare --map-root-user --net`); --shared-network starts it all the same"
        )
    os.environ[INSIDE] = "1"
    os.execv(unshare, [*alone, *command])


def loopback_up() -> None:
    """Switches the interface lo on."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        request = struct.pack("16sH14s", b"lo", 0, b"")
        flags = struct.unpack("16sH14s", fcntl.ioctl(any_socket, FLAGS_GET, request))[1]
        fcntl.ioctl(any_socket, FLAGS_SET, struct.pack("16sH14s", b"lo", flags | UP, b""))


def console(longest: float) -> socket.socket:
    """A connection to Betaflight's console.

    Raises:
        TimeoutError: there is none within `longest` seconds.
    """
    end = time.monotonic() + longest
    while True:
        try:
            return socket.create_connection((HOST, CONSOLE), timeout=1.0)
        except OSError:
            if time.monotonic() > end:
                raise TimeoutError from None
            time.sleep(0.1)


class BetaflightProgram:
    """A running SITL, in a temporary folder with its settings. A context manager.

    Raises:
        ValueError: it cannot be started, or refuses a setting.
    """

    def __init__(self, program: Path, settings: Sequence[str]) -> None:
        if not os.access(program, os.X_OK) or program.is_dir():
            raise ValueError(
                f"--program: {program} is no program; docs/sitl.md says how to build it"
            )
        ctypes.CDLL(None).prctl(TIMER_SLACK, 1, 0, 0, 0)
        self._program = program.resolve()
        self._folder = tempfile.TemporaryDirectory(prefix="skybody_sitl_")
        self.output = Path(self._folder.name) / "output.txt"
        self._process = self._started()
        try:
            self._configure(settings)
        except BaseException:
            self.close()
            raise

    def _started(self) -> subprocess.Popen[bytes]:
        with open(self.output, "ab") as output:
            return subprocess.Popen(
                [self._program], cwd=self._folder.name, stdout=output, stderr=output
            )

    def _configure(self, settings: Sequence[str]) -> None:
        """Sets and saves values, and starts the program anew with them."""
        with self._entered_console() as line:
            for setting in settings:
                text = answer(line, setting.encode() + b"\n", 5.0, b"# ")
                if b"ERROR" in text:
                    raise ValueError(
                        f"Betaflight refuses `{setting}`: {text.decode(errors='replace')}"
                    )
            answer(line, b"save\n", 3.0, b"Rebooting")
        self._end()
        self._process = self._started()

    def _entered_console(self) -> socket.socket:
        """The console with its prompt. Some starts on a busy machine answer to nothing."""
        for _ in range(ENTRIES):
            line = self.console()
            try:
                answer(line, b"#", ENTRY, b"Entering CLI")
                return line
            except ValueError as error:
                line.close()
                problem = error
                self.restart()
        raise problem

    def console(self) -> socket.socket:
        """A connection to its console.

        Raises:
            ValueError: it does not come up.
        """
        for _ in range(STARTS):
            try:
                return console(START)
            except TimeoutError:  # a start that hangs, on a busy machine
                self.restart()
        raise ValueError(
            f"{self._program} does not open TCP port {CONSOLE} in {STARTS} starts of {START:g} s"
        )

    def restart(self) -> None:
        """Ends it and starts it anew, with the saved settings."""
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()
        self._process = self._started()

    def check(self) -> None:
        """Raises ValueError if it has ended."""
        status = self._process.poll()
        if status is not None:
            raise ValueError(f"Betaflight ended with status {status}")

    def _end(self) -> None:
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(1.0)
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()

    def close(self) -> None:
        """Ends it and removes its folder."""
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()
        self._folder.cleanup()

    def __enter__(self) -> BetaflightProgram:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def answer(line: socket.socket, sent: bytes, longest: float, wanted: bytes) -> bytes:
    """Sends bytes and returns the answer, which ends with or after `wanted`.

    Raises:
        ValueError: it does not come within `longest` seconds.
    """
    line.sendall(sent)
    line.settimeout(0.1)
    text, end = b"", time.monotonic() + longest
    while wanted not in text:
        if time.monotonic() > end:
            raise ValueError(f"Betaflight's console does not answer to {sent!r}: {text[-200:]!r}")
        with contextlib.suppress(TimeoutError):
            text += line.recv(65536)
    return text
