"""Shared code of experiments: command lines, and writing of page and data."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from training_runs import ROOT, command_line, machine, page_data, shown, write_json


def option_parser(doc: str | None) -> argparse.ArgumentParser:
    """A parser whose help begins with the script's docstring, unformatted."""
    return argparse.ArgumentParser(
        description=doc, formatter_class=argparse.RawDescriptionHelpFormatter
    )


def add_quick(parser: argparse.ArgumentParser, trial: str) -> None:
    """Adds --quick, --out and --report; place_quick() sets their defaults.

    Args:
        trial: description of the reduced experiment.
    """
    add = parser.add_argument
    add("--quick", action="store_true", help=f"a trial: {trial}; page in the folder of the runs")
    add("--out", type=Path, help="folder of the runs; default: below flights")
    add("--report", type=Path, help="folder of the page; default: docs/results")


def place_quick(options: argparse.Namespace, name: str) -> None:
    """Sets the folders that are not given: flights/NAME, for a trial flights/NAME_quick."""
    runs = ROOT / "flights" / (f"{name}_quick" if options.quick else name)
    options.out = options.out or runs
    options.report = options.report or (options.out if options.quick else ROOT / "docs/results")


def heading(experiment: str, script: str, arguments: Sequence[str] | None) -> dict[str, Any]:
    """Head of the data: the experiment, its command, and the machine.

    Args:
        arguments: main()'s; None: those of the command line.
    """
    given = sys.argv[1:] if arguments is None else arguments
    return {
        "experiment": experiment,
        "command": command_line(script, given),
        "machine": machine(),
    }


def write_page(folder: Path, name: str, content: dict[str, Any], text: str) -> None:
    """Writes `content` and its page, and prints the page."""
    write_json(folder / f"data/{name}.json", content)
    page = folder / f"{name}.md"
    page_data.write(page, text)
    print(f"{text}\nwritten: {shown(page)}")
