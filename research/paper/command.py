"""Lists or makes every table and figure of the GzDRL paper.

--list prints each with its figure, goal, verdict, command, time and page. --all runs all of their
measurements (hours) and writes docs/results/paper.md; those that have ended before are skipped, so
that it resumes where it was interrupted.
"""

from __future__ import annotations

import argparse
import sys

from research.common.programs import RunError
from research.paper import report
from research.paper.items import Item, items
from research.paper.runs import Record, run_all


def chosen(only: list[str] | None) -> list[Item]:
    """The items with these names, such as `Table III`; None: all.

    Raises:
        RunError: a name that the paper does not have.
    """
    found = {item.item.lower(): item for item in items()}
    unknown = [name for name in only or [] if name.lower() not in found]
    if unknown:
        names = ", ".join(item.item for item in found.values())
        raise RunError(f"the paper has no `{unknown[0]}`; it has {names}")
    return [found[name.lower()] for name in only] if only else list(found.values())


def main(arguments: list[str] | None = None) -> int:
    """The command line; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m research paper",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    one = parser.add_mutually_exclusive_group(required=True)
    one.add_argument("--list", action="store_true", help="print all of them")
    one.add_argument("--all", action="store_true", help="run all measurements")
    one.add_argument("--page", action="store_true", help="write docs/results/paper.md")
    one.add_argument("--check", action="store_true", help="fail if that page is out of date")
    parser.add_argument("--again", action="store_true", help="with --all: also finished ones")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="with --all: some of them")
    options = parser.parse_args(arguments)
    if options.list:
        print(report.listed())
        return 0
    if options.check:
        return 0 if report.is_current() else fail(f"{report.PAGE} is out of date: --page writes it")
    if options.all:
        try:
            failed = run_all(chosen(options.only), options.again, Record())
        except RunError as error:
            return fail(str(error))
        if failed:
            return fail(f"failed: {', '.join(failed)}")
    report.write()
    return 0


def fail(text: str) -> int:
    """Prints an error; returns its exit code."""
    print(f"paper: {text}", file=sys.stderr)
    return 2
