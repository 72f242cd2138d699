"""The kinds of logs that `skybody import` reads."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skybody import InputError

from .channels import Channels
from .log_file import Log
from .map_file import Map


@dataclass(frozen=True)
class Source:
    """A kind of log, read by `read(path, map)` of its module."""

    endings: tuple[str, ...]
    module: str  # of skybody.imports
    packages: tuple[str, ...]  # that the module imports and an installation may lack
    map: str  # shipped map that is used by default; empty: none
    restores: bool = False  # `restore(path)` of its module reads the files of `skybody export`

    def read(self, path: Path, used: Map) -> Channels:
        """The columns of a log.

        Raises:
            InputError: a package is missing, or the log is not usable.
        """
        read: Callable[[Path, Map], Channels] = self._load(path).read
        return read(path, used)

    def restore(self, path: Path) -> Log | None:
        """The flight log that a file of `skybody export` was made from; None: it is another's."""
        if not self.restores:
            return None
        restore: Callable[[Path], Log | None] = self._load(path).restore
        return restore(path)

    def _load(self, path: Path) -> Any:
        try:
            return importlib.import_module(f"skybody.imports.{self.module}")
        except ModuleNotFoundError as error:
            if not self.packages or (error.name or "").startswith("skybody"):
                raise
            raise InputError(
                f"{path}: needs the package `{error.name}`: `pip install {' '.join(self.packages)}`"
            ) from None


SOURCES = (
    Source((".csv", ".csv.gz"), "csv_file", (), ""),
    Source((".ulg",), "ulog_file", ("pyulog",), "px4"),
    Source((".usd", ".usd.gz"), "usd_file", (), "crazyflie_usd"),
    Source((".mcap",), "mcap_file", ("mcap", "mcap-protobuf-support", "rosbags"), "", True),
)


def source_of(path: Path) -> Source:
    """The kind of a log by its ending.

    Raises:
        InputError: it is unknown.
    """
    for source in SOURCES:
        if path.name.endswith(source.endings):
            return source
    endings = ", ".join(ending for source in SOURCES for ending in source.endings)
    raise InputError(f"{path}: unknown ending `{path.suffix}`; allowed: {endings}")
