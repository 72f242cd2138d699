"""`skybody import`: a flight log of a real flight.

skybody import flight.csv --map nanobench
skybody import log.ulg --model my_drone.urdf --from 12 --until 40
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from skybody import InputError
from skybody.command_line import CommandLine, real, report_error
from skybody.program import run_program
from skybody.whole_output import refuse_source, whole_output

from .map_file import find_map, read_map, shipped_maps
from .sources import Source, source_of


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    made = CommandLine(
        prog="skybody import",
        description="Makes a flight log of a real flight: CSV, ULog (PX4), the Crazyflie's\n"
        "micro-SD log (.usd), or MCAP.",
    )
    add = made.add_argument
    add("log", type=Path, metavar="FILE", help=".csv, .csv.gz, .ulg, .usd, .usd.gz or .mcap")
    add("--map", metavar="MAP", help=f"map.yaml, or a shipped one: {', '.join(shipped_maps())}")
    add("-o", "--out", type=Path, help="flight.h5 to write (default: flights/NAME/flight.h5)")
    add("--model", metavar="URDF", default="", help="of the only robot, in place of the map's")
    add("--from", dest="first", type=real(0.0, 1e9), default=0.0, metavar="T", help="start [s]")
    add("--until", type=real(0.0, 1e9), default=float("inf"), metavar="T", help="end [s]")
    return made


def map_name(options: argparse.Namespace, source: Source) -> str:
    """The map of the options, or the usual one of the kind of log."""
    if options.map or source.map:
        return str(options.map or source.map)
    raise InputError(
        f"{options.log}: --map is missing: a file, or a shipped one: {', '.join(shipped_maps())}"
    )


def name_of(log: Path) -> str:
    """Name of the flight: that of the file without its endings."""
    return log.name.partition(".")[0] or "flight"


def import_log(options: argparse.Namespace) -> int:
    """Writes the flight log."""
    from .flight import build
    from .log_file import write

    source, log, notes = source_of(options.log), None, []
    name = name_of(options.log)
    if not options.map:
        log = source.restore(options.log)
    if log is None:
        used = read_map(find_map(map_name(options, source)), options.model)
        channels = source.read(options.log, used)
        made = build(channels, used, name, options.first, options.until)
        log, notes = made.log(options.log.name), channels.notes
    out = options.out or Path("flights") / name / "flight.h5"
    refuse_source(out, options.log)
    with whole_output(out) as part:
        write(part, log)
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    bodies = len(log.bodies) if "bodies" in log.datasets else 0
    count = "1 body" if bodies == 1 else f"{bodies} bodies"
    print(f"flight   {log.time[-1]:.3f} s, {len(log.time)} rows, {count}")
    print(f"log      {out}")
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command."""
    try:
        return import_log(parser().parse_args(arguments))
    except InputError as error:
        return report_error(str(error))


if __name__ == "__main__":
    run_program(main)
