"""The formats that `skybody export` writes."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skybody import InputError

FLIGHT, POLICY = "flight log", "policy"  # of Format.reads
ROWS = ("start", "until", "every", "datasets")  # options that choose a part of a flight log
READ = ("scenario", "set", "plugin_path", "map")  # options that find a policy's scenario
NETWORK = (*READ, "name", "check")  # options of policies in other formats


@dataclass(frozen=True)
class Format:
    """A format, written by `write(source, path, options)` of its module."""

    name: str  # of --to
    reads: str  # the kind of its source
    ending: str  # of the file that it writes by default
    module: str  # of skybody.exports
    packages: tuple[str, ...]  # that the module imports and an installation may lack
    takes: tuple[str, ...]  # options, beside --to and --out
    help: str

    def writer(self) -> Callable[[Any, Path, Any], None]:
        """The function that writes it.

        Raises:
            InputError: a package is missing.
        """
        try:
            module = importlib.import_module(f"skybody.exports.{self.module}")
        except ModuleNotFoundError as error:
            if not self.packages or (error.name or "").startswith("skybody"):
                raise
            raise InputError(
                f"--to {self.name} needs the package `{error.name}`: "
                f"`pip install {' '.join(self.packages)}`"
            ) from None
        write: Callable[[Any, Path, Any], None] = module.write
        return write


FORMATS = {
    row.name: row
    for row in (
        Format("csv", FLIGHT, ".csv", "csv_file", (), ROWS, "text, with a column for each value"),
        Format("npz", FLIGHT, ".npz", "npz", (), ROWS, "arrays of NumPy, one for each dataset"),
        Format(
            "parquet", FLIGHT, ".parquet", "parquet", ("pyarrow",), ROWS,
            "a table for pandas, Polars or DuckDB, with units",
        ),
        Format(
            "mcap", FLIGHT, ".mcap", "mcap_file", ("foxglove-sdk", "protobuf"), (*ROWS, "images"),
            "Foxglove: poses, transforms, shapes, plots",
        ),
        Format(
            "rosbag2", FLIGHT, "_bag", "rosbag2", ("rosbags",), (*ROWS, "images", "storage"),
            "a bag of ROS 2: odometry, transforms, IMU, goals, rotor speeds, markers",
        ),
        Format(
            "ulog", FLIGHT, ".ulg", "ulog", (), ROWS,
            "PX4's log: pose, velocity, rotor speeds in NED and FRD",
        ),
        Format(
            "rrd", FLIGHT, ".rrd", "rerun_file", ("rerun-sdk",), (*ROWS, "images"),
            "a recording for the Rerun viewer",
        ),
        Format(
            "c", POLICY, "_c", "policy.c_files", (), NETWORK,
            "a policy as C99 sources for a vehicle's computer, the same bits",
        ),
        Format(
            "onnx", POLICY, ".onnx", "policy.onnx_file", ("onnx", "onnxruntime"), NETWORK,
            "a policy for ONNX Runtime and others",
        ),
        Format(
            "onboard", POLICY, ".mission", "policy.mission_file", (),
            (*READ, "check", "robot", "limit"), "a mission for `skybody onboard`, on a vehicle",
        ),
        Format("h5", POLICY, ".h5", "policy.h5_file", (), READ, "a policy of `skybody run`"),
    )
}  # fmt: skip
