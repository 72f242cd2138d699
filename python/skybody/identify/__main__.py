"""`skybody identify`: a vehicle from recorded flights; docs/identify.md.

skybody identify flight1.csv flight2.csv --map nanobench --model crazyflie
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from skybody import InputError
from skybody.arguments import MOST_THREADS
from skybody.command_line import CommandLine, real, report_error, whole
from skybody.program import run_program

EPILOG = """\
Writes into identified/NAME: vehicle.urdf and rotors.yaml, scenarios to train in, the randomization
that the flights leave open, report.md and report.json with intervals and prediction errors.
Examples:
  skybody identify a.csv b.csv --map nanobench --model crazyflie --test c.csv
  skybody identify log.ulg@20:80 --model my_drone.urdf --mass 0.82
  skybody identify flights/real --model my_drone.urdf --fix com.z
Exit status: 0 done, 2 invalid input, 130 interrupted."""


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    made = CommandLine(
        prog="skybody identify",
        description="Identifies a vehicle from recorded flights: thrust by command, lags, delays,\n"
        "inertias, drag, and offsets of sensors, with intervals.",
        epilog=EPILOG,
        allow_abbrev=False,
    )
    add = made.add_argument
    add(
        "logs",
        nargs="+",
        metavar="LOG",
        help=".csv, .ulg, .usd, .mcap or flight.h5; LOG@FROM:UNTIL: a part [s from its start]",
    )
    add("--model", required=True, metavar="URDF", help="nominal vehicle: URDF, or a shipped model")
    add("--rotors", default="", metavar="FILE", help="rotors file (rotors.yaml beside the URDF)")
    add("--map", default="", help="columns of the logs: a file, or a shipped map (docs/imports.md)")
    add("--mass", type=real(1e-3, 1e3), default=0.0, metavar="KG", help="in place of the URDF's")
    add(
        "--test",
        action="append",
        default=[],
        metavar="LOG",
        help="flight to judge by, may be repeated; default: the last quarter of each LOG",
    )
    add(
        "--fix",
        action="append",
        default=[],
        metavar="PARAMETER",
        help="keep this one nominal, such as com.z; may be repeated",
    )
    add(
        "--unit",
        action="append",
        default=[],
        metavar="SENSOR=UNIT",
        help="unit of gyro, accelerometer or voltage, in place of the map's",
    )
    add("--out", type=Path, metavar="DIR", help="folder to write (identified/NAME of the model)")
    add("--windows", type=whole(20, 5000), default=400, metavar="N", help="most to fit (400)")
    add(
        "--threads",
        type=whole(0, MOST_THREADS),
        default=0,
        metavar="T",
        help="0: one per processor",
    )
    return made


def units_of(texts: Sequence[str]) -> dict[str, str]:
    """The units of --unit.

    Raises:
        InputError: an unknown sensor, or a unit of something else.
    """
    from skybody.arguments import allowed_words
    from skybody.imports.units import UNITS

    from .reading import UNIT_OF

    si = {"gyro": "rad/s", "accelerometer": "m/s^2", "voltage": "V"}
    made = {}
    for text in texts:
        name, _, unit = text.partition("=")
        if name not in UNIT_OF:
            raise InputError(f"--unit {text}: no sensor `{name}`{allowed_words(name, UNIT_OF)}")
        allowed = [word for word, (_, base) in UNITS.items() if base == si[name]]
        if unit not in allowed:
            raise InputError(f"--unit {text}: allowed units: {', '.join(allowed)}")
        made[name] = unit
    return made


def identify_logs(options: argparse.Namespace) -> int:
    """Runs the identification and writes its folder."""
    from skybody.whole_output import whole_output

    from .identify import Options, identify
    from .reading import Log, read
    from .report import terminal, write_report
    from .vehicle import Vehicle
    from .writing import write_vehicle

    vehicle = Vehicle(options.model, options.rotors, options.mass)
    out = options.out or Path("identified") / vehicle.name
    if out.exists():
        raise InputError(f"{out}: exists; remove it, or give another --out")
    units = units_of(options.unit)
    flights = [read(Log.of(log), vehicle, options.map, units) for log in options.logs]
    tests = [read(Log.of(log), vehicle, options.map, units) for log in options.test]
    chosen = Options(options.windows, options.threads, tuple(options.fix))
    with whole_output(out) as part:  # fails before the fit if it cannot be written
        part.mkdir()
        made = identify(vehicle, flights, tests, chosen, lambda text: print(text, file=sys.stderr))
        scenarios = write_vehicle(made, part)
        write_report(made, part, scenarios)
    for note in made.notes:
        print(f"note: {note}", file=sys.stderr)
    print(terminal(made))
    print(out)
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command."""
    try:
        return identify_logs(parser().parse_args(arguments))
    except InputError as error:
        return report_error(str(error))


if __name__ == "__main__":
    run_program(main)
