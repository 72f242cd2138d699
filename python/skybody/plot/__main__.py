"""`skybody plot`: pictures of the flights of a log, one per episode.

skybody plot flights/hover
skybody plot flights/hover --pdf --panels z,yaw,path
skybody plot flights/hover --style paper --panels path,error --out figures
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

from skybody import InputError
from skybody.command_line import CommandLine, report_error, whole
from skybody.program import run_program

try:
    import h5py  # noqa: F401
    import matplotlib
except ImportError as error:
    sys.exit(f"error: {sys.executable} has no {error.name}; pip install matplotlib h5py")

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from skybody.look.flight import Flight, log_and_episode, open_flight
from skybody.whole_output import whole_output

from .page import PANELS, PATH, draw_chosen, draw_for_paper, draw_page, names_on_page
from .panels import STYLE
from .subject import Subject

DPI = 150
# Without times, so that the same flight gives the same file.
METADATA: dict[str, dict[str, None]] = {
    "png": {}, "pdf": {"CreationDate": None}, "svg": {"Date": None},
}  # fmt: skip


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    made = CommandLine(
        prog="skybody plot",
        description="Draws the flights of a log, one picture per episode.",
    )
    add = made.add_argument
    add("log", metavar="LOG[:EPISODE]", help="flight.h5, or its folder")
    add("--pdf", action="store_true", help="PDF instead of PNG")
    add(
        "--style",
        choices=("page", "paper"),
        default="page",
        help="paper: a PDF and an SVG for each panel, 88 mm wide, 8 pt, without a title",
    )
    add(
        "--panels",
        type=panel_names,
        metavar="A,B,...",
        help=f"only these panels, one below another: {', '.join(PANELS)}",
    )
    add("--out", type=Path, help="folder of the pictures (default: the log's)")
    add("--most", type=whole(1, 10**6), default=3, help="draw the first N episodes (default 3)")
    return made


def panel_names(text: str) -> list[str]:
    """Parses --panels."""
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in PANELS:
            raise argparse.ArgumentTypeError(f"no panel `{name}`; allowed: {', '.join(PANELS)}")
    return names


def save(figure: Figure, path: Path) -> None:
    """Writes a file.

    Raises:
        InputError: it cannot be written.
    """
    kind = path.suffix[1:]
    with whole_output(path) as part:
        figure.savefig(part, dpi=DPI, format=kind, metadata=METADATA[kind])


def drawings(
    options: argparse.Namespace, flight: Flight
) -> Iterator[tuple[list[str], Callable[[], Figure]]]:
    """The figures of an episode, with the names of their files."""
    subject, stem = Subject(flight), f"flight-{flight.episode:04d}"
    if options.style == "paper":
        for name in options.panels or [PATH, *names_on_page(subject)]:
            files = [f"{stem}-{name}.{kind}" for kind in ("pdf", "svg")]
            yield files, partial(draw_for_paper, subject, name)
        return
    files = [f"{stem}.{'pdf' if options.pdf else 'png'}"]
    if options.panels:
        yield files, partial(draw_chosen, subject, options.panels)
    else:
        yield files, partial(draw_page, subject)


def plot(options: argparse.Namespace) -> int:
    """Draws the pictures, and prints a line for each."""
    if options.pdf and options.style == "paper":
        raise InputError("--pdf: --style paper writes PDF and SVG; leave --pdf out")
    first = open_flight(options.log)
    _, episode = log_and_episode(options.log)
    episodes = first.episodes[: options.most] if episode is None else [episode]
    folder = options.out or first.path.parent
    # "default": independent of a matplotlibrc in the working folder.
    with plt.style.context(("default", STYLE)):
        for episode in episodes:
            for files, draw in drawings(options, Flight(first.path, episode)):
                figure = draw()
                for file in files:
                    save(figure, folder / file)
                    print(f"picture {folder / file}", flush=True)
                plt.close(figure)
    return 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command."""
    try:
        return plot(parser().parse_args(arguments))
    except InputError as error:
        return report_error(str(error))


if __name__ == "__main__":
    run_program(main)
