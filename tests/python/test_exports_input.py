"""`skybody export`: bad logs, options and outputs."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from exported import (
    FORMATS,
    PROGRAM,
    changed,
    export,
    read_bag,
    read_mcap,
    read_rerun,
    refused,
    remove_bodies,
)
from skybody import InputError
from skybody.exports import formats
from skybody.look.flight import log_file

pytestmark = pytest.mark.usefixtures("small_blocks")


# --- bad input ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--to", "xls"], "--to: invalid choice: 'xls'"),
        ([], "--to is missing"),
        (["--to", "csv", "--images"], "--images is not for --to csv; allowed: mcap, rosbag2, rrd"),
        (["--to", "mcap", "--storage", "mcap"], "--storage is not for --to mcap; allowed: rosbag2"),
        (["--to", "csv", "--datasets", "inf"], "no dataset `inf`; there are: bodies, goal, action"),
        (["--to", "csv", "--from", "9"], "no rows from 9 to inf s; the flight has 0 to "),
        (["--to", "csv", "--every", "0"], "--every: 0 is out of range; allowed: 1.."),
        (["--to", "mcap", "--images", "drone"], "no camera `drone`; there are: "),
    ],
)
def test_wrong_options_are_errors(
    logs: dict[str, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    options: list[str],
    message: str,
) -> None:
    out = tmp_path / "out"
    assert message in refused(capsys, logs["chase"], *options, "-o", out)
    assert not list(tmp_path.iterdir())  # nothing half-written


@pytest.mark.parametrize("command", [["export", "--to", "csv"], ["view"]])
def test_no_output_replaces_the_log_that_is_read(
    logs: dict[str, Path], tmp_path: Path, command: list[str]
) -> None:
    log = tmp_path / "flight.h5"
    shutil.copy(log_file(logs["chase"]), log)
    before = log.read_bytes()
    words = [PROGRAM, command[0], tmp_path, *command[1:], "-o", log]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (
        2,
        f"error: {log}: is the file to read; give the output another name\n",
    )
    assert log.read_bytes() == before


def cut(file: h5py.File) -> None:
    short = file["episodes/0001/info"][:-3]
    del file["episodes/0001/info"]
    file["episodes/0001/info"] = short


def go_back(file: h5py.File) -> None:
    file["episodes/0001/time"][5] = 0.0


def make_empty(file: h5py.File) -> None:
    file["episodes/0001/time"].resize(0, axis=0)


@pytest.mark.parametrize(
    ("change", "kind", "message"),
    [
        (lambda f: f.attrs.modify("format", "skybody flight log 2"), "csv",
         "is a flight log of version 2; allowed: 1"),
        (lambda f: f.attrs.modify("format", "another"), "csv", "is no flight log"),
        (cut, "csv", "is cut short: `info` has 18 rows, `time` has 21"),
        (go_back, "csv", "its times do not increase from row to row"),
        (make_empty, "csv", "episode 1 has no rows"),
        (remove_bodies, "ulog", "has no bodies; PX4's topics are of a vehicle"),
    ],
)  # fmt: skip
def test_unusable_logs_are_errors(
    logs: dict[str, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    change: Any,
    kind: str,
    message: str,
) -> None:
    log = changed(logs["chase"], tmp_path / "flight.h5", change)
    found = refused(capsys, log, "--to", kind)
    assert found.startswith(f"error: {log}: {message}")
    assert list(tmp_path.iterdir()) == [log]


def test_files_that_are_no_logs_are_errors(
    logs: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short = tmp_path / "cut.h5"
    short.write_bytes(logs["chase"].read_bytes()[:4000])
    for path in (short, tmp_path / "none.h5"):
        assert refused(capsys, path, "--to", "csv").startswith(f"error: {path}: ")
    assert "no episode 7; it has 1" in refused(capsys, f"{logs['chase']}:7", "--to", "csv")


@pytest.mark.parametrize("kind", [kind for kind in FORMATS if kind != "ulog"])
def test_logs_without_bodies_are_exported_as_far_as_they_go(
    logs: dict[str, Path], tmp_path: Path, kind: str
) -> None:
    log = changed(logs["hover_sensors"], tmp_path / "flight.h5", remove_bodies)
    assert export(log, kind, tmp_path / "out").exists()


def test_rows_that_are_not_finite_have_no_poses(logs: dict[str, Path], tmp_path: Path) -> None:
    def spoil(file: h5py.File) -> None:
        file["episodes/0001/bodies"][4, 1] = np.nan

    log = changed(logs["chase"], tmp_path / "flight.h5", spoil)
    found = read_mcap(export(log, "mcap", tmp_path / "a.mcap"))
    assert [len(found[f"/{robot}/odometry"]) for robot in ("hawk", "kite")] == [21, 20]
    assert len(found["/tf"][4][1].transforms) == 3
    bag = read_bag(export(log, "rosbag2", tmp_path / "bag"))
    assert [len(bag[f"/{robot}/odometry"]) for robot in ("hawk", "kite")] == [21, 20]
    moved = read_rerun(export(log, "rrd", tmp_path / "a.rrd"))["/world/kite/base_link"]
    assert len(moved["time"]) == 20


def test_without_the_scenario_there_are_no_shapes_and_a_note(
    logs: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def forget(file: h5py.File) -> None:
        file.attrs["scenario_file"] = "/none/gone.yaml"
        file.attrs["scenario"] = "gone"
        file.attrs["scenario_text"] = "robots: []\n"

    log = changed(logs["chase"], tmp_path / "flight.h5", forget)
    found = read_mcap(export(log, "mcap", tmp_path / "a.mcap"))
    assert "/scene" not in found
    assert len(found["/hawk/odometry"]) == 21
    note = capsys.readouterr().err
    assert note.startswith("note: without shapes: ")
    assert note.count("\n") == 1


def test_outputs_that_cannot_be_written_are_errors(
    logs: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for kind in FORMATS:
        out = Path("/proc/none/out")
        found = refused(capsys, logs["chase"], "--to", kind, "-o", out)
        assert found.startswith(f"error: {out}: cannot be written")
    folder = tmp_path / "bag"
    folder.mkdir()
    found = refused(capsys, logs["chase"], "--to", "rosbag2", "-o", folder)
    assert found == f"error: {folder}: is a folder; remove it, or give another name\n"


def test_a_missing_package_is_named_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError(name="rosbags")

    monkeypatch.setattr(formats.importlib, "import_module", missing)
    message = "--to rosbag2 needs the package `rosbags`: `pip install rosbags`"
    with pytest.raises(InputError, match=message):
        formats.FORMATS["rosbag2"].writer()
