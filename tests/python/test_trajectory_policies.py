"""The shipped policies for the worlds of task `trajectory` fly them."""

from __future__ import annotations

import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
EPISODES = 5
MOST = {  # mean distance from the path from 3 s on [m]
    "trajectory": 0.1,
    "trajectory_modular": 0.1,
    "trajectory_ctbr": 0.1,
    "trajectory_compact": 0.05,
}


@pytest.mark.parametrize("name", MOST)
def test_the_shipped_policy_follows_drawn_paths(name: str, tmp_path: Path) -> None:
    command = [str(PROGRAM), "run", name, "--policy", "shipped", "--episodes", str(EPISODES)]
    command += ["--seed", "77", "--no-picture", "--out", str(tmp_path / "log")]
    subprocess.run(command, check=True, capture_output=True)
    with h5py.File(tmp_path / "log/flight.h5") as log:
        assert len(log["episodes"]) == EPISODES
        for episode in log["episodes"].values():
            assert episode["status"][-1] == 2, "truncated, nothing else"
            away = episode["bodies"][:, 0, :3] - episode["goal"][:, 0, :3]
            flown = episode["time"][:] > 3.0
            assert np.linalg.norm(away[flown], axis=1).mean() < MOST[name]
