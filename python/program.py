#!python
"""The command `skybody` of an installed package: the program inside the package's folder."""

import importlib.util
import os
import sys
from pathlib import Path

package = importlib.util.find_spec("skybody")  # finds without importing: that takes a second
if package is None or package.origin is None:
    sys.exit("skybody: no package `skybody` for this Python: pip install . in its source tree")
program = Path(package.origin).parent / "bin" / "skybody"
os.environ.setdefault("SKYBODY_PYTHON", sys.executable)  # draws the pictures
os.execv(program, ["skybody", *sys.argv[1:]])
