"""npz: NumPy's arrays in a zip file."""

from __future__ import annotations

import argparse
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .about import SCENARIO, about
from .table import Table


def write(table: Table, path: Path, options: argparse.Namespace) -> None:
    """Writes an array for each dataset, and its names as DATASET.columns, .units and .items."""
    events = table.flight.events
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file:
        add(file, "time", np.concatenate([block.time for block in table.blocks("time")]))
        for name, series in table.series.items():
            add_rows(file, table, name)
            for key in ("columns", "units", "items"):
                if names := getattr(series, key):
                    add(file, f"{name}.{key}", np.array(names))
        add(file, "events.time", np.array([time for time, _ in events], np.float64))
        add(file, "events.text", np.array([text for _, text in events], np.str_))
        for key, text in about(table, SCENARIO).items():
            add(file, key, np.array(text))


def add(file: zipfile.ZipFile, name: str, values: NDArray[Any]) -> None:
    """Adds an array."""
    with file.open(f"{name}.npy", "w") as entry:
        np.lib.format.write_array(entry, values, allow_pickle=False)


def add_rows(file: zipfile.ZipFile, table: Table, name: str) -> None:
    """Adds a dataset, block by block behind a header with its whole shape."""
    series = table.series[name]
    shape = (table.count, *table.flight.data[name].shape[1:])
    header = {
        "descr": np.lib.format.dtype_to_descr(series.type),
        "fortran_order": False,
        "shape": shape,
    }
    with file.open(f"{name}.npy", "w", force_zip64=True) as entry:
        np.lib.format.write_array_header_2_0(entry, header)
        for block in table.blocks(name):
            entry.write(np.ascontiguousarray(block.values[name]).tobytes())
