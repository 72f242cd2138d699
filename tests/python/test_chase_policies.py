"""The shipped policies of forests and chases fly as well as their pages state."""

from __future__ import annotations

import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
EPISODES = 50


def successes(scenario: str, folder: Path) -> float:
    """Share of the episodes that end with success."""
    command = [str(ROOT / "build/release/bin/skybody"), "run", scenario, "--no-picture"]
    command += ["--policy", "shipped", "--episodes", str(EPISODES), "--out", str(folder)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    assert "warning" not in done.stderr  # it was trained in exactly this scenario
    with h5py.File(folder / "flight.h5") as log:
        episodes = list(log["episodes"].values())
        column = list(episodes[0]["info"].attrs["columns"]).index("success")
        return float(np.mean([episode["info"][-1, column] for episode in episodes]))


# Of 100 episodes 98, 97 and 100 succeed; 50 episodes may fall short by 3 binomial deviations.
@pytest.mark.parametrize(
    ("scenario", "least"),
    [
        ("obstacles", 0.92),
        ("obstacles_rays", 0.88),
        ("obstacles_vision", 0.94),
        ("chase", 0.98),
        ("chase_agents", 0.86),
    ],
)
def test_a_shipped_policy_succeeds(scenario: str, least: float, tmp_path: Path) -> None:
    assert successes(scenario, tmp_path / "log") >= least
