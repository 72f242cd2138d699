"""The program onboard as a child process."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from skybody import InputError

NAME = "skybody_onboard"
_PORT = re.compile(r"link .*port (\d+)")


def find_program() -> list[str]:
    """The command line of the program: SKYBODY_ONBOARD, or that beside this installation.

    Raises:
        InputError: there is none.
    """
    if chosen := os.environ.get("SKYBODY_ONBOARD"):
        return chosen.split()
    package, tree = Path(__file__).parents[1], Path(__file__).parents[3]
    folders = [package / "bin", Path(sys.executable).parent, tree / "build" / "release" / "bin"]
    places = [folder / NAME for folder in folders]
    for place in places:
        if place.exists():
            return [str(place)]
    if found := shutil.which(NAME):
        return [found]
    raise InputError(f"there is no program {NAME}: build it, or name it in SKYBODY_ONBOARD")


def about(mission: Path) -> str:
    """The program's text about a mission.

    Raises:
        InputError: the program refuses it.
    """
    done = subprocess.run(
        [*find_program(), str(mission), "--about"], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise InputError(done.stderr.strip().removeprefix("error: "))
    return done.stdout


@contextlib.contextmanager
def running(
    mission: Path, options: Sequence[str] = ()
) -> Iterator[tuple[int, subprocess.Popen[str]]]:
    """Runs the program within this scope, at a free port of this machine.

    Yields:
        The port and the process.

    Raises:
        InputError: the program refuses the mission or an option.
    """
    command = [*find_program(), str(mission), "--listen", "127.0.0.1:0", *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None and process.stderr is not None
        for line in process.stdout:
            if found := _PORT.match(line):
                yield int(found[1]), process
                return
        raise InputError(process.stderr.read().strip().removeprefix("error: "))
    finally:
        process.terminate()
        process.communicate()
