"""Fits gains of a chain of controllers to a vehicle; see docs/tune.md.

skybody tune ROBOT.urdf --chain position,attitude,ctbr
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
from pathlib import Path

from skybody.arguments import MOST_THREADS
from skybody.command_line import CommandLine, real, report_error, whole
from skybody.program import run_program
from skybody.train.files import explain

from . import report
from .draws import DrawRanges
from .tuner import HELD_OUT, TuneOptions, tune
from .vehicle import DEFAULT_CHAIN, TuneError, Vehicle

EPILOG = """\
Writes gains.yaml (to be included in a scenario), report.json and step_response.png. The same
options give the same gains: the search counts candidates, not seconds.
Examples:
  skybody tune my_robot.urdf
  skybody tune cf2p.urdf --rotors cf2p_rotors.yaml --wind 5 --out tuned/cf2p
  skybody tune qdrone2 --chain attitude,ctbr
  skybody tune qdrone2 --chain '[{plugin: ctbr, parameters: {max_rate: [6, 6, 3]}}]'
Exit status: 0 done, 2 invalid input, 130 interrupted."""


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = CommandLine(
        prog="skybody tune",
        description="Fits the gains of a chain of controllers to a vehicle, by simulation with "
        "random masses and wind.",
        epilog=EPILOG,
        allow_abbrev=False,
    )
    options, ranges = TuneOptions(), DrawRanges()
    add = made.add_argument
    add("model", metavar="ROBOT.urdf", help="URDF file, or the name of a shipped model")
    add("--rotors", default="", metavar="FILE", help="rotors file (rotors.yaml beside the URDF)")
    add(
        "--chain",
        default=DEFAULT_CHAIN,
        help=f"controllers, separated by commas, or a list as in YAML ({DEFAULT_CHAIN})",
    )
    add("--robot", default="quad", help="name of the robot in gains.yaml (quad)")
    add(
        "--fix",
        action="append",
        default=[],
        metavar="CONTROLLER.GAIN",
        help="do not change this gain; may be repeated",
    )
    add("--out", type=Path, metavar="DIR", help="folder for the results (tuned/NAME of the model)")
    add(
        "--seed",
        type=whole(0, 2**32 - 1),
        default=options.seed,
        help="seed of draws and search (0)",
    )
    add(
        "--candidates",
        type=whole(1, 1_000_000),
        default=options.evaluations,
        metavar="N",
        help=f"number of sets of gains to try ({options.evaluations})",
    )
    add(
        "--draws",
        type=whole(1, 1000),
        default=options.draws,
        metavar="N",
        help=f"number of vehicles and winds for each set ({options.draws})",
    )
    add(
        "--mass",
        type=real(0.0, 0.9),
        default=ranges.mass,
        metavar="SHARE",
        help=f"relative range of the masses, +- ({ranges.mass:g})",
    )
    add(
        "--wind",
        type=real(0.0, 30.0),
        default=ranges.wind,
        metavar="SPEED",
        help=f"largest wind, from any direction [m/s] ({ranges.wind:g})",
    )
    add(
        "--latency",
        type=real(0.0, 0.2),
        default=Vehicle.latency,
        metavar="TIME",
        help=f"latency between the last controller and the rotors [s] ({Vehicle.latency:g})",
    )
    add(
        "--dt",
        type=real(1e-5, 0.01),
        default=Vehicle.dt,
        metavar="TIME",
        help=f"physics step [s] ({Vehicle.dt:g})",
    )
    add(
        "--threads",
        type=whole(0, MOST_THREADS),
        default=0,
        metavar="T",
        help="number of threads, 0: one per processor; changes no gains",
    )
    add(
        "--plugin-path",
        action="append",
        default=[],
        metavar="DIR",
        help="folder to search for plugins first; may be repeated",
    )
    return made


class Bar:
    """A progress bar on stderr, only if that is a terminal."""

    WIDTH = 40

    def __init__(self) -> None:
        self._shown = sys.stderr.isatty()

    def __call__(self, tried: int, total: int, cost: float) -> None:
        if not self._shown:
            return
        done = min(self.WIDTH, self.WIDTH * tried // total)
        bar = "#" * done + "." * (self.WIDTH - done)
        print(
            f"\r[{bar}] {min(tried, total)}/{total}  cost {cost:.3f}",
            end="",
            file=sys.stderr,
            flush=True,
        )

    def clear(self) -> None:
        if self._shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def main() -> int:
    given = parser().parse_args()
    vehicle = Vehicle(
        model=given.model,
        rotors=given.rotors,
        chain=given.chain,
        dt=given.dt,
        latency=given.latency,
        plugin_path=tuple(given.plugin_path),
    )
    options = TuneOptions(
        seed=given.seed,
        evaluations=given.candidates,
        draws=given.draws,
        ranges=dataclasses.replace(DrawRanges(), mass=given.mass, wind=given.wind),
        fixed=tuple(given.fix),
        num_threads=given.threads,
    )
    bar = Bar()
    folder = given.out or Path("tuned") / vehicle.name
    try:
        vehicle.compile()  # reports mistakes before the folder is created
        folder.mkdir(parents=True, exist_ok=True)
        tuned = tune(vehicle, options, bar)
        bar.clear()
        files = report.write(tuned, folder, given.robot)
    except TuneError as error:
        bar.clear()
        return report_error(str(error))
    except OSError as error:
        bar.clear()
        return report_error(explain(error))
    print(report.table(tuned), end="")
    print(f"better on {tuned.better_draws} of {HELD_OUT} held-out draws; {tuned.seconds:.1f} s")
    if tuned.after.cost >= tuned.before.cost:
        print("the default gains fly as well: keep them, or take these for their margins")
    for fallen in report.fallen_margins(tuned):
        print(f"warning: the cost falls, and so does a margin: {fallen}")
    for file in files:
        print(file)
    return 0


if __name__ == "__main__":
    run_program(main)
