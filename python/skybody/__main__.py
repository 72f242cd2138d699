"""Where this installation keeps its parts for C++: `python -P -m skybody --cmake-dir`."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from . import __version__
from ._native import library_folder


def cmake_folder() -> Path | None:
    """The folder of SkybodyConfig.cmake, for `-DSkybody_DIR=`; None where none is installed."""
    libraries = Path(library_folder())
    installed, built = libraries / "cmake" / "Skybody", libraries.parent
    return next((f for f in (installed, built) if (f / "SkybodyConfig.cmake").is_file()), None)


def pkg_config_folder() -> Path | None:
    """The folder of skybody.pc, for PKG_CONFIG_PATH; None where none is installed."""
    folder = Path(library_folder()) / "pkgconfig"
    return folder if (folder / "skybody.pc").is_file() else None


FOLDERS = {
    "--cmake-dir": (cmake_folder, "the folder of SkybodyConfig.cmake, for -DSkybody_DIR="),
    "--pkg-config-dir": (pkg_config_folder, "the folder of skybody.pc, for PKG_CONFIG_PATH"),
}


def main(arguments: list[str] | None = None) -> int:
    """Prints the folder that is asked for; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -P -m skybody", description=__doc__)
    parser.add_argument("--version", action="version", version=__version__)
    wanted = parser.add_mutually_exclusive_group(required=True)
    for option, (find, text) in FOLDERS.items():
        wanted.add_argument(option, dest="wanted", action="store_const", const=find, help=text)
    folder = parser.parse_args(arguments).wanted()
    if folder is None:
        print(
            f"error: no files for C++ beside {library_folder()}; install the wheel `libskybody`, "
            "the Debian package `libskybody-dev`, or a build by `cmake --install`",
            file=sys.stderr,
        )
        return 2
    print(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
