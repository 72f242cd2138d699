"""Lines of code of C++ files, without blank lines and lines that only contain a comment.

python3 scripts/code_lines.py core/physics [core/env ...]

Prints the number of each given folder or file. For a past commit give `--at COMMIT`.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SUFFIXES = (".h", ".cpp")
# Strings first, so that comment markers inside them stay.
TOKENS = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|//[^\n]*|/\*.*?\*/', re.DOTALL)


def count_lines(text: str) -> int:
    """Lines that hold code."""

    def keep(match: re.Match[str]) -> str:
        token = match.group()
        return "\n" * token.count("\n") if token.startswith("/") else token

    return sum(1 for line in TOKENS.sub(keep, text).splitlines() if line.strip())


def git(*arguments: str) -> str:
    """Output of git."""
    result = subprocess.run(
        ["git", "-C", str(ROOT), *arguments], capture_output=True, text=True, check=True
    )
    return result.stdout


def lines_at(commit: str, path: str) -> int:
    """Lines of code of a folder or file in a commit."""
    names = git("ls-tree", "-r", "--name-only", commit, "--", path).splitlines()
    return sum(
        count_lines(git("show", f"{commit}:{name}")) for name in names if name.endswith(SUFFIXES)
    )


def lines_now(path: str) -> int:
    """The same in the work tree."""
    place = ROOT / path
    files = [place] if place.is_file() else sorted(place.rglob("*"))
    return sum(count_lines(f.read_text(encoding="utf-8")) for f in files if f.suffix in SUFFIXES)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "paths", nargs="+", help="folders or files, relative to the root of the project"
    )
    parser.add_argument("--at", metavar="COMMIT", help="count in this commit instead")
    arguments = parser.parse_args()
    for path in arguments.paths:
        count = lines_at(arguments.at, path) if arguments.at else lines_now(path)
        print(f"{path} {count}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
