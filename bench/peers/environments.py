"""The peers' virtual environments: .peers/NAME, made anew where requirements/NAME.txt changed."""

from __future__ import annotations

import hashlib
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
FOLDER = ROOT / ".peers"


class Skipped(Exception):
    """A peer that cannot be had here; the text says why."""


def workplace() -> pathlib.Path:
    """Where scripts run, since some libraries leave logs where they do."""
    FOLDER.mkdir(exist_ok=True)
    return FOLDER


def plain(text: str) -> str:
    """A reason without addresses and paths, which are this machine's business."""
    return " ".join(re.sub(r"(\w+://|(?<!\w)/)[^\s'\"]+", "...", text).split())[:300]


def python_of(name: str) -> pathlib.Path:
    """The peer's Python; installs what it needs first, if it changed since it was installed.

    Raises:
        Skipped: that failed.
    """
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
    call([sys.executable, "-m", "venv", str(folder)])
    # torch first: another package could draw in its build for graphics cards, gigabytes of it.
    first = [line for line in requirements.read_text().split("\n") if line.startswith("torch==")]
    for wish in ([first] if first else []) + [["-r", str(requirements)]]:
        call([str(python), "-m", "pip", "install", "--disable-pip-version-check", "-q", *wish])
    stamp.write_text(wanted)
    return python


def call(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = [line for line in (done.stderr + done.stdout).splitlines() if line.strip()]
        errors = [line for line in lines if "error" in line.lower()] or lines or ["no reason given"]
        raise Skipped(f"not installed: {errors[-1]}")
