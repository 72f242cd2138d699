"""Event files, read back by TensorBoard itself."""

from __future__ import annotations

from pathlib import Path

import pytest
from skybody.train.events import EventFile
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from tensorboard.backend.event_processing.event_file_loader import EventFileLoader


def curve(run: Path, name: str) -> list[tuple[int, float]]:
    found = EventAccumulator(str(run))
    found.Reload()
    return [(point.step, point.value) for point in found.Scalars(name)]


def test_tensorboard_reads_each_point_of_each_curve(tmp_path: Path) -> None:
    events = EventFile(tmp_path, 0)
    # steps of one to six bytes; names and values that make records of more than 127 bytes
    steps = [1, 127, 128, 300_000, 2**31, 2**40 + 5]
    for step in steps:
        events.add({"train/error": step / 3.0, "train/" + "long" * 40: -2.5}, step)
    events.close()
    assert curve(tmp_path, "train/error") == [(s, pytest.approx(s / 3.0, rel=1e-7)) for s in steps]
    assert curve(tmp_path, "train/" + "long" * 40) == [(s, -2.5) for s in steps]


def test_points_are_there_before_the_file_is_closed(tmp_path: Path) -> None:
    events = EventFile(tmp_path, 0)
    events.add({"train/error": 1.5}, 10)
    assert curve(tmp_path, "train/error") == [(10, 1.5)]
    events.close()


def test_a_resumed_run_replaces_points_behind_its_checkpoint(tmp_path: Path) -> None:
    first = EventFile(tmp_path, 0)
    for step in (10, 20, 30):
        first.add({"train/error": 1.0}, step)
    first.close()
    second = EventFile(tmp_path, 20)
    second.add({"train/error": 2.0}, 25)
    second.close()
    assert curve(tmp_path, "train/error") == [(10, 1.0), (25, 2.0)]


def test_a_changed_byte_is_found_by_the_checksums(tmp_path: Path) -> None:
    events = EventFile(tmp_path, 0)
    events.add({"train/error": 1.5}, 10)
    events.close()
    (file,) = tmp_path.iterdir()
    content = bytearray(file.read_bytes())
    assert len(list(EventFileLoader(str(file)).Load())) == 3
    content[-8] ^= 1
    file.write_bytes(content)
    assert len(list(EventFileLoader(str(file)).Load())) == 2


def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="nowhere"):
        EventFile(tmp_path / "nowhere", 0)
