"""Why the native module does not load, with the remedy."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import NoReturn

TOO_OLD = ("GLIBC_", "GLIBCXX_")
REINSTALL = "install the wheels `skybody` and `libskybody` of one version"


def refuse(problem: ImportError) -> NoReturn:
    """Raises the error of `import skybody`; where the program runs us, exits with its one line."""
    if "SKYBODY_PROGRAM_VERSION" not in os.environ:
        raise problem
    print(f"error: {problem}", file=sys.stderr)
    sys.exit(2)


def native_problem(error: ImportError) -> ImportError:
    """The error of `import skybody` where its native module failed with `error`.

    Raises:
        KeyboardInterrupt: Ctrl-C came while the module was initialized.
    """
    if isinstance(error.__cause__, KeyboardInterrupt):
        raise error.__cause__ from None
    return ImportError(f"skybody: {_problem(error)}", name="skybody")


def version_problem(*, package: str, library: str, program: str) -> ImportError | None:
    """The error of parts of two versions; None if all have one.

    Args:
        package: for which the Python package was built.
        library: of the libskybody that is loaded.
        program: of the program that started this Python.
    """
    here = Path(__file__).parent
    if package != library:
        said = f"the package in {here} is {package}, its library is {library}: {REINSTALL}"
    elif package != program:
        said = (
            f"the program is {program}, the Python package in {here} is {package}: start the "
            "program of this Python's environment, or name a Python with the package of that "
            "version in SKYBODY_PYTHON"
        )
    else:
        return None
    return ImportError(f"skybody: {said}", name="skybody")


def _problem(error: ImportError) -> str:
    text = str(error)
    if isinstance(error, ModuleNotFoundError):
        version = ".".join(map(str, sys.version_info[:2]))
        return (
            f"its native module is not built for this Python, {version} ({text}): install the "
            "wheel of this version, or run `./dev build` in the source tree and use "
            ".venv/bin/python"
        )
    if any(name in text for name in TOO_OLD):
        return f"this system's C or C++ library is too old ({text}): build it here from source"
    if "libskybody" in text and "cannot open shared object" in text:
        return f"its library is missing ({text}): {REINSTALL}"
    if missing := re.search(r"(lib\S+): cannot open shared object", text):
        return (
            f"this system has no {missing[1]}: install the package that has it (Debian: "
            f"`apt install libstdc++6`, or the one that `apt-file search {missing[1]}` names)"
        )
    return f"its native module does not load ({text}): {REINSTALL}"
