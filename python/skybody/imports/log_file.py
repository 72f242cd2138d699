"""Writes flight logs (docs/flight-log.md)."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

import skybody
from skybody.look.flight import FORMAT, VERSION, Array

CHUNK_ROWS, GZIP = 1024, 4
TEXT = h5py.string_dtype()


@dataclass(frozen=True)
class Dataset:
    """Values with a row for each time."""

    values: NDArray[np.generic]
    columns: Sequence[str] = ()
    units: Sequence[str] = ()
    items: Sequence[str] = ()  # of the middle index


@dataclass
class Log:
    """A flight log with one episode."""

    scenario: str
    scenario_file: str
    scenario_text: str
    scenario_hash: str
    policy: str
    seed: str
    dt: float  # [s]
    action_repeat: int
    bodies: Sequence[str]
    rotors: Sequence[str]
    time: Array  # [s], (rows,)
    datasets: dict[str, Dataset]
    events: list[tuple[float, str]]  # time [s], text
    params: Mapping[str, float] = field(default_factory=dict)  # drawn values by path
    time_origin: float = 0.0  # time of the first row in the log of another program [s]


def write(path: Path, log: Log) -> None:
    """Writes a log. Raises OSError, which HDF5 itself does not survive on a full disk."""
    content = io.BytesIO()
    with h5py.File(content, "w", libver=("v108", "v110")) as file:
        write_head(file, log)
        episode = file.create_group("episodes/0001")
        add(episode, "time", Dataset(log.time)).attrs["unit"] = "s"
        for name, dataset in log.datasets.items():
            add(episode, name, dataset)
        write_events(episode, log)
        if log.params:
            params = file.create_group("params")
            params.create_dataset("paths", data=np.array(list(log.params), dtype=TEXT))
            episode.create_dataset("params", data=np.array(list(log.params.values())))
    path.write_bytes(content.getbuffer())


def write_head(file: h5py.File, log: Log) -> None:
    """The attributes of the log."""
    file.attrs["format"] = f"{FORMAT} {VERSION}"
    for key in ("scenario", "scenario_file", "scenario_text", "scenario_hash", "policy", "seed"):
        file.attrs[key] = getattr(log, key)
    file.attrs["dt"] = log.dt
    file.attrs["action_repeat"] = np.int64(log.action_repeat)
    file.attrs["time_origin"] = log.time_origin
    file.attrs["bodies"] = np.array(log.bodies, dtype=TEXT)
    file.attrs["rotors"] = np.array(log.rotors, dtype=TEXT)
    file.attrs["references"] = np.array([], dtype=TEXT)
    file.create_group("versions").attrs["skybody"] = skybody.__version__


def add(episode: h5py.Group, name: str, dataset: Dataset) -> h5py.Dataset:
    """Adds a dataset."""
    values = dataset.values
    made = episode.create_dataset(
        name,
        data=values,
        chunks=(min(CHUNK_ROWS, len(values)), *values.shape[1:]),
        compression="gzip",
        compression_opts=GZIP,
        shuffle=True,
    )
    for key in ("columns", "units", "items"):
        if names := getattr(dataset, key):
            made.attrs[key] = np.array(names, dtype=TEXT)
    return made


def write_events(episode: h5py.Group, log: Log) -> None:
    """The table of events."""
    kind = np.dtype([("row", "<u8"), ("time", "<f8"), ("text", TEXT)])
    rows = [
        (int(np.searchsorted(log.time, time, side="right")) - 1, time, text)
        for time, text in log.events
    ]
    episode.create_dataset("events", data=np.array(rows, dtype=kind))
