"""The shipped policies for bodies suspended from a robot or balanced on it fly their scenarios."""

from __future__ import annotations

import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
POLICIES = ("payload_learn", "payload_modular_learn", "pendulum_learn", "pendulum_learn_randomized")
EPISODES = 30  # the same flights in every run


@pytest.mark.parametrize("name", POLICIES)
def test_a_shipped_policy_succeeds(name: str, tmp_path: Path) -> None:
    command = [str(ROOT / "build/release/bin/skybody"), "run", name, "--policy", "shipped"]
    command += ["--episodes", str(EPISODES), "--no-picture", "--out", str(tmp_path / "log")]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    assert "warning" not in done.stderr, "the scenario is the one that it was trained on"
    with h5py.File(tmp_path / "log/flight.h5") as log:
        succeeded = [
            e["info"][-1, list(e["info"].attrs["columns"]).index("success")]
            for e in log["episodes"].values()
        ]
    assert len(succeeded) == EPISODES
    assert np.mean(succeeded) >= 0.9
