"""`skybody export`: tables, parts of logs, names."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet
import pytest
from exported import (
    PROGRAM,
    SCENARIOS,
    data_of,
    export,
    names_of,
    rows,
)
from skybody.exports import formats, table
from skybody.exports.__main__ import main
from skybody.exports.frames import quaternion_of, topic_of
from skybody.look.flight import Flight, rotation_of

pytestmark = pytest.mark.usefixtures("small_blocks")


# --- tables -------------------------------------------------------------------------------------


def check_frame(frame: pd.DataFrame, log: Path) -> None:
    data = data_of(log)
    np.testing.assert_array_equal(frame["time"], data["time"])
    for name, values in rows(data).items():
        chosen = [c for c in frame.columns if c == name or c.startswith(f"{name}/")]
        assert len(chosen) == values.shape[1]
        np.testing.assert_array_equal(frame[chosen].to_numpy(), values.astype(np.float64))


@pytest.mark.parametrize("name", SCENARIOS)
def test_csv_has_all_digits(logs: dict[str, Path], tmp_path: Path, name: str) -> None:
    out = export(logs[name], "csv", tmp_path / "a.csv")
    check_frame(pd.read_csv(out), logs[name])


def test_columns_of_tables_are_named_after_datasets_and_bodies(
    logs: dict[str, Path], tmp_path: Path
) -> None:
    columns = pd.read_csv(export(logs["chase"], "csv", tmp_path / "a.csv")).columns
    assert columns[:3].tolist() == ["time", "bodies/hawk.base_link.x", "bodies/hawk.base_link.y"]
    assert {"reward", "rotor_speed/owl.front_left", "goal/evader.base_link.yaw"} <= set(columns)
    limited = [c for c in columns if c.startswith("info/velocity_tracking.limited")]
    assert [c[-2:] for c in limited] == ["ed", "_2", "_3"]  # of three robots, with one name
    assert len(set(columns)) == len(columns)


def test_parquet_has_types_units_and_the_scenario(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["hover_sensors"]
    out = export(log, "parquet", tmp_path / "a.parquet")
    frame = pd.read_parquet(out)
    check_frame(frame, log)
    assert frame["info/tilt"].dtype == np.float32
    schema = pyarrow.parquet.read_schema(out)
    assert schema.field("bodies/quad.base_link.vx").metadata[b"unit"] == b"m/s"
    assert schema.metadata[b"scenario_text"].startswith(b"name: hover_sensors\n")


def test_a_wide_dataset_is_one_column_of_lists(
    logs: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from skybody.exports import parquet

    monkeypatch.setattr(parquet, "MOST_COLUMNS", 60)
    frame = pd.read_parquet(export(logs["chase"], "parquet", tmp_path / "a.parquet"))
    np.testing.assert_array_equal(
        np.stack(frame["observation"]), data_of(logs["chase"])["observation"]
    )
    assert "info/evader_distance" in frame


def test_npz_has_the_arrays_of_the_log(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["chase"]
    found = np.load(export(log, "npz", tmp_path / "a.npz"), allow_pickle=False)
    data = data_of(log)
    for name in ("time", *rows(data)):
        np.testing.assert_array_equal(found[name], data[name])
        assert found[name].dtype == data[name].dtype
    assert found["bodies.items"].tolist() == names_of(log, "bodies", "items")
    assert found["events.text"].tolist() == [e["text"].decode() for e in data["events"]]
    assert str(found["scenario"]) == "chase"


# --- parts of a log -----------------------------------------------------------------------------


def test_a_part_of_the_rows_and_datasets_can_be_exported(
    logs: dict[str, Path], tmp_path: Path
) -> None:
    log = logs["chase"]
    time = data_of(log)["time"].tolist()
    options = ["--from", f"{time[3]}", "--until", f"{time[15]}", "--every", "2"]
    out = export(log, "csv", tmp_path / "a.csv", *options, "--datasets", "reward,rotor_speed")
    frame = pd.read_csv(out)
    np.testing.assert_array_equal(frame["time"], time[3:16:2])
    assert {c.split("/")[0] for c in frame.columns} == {"time", "reward", "rotor_speed"}
    np.testing.assert_array_equal(
        frame["rotor_speed/hawk.front_left"], data_of(log)["rotor_speed"][3:16:2, 0]
    )


def test_rows_are_read_in_blocks_of_limited_size(
    logs: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = table.Table(Flight(logs["chase"]))
    assert [len(block.time) for block in whole.blocks()] == [7, 7, 7]
    width = len(whole.series["observation"].paths)
    monkeypatch.setattr(table, "MOST_VALUES", 2 * width)
    assert [len(block.time) for block in whole.blocks("observation")] == [2] * 10 + [1]


def test_the_file_is_written_beside_the_log_by_default(
    logs: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(logs["chase"], tmp_path / "flight.h5")
    for source, kind, name in (
        (str(tmp_path), "csv", "flight.csv"),
        (f"{tmp_path}/flight.h5:1", "rosbag2", "flight-1_bag"),
    ):
        assert main([source, "--to", kind]) == 0
        assert (tmp_path / name).exists()
        assert capsys.readouterr().out == f"{kind:<8} {tmp_path / name}\n"


def test_the_program_has_the_command(logs: dict[str, Path], tmp_path: Path) -> None:
    command = [PROGRAM, "export", logs["chase"], "--to", "npz", "-o", tmp_path / "a.npz"]
    subprocess.run(command, check=True, capture_output=True, timeout=60)
    text = subprocess.run([PROGRAM, "export", "--help"], capture_output=True, text=True).stdout
    assert all(f"--to {name}" in text for name in formats.FORMATS)


# --- names and rotations ------------------------------------------------------------------------


def test_topics_are_names_that_ros_accepts() -> None:
    assert topic_of("quad.base_link") == "/quad/base_link"
    assert topic_of("goal", "drone-1.2nd") == "/goal/drone_1/_2nd"


def test_matrices_become_the_quaternions_that_they_are_of() -> None:
    rng = np.random.default_rng(1)
    random = rng.normal(size=(200, 4))
    turns = [*random, *np.eye(4), *-np.eye(4), [0.0, 0.6, -0.8, 0.0]]
    for q in turns:
        turn = rotation_of(np.array(q))
        found = quaternion_of(turn)
        assert found[0] >= 0.0
        np.testing.assert_allclose(rotation_of(found), turn, atol=1e-15 * 4)
