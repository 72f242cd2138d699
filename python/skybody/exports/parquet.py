"""Parquet: a table by columns, with units, for pandas, Polars or DuckDB."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pyarrow
import pyarrow.parquet

from .about import SCENARIO, about
from .table import Block, Table

GROUP_BYTES = 64 << 20  # of a row group: each takes memory until the end of the file
MOST_COLUMNS = 1024  # of a dataset; a wider one is one column of lists


def write(table: Table, path: Path, options: argparse.Namespace) -> None:
    """Writes the rows in groups; a column's metadata has its `unit`."""
    schema = schema_of(table)
    waiting: list[pyarrow.RecordBatch] = []
    with pyarrow.parquet.ParquetWriter(path, schema) as file:
        for block in table.blocks():
            waiting.append(batch_of(table, block, schema))
            if sum(batch.nbytes for batch in waiting) > GROUP_BYTES:
                file.write_table(pyarrow.Table.from_batches(waiting, schema))
                waiting.clear()
        if waiting:
            file.write_table(pyarrow.Table.from_batches(waiting, schema))


def batch_of(table: Table, block: Block, schema: pyarrow.Schema) -> pyarrow.RecordBatch:
    """The rows of a block."""
    columns = [pyarrow.array(block.time)]
    for name, series in table.series.items():
        width = len(series.paths)
        values = np.ascontiguousarray(block.values[name].reshape(len(block.time), width))
        if width > MOST_COLUMNS:
            columns.append(pyarrow.FixedSizeListArray.from_arrays(values.ravel(), width))
        else:
            columns += [pyarrow.array(column) for column in values.T]
    return pyarrow.RecordBatch.from_arrays(columns, schema=schema)


def schema_of(table: Table) -> pyarrow.Schema:
    """The columns, with the log's attributes as metadata."""
    fields = [pyarrow.field("time", pyarrow.float64(), False, {"unit": "s"})]
    for series in table.series.values():
        kind = pyarrow.from_numpy_dtype(series.type)
        if len(series.paths) > MOST_COLUMNS:
            about_all = {"columns": "\n".join(series.paths), "unit": "\n".join(series.unit_of_each)}
            lists = pyarrow.list_(pyarrow.field("item", kind, False), len(series.paths))
            fields.append(pyarrow.field(series.name, lists, False, about_all))
            continue
        for name, unit in zip(series.paths, series.unit_of_each, strict=True):
            fields.append(pyarrow.field(name, kind, False, {"unit": unit}))
    return pyarrow.schema(fields, about(table, SCENARIO))
