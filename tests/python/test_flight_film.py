"""scripts/flight_film.py makes an animated picture of a flight log."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
SCRIPT = ROOT / "scripts/flight_film.py"


def film(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(SCRIPT), *arguments],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )


def test_a_film_has_the_frames_of_its_seconds_and_a_still_has_one(tmp_path: Path) -> None:
    run = ["run", "payload", "--steps", "30", "--no-picture", "--out", str(tmp_path)]
    subprocess.run([str(PROGRAM), *run], check=True, capture_output=True, timeout=60)
    log, out = tmp_path / "flight.h5", tmp_path / "film.gif"
    done = film(str(out), str(log), f"{log}:1", "--quick")
    assert done.returncode == 0, done.stderr
    with Image.open(out) as picture:
        assert picture.n_frames == 4
        assert picture.width == 2 * 288  # two panels beside each other
    still = tmp_path / "still.png"
    assert film(str(still), str(log), "--seconds", "0.2").returncode == 0
    with Image.open(still) as picture:
        assert picture.width == 288
    wrong = film(str(out), f"{log}:2", "--quick")
    assert wrong.returncode == 1
    assert "has no episode 0002" in wrong.stderr
