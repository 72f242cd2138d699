"""Flight logs again from the MCAP files of `skybody export`."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import McapReader
from mcap_protobuf.decoder import DecoderFactory

from skybody import InputError
from skybody.exports.mcap_file import ABOUT, PARAMETERS
from skybody.exports.table import Series
from skybody.exports.values import Values
from skybody.look.flight import Array

from .flight import BODY, BODY_UNITS, GOAL, GOAL_UNITS
from .log_file import Dataset, Log
from .motion import to_world

NANO = 1e-9
KEYS = ("columns", "units", "type")  # of the metadata of datasets


def restored(path: Path, reader: McapReader) -> Log | None:
    """The flight log; None: `skybody export` has not written the file.

    Raises:
        InputError: the file lacks a part, or is damaged.
    """
    metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    about = metadata.get(ABOUT, {})
    if "scenario_text" not in about:
        return None
    found = Parts(path)
    for schema, channel, message in reader.iter_messages():
        found.add(schema, channel, message)
    datasets = found.datasets()
    check_texts(path, [*about.values(), *metadata.get(PARAMETERS, {})])
    check_texts(path, (text for _, text in found.events))
    for name, dataset in datasets.items():
        check_texts(path, [name, *dataset.columns, *dataset.units, *dataset.items])
    bodies = list(datasets["bodies"].items) if "bodies" in datasets else []
    rotors = list(datasets["rotor_speed"].columns) if "rotor_speed" in datasets else []
    return Log(
        scenario=about["scenario"],
        scenario_file=str(path.resolve().parent / f"{about['scenario']}.yaml"),
        scenario_text=about["scenario_text"],
        scenario_hash=about["scenario_hash"],
        policy=about["policy"],
        seed=about["seed"],
        dt=float(about["dt"]),
        action_repeat=int(about["action_repeat"]),
        bodies=bodies,
        rotors=rotors,
        time=found.time(),
        datasets=datasets,
        events=found.events,
        params={path: float(value) for path, value in metadata.get(PARAMETERS, {}).items()},
    )


def check_texts(path: Path, texts: Iterable[str]) -> None:
    """Raises InputError for a zero byte, which HDF5 cannot store: the file is damaged."""
    if any("\0" in text for text in texts):
        raise InputError(f"{path}: is damaged: a text in it contains a zero byte")


class Parts:
    """The messages of a file by the part of the log that they are of."""

    def __init__(self, path: Path) -> None:
        self.events: list[tuple[float, str]] = []
        self._path = path
        self._channels: dict[int, Any] = {}
        self._messages: dict[int, list[Any]] = {}
        self._times: dict[int, list[int]] = {}
        self._decoders: dict[int, Any] = {}

    def add(self, schema: Any, channel: Any, message: Any) -> None:
        """Adds a message."""
        if channel.id not in self._channels:
            self._channels[channel.id] = channel
            self._decoders[channel.id] = (
                None if "dataset" in channel.metadata else self._decoder(schema)
            )
        decode = self._decoders[channel.id]
        made = message.data if decode is None else decode(message.data)
        if channel.topic == "/events":
            self.events.append((message.log_time * NANO, made.message))
        self._messages.setdefault(channel.id, []).append(made)
        self._times.setdefault(channel.id, []).append(message.log_time)

    @staticmethod
    def _decoder(schema: Any) -> Any:
        return DecoderFactory().decoder_for("protobuf", schema)

    def time(self) -> Array:
        """Times of the rows [s]."""
        rows = [self._times[k] for k, c in self._channels.items() if "dataset" in c.metadata]
        if not rows:
            raise InputError(f"{self._path}: has no datasets of a flight log")
        return np.array(rows[0]) * NANO

    def datasets(self) -> dict[str, Dataset]:
        """The datasets of the log."""
        found: dict[str, Dataset] = {}
        rows = len(self.time())
        bodies, goals = self._named("body"), self._named("goal")
        for kind, poses in (("bodies", bodies), ("goal", goals)):
            if any(len(self._messages[k]) != rows for k in poses.values()):
                raise InputError(
                    f"{self._path}: {kind} have fewer rows than the rest; NaN was left out, and "
                    "cannot be restored: give a --map"
                )
        if bodies:
            states = np.stack([self._states(k) for k in bodies.values()], axis=1)
            found["bodies"] = Dataset(states, BODY, BODY_UNITS, list(bodies))
        if goals:
            places = np.stack([self._goals(k) for k in goals.values()], axis=1)
            found["goal"] = Dataset(places, GOAL, GOAL_UNITS, list(goals))
        for name, k in self._named("dataset").items():
            about = {
                key: json.loads(text) for key, text in self._metadata(k).items() if key in KEYS
            }
            kind = np.dtype(about["type"])
            series = Series(name, tuple(about["columns"]), tuple(about["units"]), (), kind)
            values = Values(series).decode(self._messages[k]).astype(kind)
            shape = values if series.columns else values[:, 0]
            found[name] = Dataset(shape, series.columns, series.units)
        return found

    def _metadata(self, channel: int) -> dict[str, str]:
        return dict(self._channels[channel].metadata)

    def _named(self, key: str) -> dict[str, int]:
        """Channels whose metadata have a key, by its value."""
        return {self._metadata(k)[key]: k for k in self._channels if key in self._metadata(k)}

    def _states(self, channel: int) -> Array:
        rows = [
            [*pose_of(m.pose), *xyz(m.linear_velocity), *xyz(m.angular_velocity)]
            for m in self._messages[channel]
        ]
        states = np.array(rows)
        states[:, 7:10] = to_world(states[:, 3:7], states[:, 7:10])
        return states

    def _goals(self, channel: int) -> Array:
        poses = np.array([pose_of(m.pose) for m in self._messages[channel]])
        yaw = 2.0 * np.arctan2(poses[:, 6:7], poses[:, 3:4])
        return np.concatenate([poses[:, :3], yaw], axis=1)


def xyz(vector: Any) -> list[float]:
    """The numbers of a vector."""
    return [vector.x, vector.y, vector.z]


def pose_of(pose: Any) -> list[float]:
    """Position and quaternion w x y z."""
    turn = pose.orientation
    return [*xyz(pose.position), turn.w, turn.x, turn.y, turn.z]
