"""`skybody render`: films and pictures of flights.

skybody render flights/racing/flight.h5 -o racing.mp4
skybody render a/flight.h5 b/flight.h5 -o both.mp4 --ghost
skybody render flights/payload/flight.h5 -o still.png --at 3
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from skybody import InputError
from skybody.command_line import CommandLine, report_error
from skybody.program import run_program

from .cameras import CAMERAS
from .film import Film, Frame, Panel, Size, write
from .flight import Flight, open_flight
from .scene import Scene, Style
from .strip import Strip, tint

HIDDEN = ("goal", "reference", "contacts")
LONGEST = 1e9  # of a flight [s]
GAP = 4  # between views [pixels]
STRIP_SHARE = 0.24  # height of the plots, as a share of the film's


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    made = CommandLine(
        prog="skybody render",
        description="Draws flights as a film (.mp4, .gif, .webp, or a folder of PNG) or a picture.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = made.add_argument
    add("logs", nargs="+", metavar="LOG[:EPISODE]", help="flight.h5, or its folder")
    add("-o", "--out", type=Path, required=True, help="file to write")
    add(
        "--camera",
        default="orbit",
        help=f"views, side by side: {', '.join(CAMERAS)}, or several with commas",
    )
    add("--ghost", action="store_true", help="several logs in one world, the first one in full")
    add("--size", default="1920x1080", metavar="WxH", help="[pixels], even numbers")
    add("--rate", type=float, default=30.0, help="frames per second")
    add("--speed", type=float, default=1.0, help="2: twice as fast")
    add("--from", dest="first", type=float, default=0.0, help="start [s]")
    add("--to", dest="last", type=float, default=None, help="end [s]; default: the flight's")
    add("--at", type=float, default=None, help="one picture at this time [s]")
    add("--plot", default="", metavar="NAMES", help="plots below: columns of the log with commas")
    add("--trail", type=float, default=2.0, help="length of trails [s]; 0: none")
    add("--trail-color", default="speed", choices=("speed", "error", "robot"), help="of trails")
    add("--hide", default="", metavar="NAMES", help=f"leave out some of {', '.join(HIDDEN)}")
    add("--thrust", action="store_true", help="lines of the rotors' thrust")
    add("--field-of-view", type=float, default=60.0, help="horizontal [degrees]")
    return made


def scenes_of(flights: list[Flight], options: argparse.Namespace) -> list[Scene]:
    """One scene a flight."""
    hidden = {name for name in options.hide.split(",") if name}
    if unknown := sorted(hidden - {*HIDDEN}):
        raise InputError(f"--hide {unknown[0]}: unknown; allowed: {', '.join(HIDDEN)}")
    style = Style(
        trail=options.trail,
        trail_value="" if options.trail_color == "robot" else options.trail_color,
        thrust=options.thrust,
        goal="goal" not in hidden,
        reference="reference" not in hidden,
        contacts="contacts" not in hidden,
    )
    ghosts = [tint(k) if options.ghost and k > 0 else None for k in range(len(flights))]
    return [Scene(f, replace(style, ghost=g)) for f, g in zip(flights, ghosts, strict=True)]


def check_ranges(options: argparse.Namespace) -> None:
    """Raises InputError for the first number that is out of its range, or NaN."""
    for name, value, least, most in (
        ("--from", options.first, 0.0, LONGEST),
        ("--to", options.last, 0.0, LONGEST),
        ("--at", options.at, 0.0, LONGEST),
        ("--trail", options.trail, 0.0, LONGEST),
        ("--rate", options.rate, 1.0, 120.0),
        ("--speed", options.speed, 0.01, 100.0),
        ("--field-of-view", options.field_of_view, 10.0, 120.0),
    ):
        if value is not None and not least <= value <= most:
            raise InputError(f"{name} is {value:g}; allowed: {least:g} to {most:g}")


def size_of(options: argparse.Namespace) -> Size:
    """The film's size.

    Raises:
        InputError: it cannot be drawn.
    """
    words = options.size.lower().split("x")
    if len(words) != 2 or not all(word.isdecimal() for word in words):
        raise InputError(f"--size is `{options.size}`; allowed: WIDTHxHEIGHT, such as 1280x720")
    width, height = int(words[0]), int(words[1])
    if not (64 <= width <= 3840 and 64 <= height <= 2160) or width % 2 or height % 2:
        raise InputError(f"--size is {width}x{height}; allowed: even numbers, 64x64 to 3840x2160")
    return Size(width, height, options.rate, float(np.radians(options.field_of_view)))


def panels_of(
    scenes: list[Scene], cameras: list[str], ghost: bool, size: Size, height: int
) -> list[Panel]:
    """A grid: a column for each world, or each camera of the only one."""
    worlds = [tuple(scenes)] if ghost else [(scene,) for scene in scenes]
    cells = [(world, name) for world in worlds for name in cameras]
    columns = int(np.ceil(np.sqrt(len(cells))))
    rows = int(np.ceil(len(cells) / columns))
    width, tall = (size.width + GAP) // columns - GAP, (height + GAP) // rows - GAP
    places = [(k % columns * (width + GAP), k // columns * (tall + GAP)) for k in range(len(cells))]
    return [Panel(world, name, *places[k], width, tall) for k, (world, name) in enumerate(cells)]


def counted(frames: Iterator[Frame], of: int) -> Iterator[Frame]:
    """The frames, with a bar on a terminal."""
    for done, frame in enumerate(frames, start=1):
        yield frame
        if sys.stderr.isatty():
            bar = "#" * (30 * done // of)
            end = "\n" if done == of else ""
            print(f"\r[{bar:<30}] {done} of {of} frames", end=end, file=sys.stderr, flush=True)


def render(options: argparse.Namespace) -> int:
    """Writes the film."""
    check_ranges(options)
    size = size_of(options)
    flights = [open_flight(log) for log in options.logs]
    scenes = scenes_of(flights, options)
    names = [name for name in options.plot.split(",") if name]
    below = 2 * int(STRIP_SHARE * size.height / 2) if names else 0
    strip = Strip(flights, names, size.width, below) if names else None
    cameras = options.camera.split(",")
    film = Film(panels_of(scenes, cameras, options.ghost, size, size.height - below), size)

    def finish(frame: Frame, time: float) -> Frame:
        if strip is not None:
            frame[size.height - below :] = strip.at(time)
        return frame

    last = film.duration if options.last is None else min(options.last, film.duration)
    step = options.speed / size.rate
    times = np.arange(options.first, last + 0.5 * step, step)
    if options.at is not None:
        if options.at > film.duration:
            raise InputError(f"--at is {options.at:g}; the flight ends at {film.duration:g} s")
        times = np.array([options.at])
    elif options.out.suffix == ".png":
        times = np.array([0.5 * (options.first + last)])
    if len(times) == 0:
        raise InputError(f"no frames between --from {options.first:g} and --to {last:g}")
    write(options.out, size, counted(film.frames(list(times), finish), len(times)))
    kind = "picture" if len(times) == 1 else "film" if options.out.suffix else "frames"
    print(f"{kind:9}{options.out}")
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command."""
    try:
        return render(parser().parse_args(arguments))
    except InputError as error:
        return report_error(str(error))


if __name__ == "__main__":
    run_program(main)
