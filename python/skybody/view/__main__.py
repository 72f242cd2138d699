"""`skybody view`: flights in a browser.

skybody view flights/racing                     # writes flights/racing/flight.html
skybody view flights/a flights/b -o both.html   # several flights in one page
skybody view runs/first                         # checkpoints of a training run
skybody view --live hover                       # a running simulation
"""

from __future__ import annotations

import argparse
import sys
import webbrowser
from collections.abc import Sequence
from pathlib import Path

from skybody import CompiledScenario, Error
from skybody.command_line import CommandLine, report_error, whole
from skybody.look.flight import Flight, log_and_episode, log_file, open_flight
from skybody.program import run_program
from skybody.train.hyperparameters import UsageError
from skybody.whole_output import refuse_source

from .live import Live
from .page import Shown, write_page
from .runs import is_run, write_run_page
from .samples import of_flight
from .server import Server

MOST_FLIGHTS = 12
MOST_EPISODES = 4  # of a log that is given without a number


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    made = CommandLine(
        prog="skybody view",
        description="Writes one HTML file that plays flights in 3-D, without network; or serves a\n"
        "running simulation to a browser on this machine.",
        epilog=(__doc__ or "").partition("\n\n")[2],
    )
    add = made.add_argument
    add("shown", nargs="*", metavar="LOG[:EPISODE]|RUN", help="flight logs, or a training run")
    add("-o", "--out", type=Path, help="file to write; default: beside the first log")
    add("--open", action="store_true", help="open it in the browser")
    add("--live", metavar="SCENARIO", help="a simulation to fly now")
    add("--policy", default="hold", help="live: as skybody run; default: hold")
    add("--seed", type=whole(0, 2**63 - 1), default=0, help="live: of the episodes; default: 0")
    add("--set", dest="overrides", action="append", default=[], metavar="PATH=VALUE",
        help="live: as skybody run; repeatable")  # fmt: skip
    add("--port", type=whole(0, 65535), default=0, help="live; default: any that is free")
    return made


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command."""
    made = parser()
    options = made.parse_args(arguments)
    if bool(options.shown) == (options.live is not None):
        made.error("needs flights or a training run, or --live SCENARIO, and not both")
    if len(options.shown) > MOST_FLIGHTS:
        made.error(f"{len(options.shown)} flights; allowed: at most {MOST_FLIGHTS}")
    if len(options.shown) > 1 and (runs := [one for one in options.shown if is_run(Path(one))]):
        made.error(f"{runs[0]} is a training run; allowed: one run alone, or flight logs")
    try:
        return serve(options) if options.live is not None else write(options)
    except (Error, UsageError, ValueError, OSError) as error:
        return report_error(str(error))


# --- a page -------------------------------------------------------------------------------------


def write(options: argparse.Namespace) -> int:
    """Writes the page of flights or of a run."""
    first = Path(options.shown[0])
    out = options.out or page_beside(first)
    for name in options.shown:
        refuse_source(out, log_file(log_and_episode(name)[0]))
    if is_run(first):
        write_run_page(first, out)
    else:
        shown = [flight for name in options.shown for flight in flights_in(name)]
        write_page(out, shown[0].samples.compiled.name, shown[:MOST_FLIGHTS])
    print(f"page     {out}")
    if options.open:
        webbrowser.open(out.resolve().as_uri())
    return 0


def page_beside(first: Path) -> Path:
    """flight.html in the folder of a log or run."""
    return (first if first.is_dir() else first.parent) / "flight.html"


def flights_in(argument: str) -> list[Shown]:
    """The episode that LOG:EPISODE names, or the first ones of LOG."""
    flight = open_flight(argument)
    _, episode = log_and_episode(argument)
    others = flight.episodes[1:MOST_EPISODES] if episode is None else []
    flights = [flight, *(Flight(flight.path, number) for number in others)]
    name = flight.path.parent.name or flight.path.name
    return [Shown(of_flight(one), f"{name}, episode {one.episode}") for one in flights]


# --- a running simulation -----------------------------------------------------------------------


def serve(options: argparse.Namespace) -> int:
    """Serves the page until Ctrl-C."""
    live = Live(CompiledScenario(options.live, options.overrides), options.policy, options.seed)
    server = Server(live, options.port)
    live.start()
    print(f"page     {server.address}  (Ctrl-C ends it)", flush=True)
    if options.open:
        webbrowser.open(server.address)
    try:
        server.serve_forever()
    finally:
        live.close()
        server.server_close()
    return 0


if __name__ == "__main__":
    sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    run_program(main)
