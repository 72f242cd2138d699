"""What experiments share: their command lines, and how they write page and data."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from training_runs import command_line, machine, page_data, shown, write_json


def option_parser(doc: str | None) -> argparse.ArgumentParser:
    """A parser whose help begins with the script's docstring as it stands."""
    return argparse.ArgumentParser(
        description=doc, formatter_class=argparse.RawDescriptionHelpFormatter
    )


def heading(experiment: str, script: str, arguments: Sequence[str] | None) -> dict[str, Any]:
    """What data begins with: what was measured, by which command, on which machine.

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
    """Writes `content` and the page that was made of it, and prints the page."""
    write_json(folder / f"data/{name}.json", content)
    page = folder / f"{name}.md"
    page_data.write(page, text)
    print(f"{text}\nwritten: {shown(page)}")
