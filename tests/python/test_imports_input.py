"""`skybody import`: bad maps, logs and outputs."""

from __future__ import annotations

import gzip
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from imported import (
    BODY,
    PLACE,
    ROOT,
    TURN,
    columns,
    load,
    refused,
    write_csv,
    write_map,
)
from skybody import InputError
from skybody.imports import sources
from skybody.imports.__main__ import main
from skybody.imports.map_file import read_map, shipped_maps
from skybody.look.flight import Flight

# --- bad input ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("robot", "more", "message"),
    [
        ({"position": {"columns": ["x", "y", "h"]}}, {},
         "no column `h` for robots.cf.position. There are: qw, qx, qy, qz, t, vx, vy, vz, wx"),
        ({"position": {"columns": ["x", "y", "vxx"]}}, {}, "; did you mean `vx`? There are: qw"),
        ({"position": {"columns": ["x", "y"]}}, {}, "robots.cf.position.columns: is `['x', 'y']`"),
        ({"position": {"columns": ["x", "y", "z"], "unit": "V"}}, {},
         "robots.cf.position.unit: is `V`. Allowed: m, cm, mm"),
        ({"positoin": 1}, {}, "robots.cf.positoin: unknown key; did you mean `position`?"),
        (PLACE | {"quaternion": {"columns": ["qx", "qy", "qz", "qw"]}}, {},
         "robots.cf.quaternion.order: is missing"),
        (PLACE | {"quaternion": {"columns": ["x", "y", "z", "qw"], "order": "wxyz"}}, {},
         "robots.cf.quaternion: quaternion 1 has norm "),
        (PLACE | TURN | {"euler": {"columns": ["x", "y", "z"]}}, {},
         "robots.cf.euler: is given besides `quaternion`"),
        (PLACE | {"rotor_speed": {"columns": {"left": "x"}}}, {},
         "no rotor `left` in the model; there are: front_left, front_right"),
        (PLACE | {"rotor_speed": {"columns": {"front_left": "x"}, "law": "thrust_share"}}, {},
         "robots.cf.rotor_speed.range: is missing"),
        (PLACE, {"frame": "xyz"}, "frame: is `xyz`. Allowed: enu, ned"),
        (PLACE, {"time": {"column": "T"}}, "no column `T` for time"),
        (PLACE, {"time": None}, "time: is missing: a CSV has no times but in a column"),
        (PLACE, {"window": 0}, "window: is `0`; allowed: 0.001 to 10"),
        (PLACE | {"model": "gone.urdf"}, {}, "robots.cf.model: no file `gone.urdf`; give a URDF"),
        (PLACE | {"model": "models/firefly_arm/firefly_arm.urdf"}, {},
         "robots.cf.model: models/firefly_arm/firefly_arm.urdf has 3 bodies; allowed: one"),
    ],
)  # fmt: skip
def test_mistakes_in_maps_are_named_with_their_key(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    robot: Mapping[str, Any],
    more: Mapping[str, Any],
    message: str,
) -> None:
    log = write_csv(tmp_path / "flight.csv", columns())
    used = write_map(tmp_path / "map.yaml", robot, **more)
    assert message in refused(capsys, log, "--map", used)


def test_times_that_go_back_and_numbers_that_are_none_are_errors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    used = write_map(tmp_path / "map.yaml", PLACE | TURN)
    back = {name: values.copy() for name, values in columns().items()}
    back["t"][7] = back["t"][5]
    log = write_csv(tmp_path / "flight.csv", back)
    message = refused(capsys, log, "--map", used)
    assert f"{log}: line 9: the time of x goes back from " in message
    gap = {name: values.copy() for name, values in columns().items()}
    gap["y"][3:5] = np.nan
    write_csv(log, gap)
    message = refused(capsys, log, "--map", used)
    assert f"{log}: line 5: `y` is nan, and 2 of 400 samples are not finite" in message
    write_map(used, PLACE | TURN, gaps="interpolate")
    out = tmp_path / "a.h5"
    assert main([str(log), "--map", str(used), "-o", str(out)]) == 0
    flight = Flight(out)
    assert len(flight.time) == 400  # attitude has all rows
    np.testing.assert_allclose(flight.bodies[:, 0, :3], BODY[:, :3], atol=2e-3)  # a chord of 0.03 s


def test_equal_times_count_once(tmp_path: Path) -> None:
    twice = {name: np.repeat(values, 2) for name, values in columns().items()}
    _, body = load(tmp_path, twice, PLACE | TURN)
    np.testing.assert_array_equal(body[:, :3], BODY[:, :3])


def test_damaged_compressed_rows_are_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    used = write_map(tmp_path / "map.yaml", PLACE | TURN)
    data = bytearray(gzip.compress(write_csv(tmp_path / "flight.csv", columns()).read_bytes()))
    data[20:22] = b"\xff\xff"
    log = tmp_path / "flight.csv.gz"
    log.write_bytes(data)
    message = refused(capsys, log, "--map", used)
    assert f"{log}: its compressed data is damaged" in message or "cannot be read" in message


def test_rows_that_are_cut_short(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    used = write_map(tmp_path / "map.yaml", PLACE | TURN)
    log = write_csv(tmp_path / "flight.csv", columns())
    lines = log.read_text().splitlines()
    log.write_text("\n".join([*lines[:-1], lines[-1][:30]]))
    out = tmp_path / "a.h5"
    assert main([str(log), "--map", str(used), "-o", str(out)]) == 0
    assert capsys.readouterr().err == f"note: {log}: line 401 is cut short and left out\n"
    assert len(Flight(out).time) == 399
    log.write_text("\n".join([*lines[:5], lines[5][:30], *lines[6:]]))
    message = refused(capsys, log, "--map", used)
    assert f"{log}: line 6: has another number of cells than the names" in message
    log.write_text("\n".join([*lines[:5], lines[5].replace(lines[5].split(",")[1], "up", 1)]))
    message = refused(capsys, log, "--map", used)
    assert f"{log}: line 6, cell 2: `up` is no number, in `x` for robots.cf.position" in message
    log.write_text(lines[0] + "\n")
    assert "has no rows of numbers below its names" in refused(capsys, log, "--map", used)


def test_wrong_files_and_options_are_errors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = write_csv(tmp_path / "flight.csv", columns())
    used = write_map(tmp_path / "map.yaml", PLACE | TURN)
    shipped = ", ".join(shipped_maps())
    assert f"--map is missing: a file, or a shipped one: {shipped}" in refused(capsys, log)
    assert f"no map `px5`; give a file, or a shipped one: {shipped}" in refused(
        capsys, log, "--map", "px5"
    )
    assert "unknown ending `.txt`; allowed: .csv, " in refused(capsys, tmp_path / "a.txt")
    assert "no rows" not in refused(capsys, tmp_path / "gone.csv", "--map", used)
    assert "has 0 rows from 9 to inf s of 3.99 s" in refused(
        capsys, log, "--map", used, "--from", "9"
    )
    used.write_text("robots: [")
    assert f"{used}: is no YAML: " in refused(capsys, log, "--map", used)
    used.write_text("[1, 2]")
    assert f"{used}: is `[1, 2]`; allowed: keys with values" in refused(capsys, log, "--map", used)
    ulog = tmp_path / "a.ulg"
    ulog.write_bytes(b"no log at all")
    assert f"{ulog}: cannot be read as a ULog" in refused(capsys, ulog)


def test_a_missing_package_is_named_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError(name="pyulog")

    monkeypatch.setattr(sources.importlib, "import_module", missing)
    message = "a.ulg: needs the package `pyulog`: `pip install pyulog`"
    with pytest.raises(InputError, match=message):
        sources.source_of(Path("a.ulg")).read(Path("a.ulg"), None)  # type: ignore[arg-type]


def test_an_output_that_cannot_be_written_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = write_csv(tmp_path / "flight.csv", columns())
    used = write_map(tmp_path / "map.yaml", PLACE | TURN)
    assert main([str(log), "--map", str(used), "-o", "/proc/none/a.h5"]) == 2
    assert capsys.readouterr().err.startswith("error: /proc/none/a.h5: cannot be written")


@pytest.mark.parametrize("name", shipped_maps())
def test_shipped_maps_are_valid(name: str) -> None:
    used = read_map(ROOT / f"python/skybody/imports/maps/{name}.yaml")
    assert used.robots[0].rotors is not None


def test_the_map_on_the_page_is_valid(tmp_path: Path) -> None:
    page = (ROOT / "docs/imports.md").read_text()
    block = page.partition("## Maps\n\n")[2].partition("\n\n")[0]
    path = tmp_path / "map.yaml"
    path.write_text("\n".join(line.removeprefix("    ") for line in block.splitlines()))
    used = read_map(path)
    assert used.robots[0].rotors is not None
    assert set(used.sensors) == {"imu.specific_force", "battery.voltage"}
