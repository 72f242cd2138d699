"""A flight that is known, as logs of other programs, and its import."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from skybody.imports.__main__ import main
from skybody.look.flight import Flight, rotation_of

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
REAL = ROOT.parent / "shared/data/flights"
MODEL = "models/crazyflie/crazyflie.urdf"
ROTORS = ("front_left", "front_right", "back_left", "back_right")
FLIP = np.array([1.0, -1.0, -1.0])
START = 1_700_000_000.25  # of the recorded time [s]

Array = NDArray[np.float64]

TIME = np.arange(0.0, 4.0, 0.01)


def body_of(time: Array) -> Array:
    """A body on a rising circle, which turns about a tilted axis: the 13 values, (rows, 13)."""
    rate, spin = 1.3, 0.8  # [rad/s]
    axis = np.array([0.48, -0.36, 0.8])
    c, s = np.cos(rate * time), np.sin(rate * time)
    place = np.stack([2.0 * c, 2.0 * s, 1.0 + 0.1 * time], axis=1)
    velocity = np.stack([-2.6 * s, 2.6 * c, np.full_like(time, 0.1)], axis=1)
    half = 0.5 * spin * time
    turn = np.concatenate([np.cos(half)[:, None], np.sin(half)[:, None] * axis], axis=1)
    return np.concatenate([place, turn, velocity, np.tile(spin * axis, (len(time), 1))], axis=1)


BODY = body_of(TIME)
PLACE = {"position": {"columns": ["x", "y", "z"]}}
TURN = {"quaternion": {"columns": ["qx", "qy", "qz", "qw"], "order": "xyzw"}}


def columns() -> dict[str, Array]:
    """Columns of the known flight."""
    q = BODY[:, 3:7]
    names = ("x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz")
    found = dict(zip(names, np.concatenate([BODY[:, :3], q, BODY[:, 7:]], axis=1).T, strict=True))
    return {"t": START + TIME} | found


def write_csv(path: Path, data: Mapping[str, Sequence[Any] | Array]) -> Path:
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(data)
        for row in zip(*data.values(), strict=True):
            rows.writerow([f"{v!r}" if isinstance(v, float) else v for v in map(plain, row)])
    return path


def plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def write_map(path: Path, robot: Mapping[str, Any], **more: Any) -> Path:
    """A map of one robot `cf`."""
    content = {"time": {"column": "t"}, "robots": {"cf": {"model": MODEL, **robot}}, **more}
    content = {key: value for key, value in content.items() if value is not None}
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    return path


def load(
    tmp_path: Path, data: Mapping[str, Any], robot: Mapping[str, Any], **more: Any
) -> tuple[Flight, Array]:
    """Imports columns; gives the flight and the states of its only body."""
    log = write_csv(tmp_path / "flight.csv", data)
    used = write_map(tmp_path / "map.yaml", robot, **more)
    out = tmp_path / "flight.h5"
    assert main([str(log), "--map", str(used), "-o", str(out)]) == 0
    flight = Flight(out)
    return flight, flight.bodies[:, 0]


def same_turns(found: Array, expected: Array, tolerance: float) -> None:
    np.testing.assert_allclose(rotation_of(found), rotation_of(expected), atol=tolerance)


def refused(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """The one line about an error; nothing is written."""
    capsys.readouterr()
    out = Path(str(arguments[0])).parent / "none.h5"
    try:
        status = main([*map(str, arguments), "-o", str(out)])
    except SystemExit as error:
        status = error.code  # type: ignore[assignment]
    message = capsys.readouterr().err
    assert status == 2
    assert message.count("\n") == 1, message
    assert message.startswith("error: ")
    assert not out.exists()
    return message
