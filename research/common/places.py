"""Places of the repository that measurements read and write."""

from __future__ import annotations

import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAMS = ROOT / "build/release/bin"
PROGRAM = PROGRAMS / "skybody"
RESULTS = ROOT / "docs/results"
FLIGHTS = ROOT / "flights"


def shown(path: Path) -> str:
    """`path` for display: below the repository without its name."""
    absolute = path.resolve()
    return str(absolute.relative_to(ROOT) if absolute.is_relative_to(ROOT) else path)


def command_of(name: str) -> list[str]:
    """The command of a measurement, to which its options are appended.

    Its process finds this package wherever it runs: PYTHONPATH is set for all later processes.
    """
    paths = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    if str(ROOT) not in paths:
        os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), *filter(None, paths)])
    return [sys.executable, "-P", "-m", "research", "run", name]
