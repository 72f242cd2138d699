"""Why the native module does not load, with the remedy."""

from __future__ import annotations

import sys

TOO_OLD = ("GLIBC_", "GLIBCXX_")
REINSTALL = "install the wheels `skybody` and `libskybody` of one version"


def native_problem(error: ImportError) -> ImportError:
    """The error of `import skybody` where its native module failed with `error`."""
    return ImportError(f"skybody: {_problem(error)}", name="skybody")


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
    return f"its native module does not load ({text}): {REINSTALL}"
