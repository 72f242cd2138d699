#!python
"""The command `skybody` of an installed package: the program inside a package's folder."""

import importlib.util
import os
import sys
from pathlib import Path


def programs():
    """The wheel `libskybody` has the program; a build by `pip install .` has it in `skybody`."""
    for name in ("libskybody", "skybody"):
        package = importlib.util.find_spec(name)  # finds without importing: that takes a second
        if package is not None and package.origin is not None:
            yield Path(package.origin).parent / "bin" / "skybody"


program = next((p for p in programs() if p.is_file()), None)
if program is None:
    sys.exit("skybody: this Python has no package with the program: pip install libskybody")
os.environ.setdefault("SKYBODY_PYTHON", sys.executable)  # trains, and draws the pictures
os.execv(program, ["skybody", *sys.argv[1:]])
