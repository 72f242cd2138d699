"""Parquet: a table by columns, with units, for pandas, Polars or DuckDB."""

from __future__ import annotations

import argparse
from pathlib import Path

import pyarrow
import pyarrow.parquet

from .about import SCENARIO, about
from .table import Table


def write(table: Table, path: Path, options: argparse.Namespace) -> None:
    """Writes the rows, each block as a row group; a column's metadata has its `unit`."""
    schema = schema_of(table)
    with pyarrow.parquet.ParquetWriter(path, schema) as file:
        for block in table.blocks():
            columns = [pyarrow.array(block.time)]
            for name, series in table.series.items():
                values = block.values[name].reshape(len(block.time), len(series.paths))
                columns += [pyarrow.array(column) for column in values.T]
            file.write_table(pyarrow.Table.from_arrays(columns, schema=schema))


def schema_of(table: Table) -> pyarrow.Schema:
    """The columns, with the log's attributes as metadata."""
    fields = [pyarrow.field("time", pyarrow.float64(), False, {"unit": "s"})]
    for series in table.series.values():
        kind = pyarrow.from_numpy_dtype(series.type)
        for name, unit in zip(series.paths, series.unit_of_each, strict=True):
            fields.append(pyarrow.field(name, kind, False, {"unit": unit}))
    return pyarrow.schema(fields, about(table, SCENARIO))
