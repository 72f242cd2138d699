"""`skybody export`: flights and policies in the formats of other programs.

skybody export flights/racing --to mcap
skybody export flights/racing/flight.h5:2 --to csv -o lap.csv --from 3 --until 6
skybody export runs/first --to c -o firmware/policy --check 3
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from skybody import InputError
from skybody.command_line import CommandLine, real, report_error, whole
from skybody.look.flight import log_and_episode, log_file, open_flight
from skybody.program import run_program
from skybody.whole_output import refuse_source, whole_output

from .formats import FLIGHT, FORMATS, POLICY, Format
from .policy.lockstep import Different
from .policy.source import SHIPPED, PolicySource, open_policy
from .table import Span, Table

STORAGES = ("sqlite3", "mcap")
DIFFERENT = 1  # exit code of a policy whose export is not equal


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    made = CommandLine(
        prog="skybody export",
        description="Writes a flight or a policy in a format of other programs.\n\n"
        + "\n".join(f"  --to {row.name:<9}{row.help}" for row in FORMATS.values()),
    )
    add = made.add_argument
    add(
        "source",
        metavar="LOG[:EPISODE] or POLICY",
        help="flight.h5, or its folder; a policy.h5, the folder of a training run, or `shipped`",
    )
    add("--to", required=True, choices=list(FORMATS), help="format")
    add("-o", "--out", type=Path, help="file or folder to write (default: beside the source)")
    add("--from", dest="start", type=real(0.0, 1e9), metavar="T", help="first time [s]")
    add("--until", type=real(0.0, 1e9), metavar="T", help="last time [s]")
    add("--every", type=whole(1, 10**9), metavar="N", help="each N-th row alone")
    add("--datasets", metavar="NAMES", help="of the log, with commas (default: all)")
    add(
        "--images",
        nargs="?",
        const="onboard",
        metavar="CAMERA",
        help="also pictures, 10 a second, by a camera of `skybody render` (default: onboard)",
    )
    add("--storage", choices=STORAGES, help="of rosbag2's messages (default: sqlite3)")
    add("--scenario", metavar="NAME", help="of a policy (default: the one it was trained in)")
    add("--set", action="append", metavar="PATH=VALUE", help="of that scenario, as `skybody run`")
    add("--plugin-path", action="append", type=Path, metavar="DIR", help="likewise")
    add("--map", type=Path, help="YAML file: observations that are a policy.onnx's inputs")
    add("--name", help="of a policy's functions and files (default: the scenario's)")
    add("--robot", help="of a mission: which of those that share the policy")
    add(
        "--limit",
        action="append",
        metavar="NAME=V,...",
        help="of a mission: stale, lateness, tilt, fence, safe, safe_thrust, safe_time",
    )
    add(
        "--check",
        type=whole(1, 10**6),
        metavar="N",
        help="fly N episodes by the policy and by its export, and compare every action",
    )
    return made


def table_of(options: argparse.Namespace) -> Table:
    """The rows of a flight that the options choose."""
    span = Span(
        first=options.start or 0.0,
        last=float("inf") if options.until is None else options.until,
        every=options.every or 1,
    )
    only = [name for name in (options.datasets or "").split(",") if name]
    return Table(open_flight(options.source, has_bodies=False), span, only)


SOURCES: dict[str, Callable[[argparse.Namespace], Any]] = {FLIGHT: table_of, POLICY: open_policy}


def check_options(options: argparse.Namespace, form: Format) -> None:
    """Raises InputError for an option that the format does not take."""
    words = {"start": "--from", "plugin_path": "--plugin-path"}
    for name, value in vars(options).items():
        if name not in ("source", "to", "out", *form.takes) and value is not None:
            fit = ", ".join(row.name for row in FORMATS.values() if name in row.takes)
            raise InputError(
                f"{words.get(name, f'--{name}')} is not for --to {form.name}; allowed: {fit}"
            )


def default_out(source: str, form: Format, opened: Any) -> Path:
    """The file beside the source: `flight.mcap`, or `flight-3.mcap` of episode 3.

    Of a policy `racing_c` or `racing.onnx`; of a shipped one, in the working folder.
    """
    if isinstance(opened, PolicySource):
        folder = Path(source) if Path(source).is_dir() else Path(source).parent
        return (Path() if source == SHIPPED else folder) / f"{opened.name}{form.ending}"
    path, episode = log_and_episode(source)
    log = log_file(path)
    number = "" if episode is None else f"-{episode}"
    return log.with_name(f"{log.stem}{number}{form.ending}")


def export(options: argparse.Namespace) -> int:
    """Writes the file."""
    form = FORMATS[options.to]
    check_options(options, form)
    write = form.writer()
    source = SOURCES[form.reads](options)
    out = options.out or default_out(options.source, form, source)
    refuse_source(out, log_file(log_and_episode(options.source)[0]))
    with whole_output(out) as part:
        write(source, part, options)
    print(f"{form.name:<8} {out}")
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command."""
    try:
        return export(parser().parse_args(arguments))
    except InputError as error:
        return report_error(str(error))
    except Different as error:
        print(f"error: {error}", file=sys.stderr)
        return DIFFERENT


if __name__ == "__main__":
    run_program(main)
