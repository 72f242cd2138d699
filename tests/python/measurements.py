"""Modules of research/ by name, and commands that run measurements as a user does."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).resolve().parents[2]
RUN = (sys.executable, "-P", "-m", "research", "run")  # with ENVIRONMENT
ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": ":".join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")])),
}


def module(name: str) -> ModuleType:
    """Imports a module of research/ by its file's name, which is unique but for peers' programs."""
    files = [file for file in ROOT.glob(f"research/**/{name}.py") if file.parent.name != "peers"]
    (file,) = files
    return importlib.import_module(".".join(file.relative_to(ROOT).with_suffix("").parts))


def run(
    name: str, *options: str, timeout: float = 110.0, **more: str
) -> subprocess.CompletedProcess[str]:
    """Runs a measurement; `more`: variables of its environment."""
    return subprocess.run(
        [*RUN, name, *options],
        env={**ENVIRONMENT, **more},
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )
