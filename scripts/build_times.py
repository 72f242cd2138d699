"""The slowest files of a build: a table of the longest steps, from ninja's log.

    python3 scripts/build_times.py [--build build/release] [--count 20]

Steps answered by ccache took no compiler time: for valid figures make a full build without it
(CCACHE_DISABLE=1 ./dev build).
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VERSION = "# ninja log v5"


@dataclass(frozen=True)
class Step:
    """One command of the build."""

    seconds: float
    output: str  # the output file, below the build folder


def read_steps(log: Path) -> list[Step]:
    """The last run of each command, the longest first.

    Raises SystemExit if the file is not a log of ninja.
    """
    try:
        lines = log.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise SystemExit(f"{log}: {error.strerror}; ./dev build makes it") from None
    if not lines or lines[0] != VERSION:
        raise SystemExit(f"{log}: begins with {lines[:1]}; allowed: {VERSION!r}")
    steps: dict[str, Step] = {}
    for line in lines[1:]:
        start, end, _, output, _ = line.split("\t")
        steps[output] = Step((int(end) - int(start)) / 1000, output)
    return sorted(steps.values(), key=lambda step: -step.seconds)


def table(steps: list[Step], count: int) -> str:
    """A table in Markdown, with the sum of all steps."""
    rows = [f"| {step.seconds:.1f} | {short(step.output)} |" for step in steps[:count]]
    total = sum(step.seconds for step in steps)
    head = ["| seconds | file |", "| --- | --- |"]
    return "\n".join([*head, *rows, f"\n{len(steps)} steps, {total / 60:.1f} minutes of one core."])


def short(output: str) -> str:
    """A path without the parts that CMake adds."""
    parts = [part for part in output.split("/") if part != "CMakeFiles"]
    return "/".join(part for part in parts if not part.endswith(".dir"))


def main() -> int:
    parser = argparse.ArgumentParser(description="list the slowest files of a build")
    parser.add_argument(
        "--build", type=Path, default=ROOT / "build/release", help="folder of the build"
    )
    parser.add_argument("--count", type=int, default=20, help="number of rows")
    options = parser.parse_args()
    print(table(read_steps(options.build / ".ninja_log"), options.count))
    return 0


if __name__ == "__main__":
    sys.exit(main())
