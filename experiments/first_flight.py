#!/usr/bin/env python3
"""Time from training to the first flight: `skybody train`, then `skybody run`, as typed by a user.

    .venv/bin/python experiments/first_flight.py [--turns 3] [--out DIR]

Each turn uses an empty folder and two commands; the second is printed in the last line of the
first. Seconds are wall clock, from the first command to the end of the second: start of
the programs, training with its checkpoints, all evaluations, the learning curve, the flight, its
log and its picture. Writes first_flight.md and its JSON. Installation is not included.
"""

from __future__ import annotations

import os
import re
import shlex
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from program_bench import PROGRAM
from skybody.program import run_program
from throughput import arguments, facts, machine_line, markdown_table, output_folder, write_report

SCENARIO = "hover_learn"
QUICK_STEPS = 200_000  # of --quick, too few to hover
FLY = re.compile(r"^fly it +(skybody run .+)$", re.MULTILINE)
SUMMARY = re.compile(r"^(\d+) steps in [\d.]+ s, ([\d,]+) steps/s", re.MULTILINE)
LAST_ERROR = re.compile(r"^position_error .* (\S+)$", re.MULTILINE)  # of the values at the end
WORKED = re.compile(r"^evaluation at .*: (.*)$", re.MULTILINE)
NAME = "first_flight"


class FlightError(RuntimeError):
    """A command that failed, or had unexpected output; the text is the whole message."""


def call(command: str, folder: Path) -> tuple[float, str]:
    """Runs a command in `folder`; returns its seconds and its output."""
    words = shlex.split(command)
    environment = {**os.environ, "SKYBODY_PYTHON": sys.executable}
    begin = time.perf_counter()
    done = subprocess.run(
        [str(PROGRAM), *words[1:]],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    seconds = time.perf_counter() - begin
    if done.returncode != 0:
        raise FlightError(f"`{command}` failed (exit code {done.returncode})\n{done.stderr}")
    return seconds, done.stdout


def found(pattern: re.Pattern[str], text: str, command: str) -> re.Match[str]:
    """The match of a pattern in a command's output. Raises FlightError if there is none."""
    match = pattern.search(text)
    if match is None:
        raise FlightError(f"`{command}` does not print {pattern.pattern}:\n{text}")
    return match


def turn(more: str) -> dict[str, Any]:
    """Runs one turn, from an empty folder to the end of the first flight."""
    train = f"skybody train {SCENARIO}{more}"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        training, said = call(train, folder)
        fly = found(FLY, said, train)[1]
        flight, told = call(fly, folder)
        pictures = list(folder.glob("flights/*/*.png"))
        if not pictures:
            raise FlightError(f"`{fly}` has drawn no picture")
    summary = found(SUMMARY, said, train)
    return {
        "commands": [train, fly],
        "steps": int(summary[1]),
        "steps_per_second": int(summary[2].replace(",", "")),
        "evaluation": found(WORKED, said, train)[1],
        "training_seconds": training,
        "flight_seconds": flight,
        "seconds": training + flight,
        "error_at_the_end": float(found(LAST_ERROR, told, fly)[1]),
    }


def page(content: dict[str, Any]) -> str:
    """The page."""
    rows = [
        ["turn", "training [s]", "flight [s]", "both [s]", "steps/s", "error at its end [m]"],
        *(
            [
                str(k + 1),
                f"{row['training_seconds']:.1f}",
                f"{row['flight_seconds']:.1f}",
                f"{row['seconds']:.1f}",
                f"{row['steps_per_second']:,}",
                f"{row['error_at_the_end']:.3f}",
            ]
            for k, row in enumerate(content["rows"])
        ),
    ]
    first = content["rows"][0]
    commands = "\n".join(f"    {command}" for command in first["commands"])
    median = statistics.median(row["seconds"] for row in content["rows"])
    return f"""# The first flight of a policy

    python experiments/{NAME}.py --turns {len(content["rows"])}

on {machine_line(content)}.

In an empty folder, where Skybody is installed:

{commands}

**{median:.0f} s from the first command to the end of the second** (median of {len(content["rows"])}
turns): the programs' start, training of {first["steps"]:,} steps with its checkpoints, all
evaluations, the learning curve, the flight, its log and its picture.

{markdown_table(rows)}

Error: distance from the place that is to be held. The last evaluation of the first turn:
{first["evaluation"]}.
"""


def main() -> int:
    """Measures, writes; returns the exit code."""
    parser = arguments(__doc__ or "")
    parser.add_argument(
        "--turns", type=int, metavar="N", help="number of turns; default: 3, with --quick 1"
    )
    options = parser.parse_args()
    folder = output_folder(parser, options)
    turns = options.turns or (1 if options.quick else 3)
    more = f" --total-steps {QUICK_STEPS}" if options.quick else ""
    try:
        content = {**facts(), "rows": [turn(more) for _ in range(turns)]}
    except FlightError as error:
        print(f"{NAME}: {error}", file=sys.stderr)
        return 2
    write_report(folder, NAME, page(content), content)
    return 0


if __name__ == "__main__":
    run_program(main)
