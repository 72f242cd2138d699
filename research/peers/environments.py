"""The peers' virtual environments: .peers/NAME, recreated if requirements/NAME.txt changed."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import pathlib
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
FOLDER = ROOT / ".peers"
PIP = (
    *("-P", "-m", "pip", "install", "--disable-pip-version-check", "-q"),
    *("--retries", "1", "--timeout", "15"),  # [s] without data
)
# Patterns of locations in messages: addresses, paths, hosts as libraries print them, and strings
# that look like host names or numbers.
PLACES = (
    r"(\w+://|(?<!\w)/)[^\s'\"]+",
    r"\b(?:host|port)=(?:'[^']*'|\"[^\"]*\"|\w+)",
    r"(?<=\bresolve )(?:'[^']*'|\S+)",
    r"\b(?:[\w-]+\.)+(?:org|com|net|io|dev|lan|local|internal|localdomain)\b(?::\d+)?",
    r"\b\d+(?:\.\d+){3}\b(?::\d+)?",
)
failed: dict[str, str] = {}  # peers that could not be installed in this run, with reasons


class Skipped(Exception):
    """A peer that is not available here; the text is the reason."""


def workplace() -> pathlib.Path:
    """The working folder of scripts, since some libraries leave logs there."""
    FOLDER.mkdir(exist_ok=True)
    return FOLDER


def plain(text: str) -> str:
    """A reason without addresses, hosts and paths of this machine."""
    return " ".join(re.sub("|".join(PLACES), "...", text).split())[:300]


@contextlib.contextmanager
def alone() -> Iterator[None]:
    """Waits until no other run works in .peers, and locks it."""
    with (workplace() / "lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print("  waiting for another run of the peers to end", file=sys.stderr, flush=True)
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def python_of(name: str) -> pathlib.Path:
    """The peer's Python; installs its requirements first, if they changed.

    Raises:
        Skipped: the installation failed, now or before in this run.
    """
    if name in failed:
        raise Skipped(failed[name])
    try:
        return installed(name)
    except Skipped as why:
        failed[name] = str(why)
        raise


def installed(name: str) -> pathlib.Path:
    requirements = HERE / "requirements" / f"{name}.txt"
    if not requirements.is_file():
        raise Skipped(f"no requirements/{name}.txt")
    folder = FOLDER / name
    python, stamp = folder / "bin" / "python", folder / "requirements.sha256"
    wanted = hashlib.sha256(requirements.read_bytes()).hexdigest()
    if python.exists() and stamp.is_file() and stamp.read_text() == wanted:
        return python
    print(f"  installing {name} into .peers", file=sys.stderr, flush=True)
    shutil.rmtree(folder, ignore_errors=True)
    call([sys.executable, "-P", "-m", "venv", str(folder)])
    # torch first: otherwise another package could pull in its build for graphics cards (gigabytes).
    first = [line for line in requirements.read_text().split("\n") if line.startswith("torch==")]
    for wish in ([first] if first else []) + [["-r", str(requirements)]]:
        call([str(python), *PIP, *wish])
    stamp.write_text(wanted)
    return python


def call(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = [line for line in (done.stderr + done.stdout).splitlines() if line.strip()]
        errors = [line for line in lines if "error" in line.lower()] or lines or ["no reason given"]
        raise Skipped(f"not installed: {errors[-1]}")
