"""Exports of `skybody export` in tests: short flights, and the readers of other programs."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from numpy.typing import NDArray
from rerun.chunk import RrdReader
from rosbags.highlevel import AnyReader
from skybody.exports import formats
from skybody.exports.__main__ import main
from skybody.look.flight import rotation_of

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
SCENARIOS = ("chase", "cooperative_payload_ropes", "hover_sensors", "racing")
STEPS = 20
FORMATS = [name for name, row in formats.FORMATS.items() if row.reads == formats.FLIGHT]
FLIP = np.array([1.0, -1.0, -1.0])
# A quaternion of the log has norm 1 up to round-off, and a rotation there and back adds some more.
ROUND_OFF = 1e-13

Array = NDArray[Any]


def export(log: Path, kind: str, out: Path, *options: str) -> Path:
    """Exports a log."""
    assert main([str(log), "--to", kind, "--out", str(out), *options]) == 0
    return out


def data_of(log: Path) -> dict[str, Array]:
    """The datasets of the first episode."""
    with h5py.File(log) as file:
        return {name: data[:] for name, data in file["episodes/0001"].items()}


def names_of(log: Path, dataset: str, key: str = "columns") -> list[str]:
    with h5py.File(log) as file:
        return [str(name) for name in file["episodes/0001"][dataset].attrs[key]]


def rows(data: dict[str, Array]) -> dict[str, Array]:
    """The datasets with a row for each time, (rows, values)."""
    skipped = ("time", "events", "params")
    return {k: v.reshape(len(v), -1) for k, v in data.items() if k not in skipped}


def read_mcap(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Times [ns] and messages by topic, decoded by the schemas of the file."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, decoded))
    return found


def check_times(stamps: list[int], log: Path) -> None:
    """Times [ns] are those of the log to 1 us."""
    np.testing.assert_allclose(np.array(stamps) * 1e-9, data_of(log)["time"], rtol=0, atol=1e-6)


def pose_in(pose: Any) -> list[float]:
    """Position and quaternion w x y z of a message."""
    p, q = pose.position, pose.orientation
    return [p.x, p.y, p.z, q.w, q.x, q.y, q.z]


def xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def check_odometry(messages: list[Any], body: Array) -> None:
    """Poses in the world and velocities in the body, of either of two programs' messages."""
    np.testing.assert_array_equal([pose_in(pose) for pose, _, _ in messages], body[:, :7])
    turned = rotation_of(body[:, 3:7])
    found = np.array([xyz(velocity) for _, velocity, _ in messages])
    world = np.einsum("nij,nj->ni", turned, found)
    np.testing.assert_allclose(world, body[:, 7:10], rtol=0, atol=ROUND_OFF * 100)
    np.testing.assert_array_equal([xyz(rate) for _, _, rate in messages], body[:, 10:])


def read_bag(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Times [ns] and messages by topic."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with AnyReader([path]) as reader:
        for connection, time, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((time, message))
    return found


def read_rerun(path: Path) -> dict[str, dict[str, list[Any]]]:
    """Columns of each entity."""
    found: dict[str, dict[str, list[Any]]] = {}
    for chunk in RrdReader(path).stream().to_chunks():
        columns = found.setdefault(chunk.entity_path, {})
        for name, values in chunk.to_record_batch().to_pydict().items():
            columns.setdefault(name, []).extend(values)
    return found


def refused(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """The one line about an error."""
    capsys.readouterr()
    try:
        status = main([str(argument) for argument in arguments])
    except SystemExit as error:
        status = error.code  # type: ignore[assignment]
    message = capsys.readouterr().err
    assert status == 2
    assert message.count("\n") == 1
    return message


def changed(log: Path, path: Path, change: Any) -> Path:
    """A copy of a log with some changes."""
    shutil.copy(log, path)
    with h5py.File(path, "a") as file:
        change(file)
    return path


def remove_bodies(file: h5py.File) -> None:
    del file["episodes/0001/bodies"]
