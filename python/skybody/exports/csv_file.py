"""CSV: a table of text with a row for each time."""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

from .table import Block, Table


def write(table: Table, path: Path, options: argparse.Namespace) -> None:
    """Writes the rows; numbers have all digits of the log's."""
    names = [name for series in table.series.values() for name in series.paths]
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["time", *names])
        for block in table.blocks():
            rows.writerows(zip(block.time.tolist(), *columns_of(table, block), strict=True))


def columns_of(table: Table, block: Block) -> list[list[float]]:
    """The values of a block by column, in the order of the datasets and their paths."""
    found: list[list[float]] = []
    for name, series in table.series.items():
        values = block.values[name].reshape(len(block.time), len(series.paths))
        found += [column.tolist() for column in values.T]
    return found
