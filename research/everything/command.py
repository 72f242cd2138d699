"""Runs every measurement that writes a page, in the order of research/everything/plan.yaml.

Before it starts it prints each row with its expected time, and the sum. A row is skipped if its
page's data are of today's sources, or if it needs something that is absent; the reason is printed.
What a row prints is in flights/research_all/NAME.log. At the end it lists the rows that failed
(exit status 1). Interrupted, `--resume` goes on where it was.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from research.common.pages import plain_table
from research.common.places import FLIGHTS, ROOT, command_of, shown
from research.everything.record import Record
from research.everything.rows import Given, Row, missing, rows

Runner = Callable[[Sequence[str], Path], int]


@dataclass(frozen=True)
class Step:
    """A row and why it is skipped."""

    row: Row
    minutes: float
    skipped: str = ""


def run_command(words: Sequence[str], log: Path) -> int:
    """Runs a command from the repository's root; its output goes into a file."""
    command_of("all")  # adds the repository to PYTHONPATH
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("w", encoding="utf-8") as file:
        done = subprocess.run(words, cwd=ROOT, stdout=file, stderr=file, check=False)
    return done.returncode


def steps_of(options: argparse.Namespace, record: Record) -> list[Step]:
    """The chosen rows."""
    chosen = [row for row in rows() if not options.only or row.name in options.only]
    return [Step(row, record.minutes(row), reason(row, options, record)) for row in chosen]


def reason(row: Row, options: argparse.Namespace, record: Record) -> str:
    """Why a row is skipped; empty: it runs."""
    if options.quick and row.quick == "none":
        return "has no trial"
    absent = missing(row, Given(options.firmware, options.neural_swarm))
    if absent or options.again:
        return absent or ""
    if not options.quick:
        return record.reason(row, options.resume) or ""
    has_ended = options.resume and record.has_ended(row)
    return "its trial has ended here, with today's sources" if has_ended else ""


def duration(minutes: float) -> str:
    """A time for people."""
    return f"{minutes / 60.0:.1f} h" if minutes >= 60.0 else f"{minutes:.0f} min"


def listed(steps: Sequence[Step]) -> str:
    """All rows with their expected times, and the sum of those that run."""
    table = [["name", "time", "page", ""]]
    for step in steps:
        page = f"{step.row.page}{' (by hand)' if step.row.by_hand else ''}"
        reason = f"skipped: {step.skipped}" if step.skipped else ""
        table.append([step.row.name, duration(step.minutes), f"  {page}", f"  {reason}"])
    width = max(len(row[2]) for row in table)
    table = [[*row[:2], row[2].ljust(width), row[3]] for row in table]
    wide = max(len(row[3]) for row in table)
    lines = plain_table([[*row[:3], row[3].ljust(wide)] for row in table])
    wanted = [step.minutes for step in steps if not step.skipped]
    return f"{lines}\n{len(wanted)} of {len(steps)} rows run: about {duration(sum(wanted))}"


def run_steps(
    steps: Sequence[Step],
    options: argparse.Namespace,
    record: Record,
    run: Runner = run_command,
) -> list[str]:
    """Runs the rows that are not skipped; returns the names of those that failed."""
    given = Given(options.firmware, options.neural_swarm)
    began, failed = time.monotonic(), []
    wanted = [step for step in steps if not step.skipped]
    for number, step in enumerate(wanted, 1):
        name = step.row.name
        place = f"[{number}/{len(wanted)}] {name}"
        left = options.hours * 3600.0 - (time.monotonic() - began)
        if 60.0 * step.minutes > left:
            print(f"{place}: left out, takes about {duration(step.minutes)}", flush=True)
            continue
        print(f"{place}: about {duration(step.minutes)}", flush=True)
        out = options.logs / name if options.quick else None
        log = options.logs / f"{name}.log"
        start = time.monotonic()
        if run(step.row.words(given, out), log) == 0:
            record.add(step.row, time.monotonic() - start)
            if step.row.by_hand and not options.quick:
                print(f"{place}: docs/results/{step.row.page}.md is written by hand from {log}")
        else:
            failed.append(name)
            print(f"{place}: failed, see {shown(log)}", flush=True)
    return failed


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """The options."""
    parser = argparse.ArgumentParser(
        prog="python -m research all",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--list", action="store_true", help="print the rows and their times, and run nothing")
    add("--resume", action="store_true", help="skip rows that have ended here before")
    add("--again", action="store_true", help="also rows whose data are of today's sources")
    add("--only", nargs="+", metavar="NAME", help="some of the rows")
    add("--hours", type=float, default=float("inf"), help="start no row that would end later")
    add("--quick", action="store_true", help="a trial of each; pages are written below --logs")
    add("--firmware", type=Path, metavar="PROGRAM", help="of scripts/build_betaflight.sh")
    add("--neural-swarm", type=Path, metavar="FOLDER", help="a checkout of neural-swarm")
    where = "logs, the state file and trials; default: flights/research_all, of a trial ..._quick"
    add("--logs", type=Path, metavar="FOLDER", help=where)
    options = parser.parse_args(arguments)
    unknown = sorted({*(options.only or [])} - {row.name for row in rows()})
    if unknown:
        parser.error(f"--only {unknown[0]}: no such row; --list prints all of them")
    if not options.hours > 0.0:
        parser.error(f"--hours {options.hours:g}: more than 0")
    for path in (options.firmware, options.neural_swarm):
        if path is not None and not path.exists():
            parser.error(f"{path} does not exist")
    logs = options.logs or FLIGHTS / f"research_all{'_quick' if options.quick else ''}"
    options.logs = logs.resolve()
    for name in ("firmware", "neural_swarm"):
        if getattr(options, name) is not None:
            setattr(options, name, getattr(options, name).resolve())
    return options


def main(arguments: Sequence[str]) -> int:
    """The command line; returns the exit code."""
    options = parse(arguments)
    record = Record(options.logs / "state.json")
    steps = steps_of(options, record)
    print(listed(steps), flush=True)
    if options.list:
        return 0
    try:
        options.logs.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        print(f"all: cannot write to {options.logs}: {os.strerror(error.errno)}", file=sys.stderr)
        return 2
    failed = run_steps(steps, options, record)
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
        return 1
    return 0
