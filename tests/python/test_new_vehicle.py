"""`skybody new vehicle` writes a vehicle that passes the check and hovers."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"

LONGER = ["--set", "stepping.horizon=20000"]
VEHICLES = {
    "racer": ["--mass", "0.45", "--arm", "0.11", "--thrust-to-weight", "6"],
    "hexa": ["--mass", "3", "--arm", "0.35", "--thrust-to-weight", "2.2", "--rotors", "6"],
    "plus": ["--mass", "0.03", "--arm", "0.05", "--thrust-to-weight", "1.9", "--layout", "plus"],
    "octo": ["--mass", "15", "--arm", "0.6", "--thrust-to-weight", "2", "--rotors", "8"],
}


@pytest.mark.parametrize("name", VEHICLES)
def test_a_new_vehicle_passes_check_and_hovers(name: str, tmp_path: Path) -> None:
    made = subprocess.run(
        [PROGRAM, "new", "vehicle", name, *VEHICLES[name], "--dir", tmp_path],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert made.returncode == 0, made.stderr
    folder = tmp_path / name
    files = sorted(f.name for f in folder.iterdir())
    assert files == sorted(["README.md", f"{name}.urdf", "rotors.yaml", "scenario.yaml"])
    assert "@" not in "".join(f.read_text() for f in folder.iterdir())
    checked = subprocess.run(
        [PROGRAM, "check", folder / "scenario.yaml"], capture_output=True, text=True, timeout=60
    )
    assert (checked.returncode, checked.stderr) == (0, "")
    flown = subprocess.run(
        [
            PROGRAM,
            "run",
            "scenario.yaml",
            "--policy",
            "hold",
            "--no-picture",
            "--out",
            "flight",
            *LONGER,
        ],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert flown.returncode == 0, flown.stderr
    row = next(line for line in flown.stdout.splitlines() if re.match(r"\s*1 ", line))
    assert "truncated" in row
    # Mean error [mm] over the last second. `hold` moves the largest vehicle slowly: 6 mm remain.
    assert float(row.split()[-3]) < 10.0, flown.stdout


def test_a_new_vehicle_needs_its_numbers(tmp_path: Path) -> None:
    command = [PROGRAM, "new", "vehicle", "--dir", tmp_path]
    missing = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert missing.returncode == 2
    assert "--mass is missing" in missing.stderr
    odd = subprocess.run(
        [*command, *VEHICLES["racer"], "--rotors", "5"], capture_output=True, text=True, timeout=60
    )
    assert "5 rotors cannot turn half one way and half the other" in odd.stderr


def test_an_impossible_vehicle_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    command = [PROGRAM, "new", "vehicle", "--dir", tmp_path, "--thrust-to-weight", "6"]
    for numbers, expected in (
        (
            ["--mass", "450", "--arm", "0.11"],
            "error: a vehicle of 450 kg on arms of 0.11 m would need rotors with a `max_speed` of "
            "103790 rad/s; allowed: 0.001 to 100000; give --mass and --arm that fit one another\n",
        ),
        (
            ["--mass", "1", "--arm", "10"],
            "on arms of 10 m would need rotors with a `thrust_constant`",
        ),
    ):
        done = subprocess.run([*command, *numbers], capture_output=True, text=True, timeout=60)
        assert done.returncode == 2
        assert expected in done.stderr
    assert list(tmp_path.iterdir()) == []
