"""Every world of contact, couplings and air is flown by its baseline, and ends as its head says."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
EPISODES = 100


def near_the_goals(most: float) -> Callable[[h5py.Group], bool]:
    """Every vehicle is within `most` [m] of its goal at the end."""

    def is_success(episode: h5py.Group) -> bool:
        goals = episode["goal"][-1, :, :3]
        return bool(
            (np.linalg.norm(episode["bodies"][-1, : len(goals), :3] - goals, axis=1) < most).all()
        )

    return is_success


def on_the_deck(episode: h5py.Group) -> bool:
    """0.06 m above the deck's face, and within 0.2 m of its place aside."""
    quad, deck = episode["bodies"][-1, 0, :3], episode["bodies"][-1, 1, :3]
    aside = float(np.linalg.norm(quad[:2] - episode["goal"][-1, 0, :2]))
    return aside < 0.2 and abs(quad[2] - deck[2] - 0.03 - 0.06) < 0.005


def tool_in_place(episode: h5py.Group) -> bool:
    """Gripper within 0.01 m of its point; vehicle from 3 s on within 0.05 m of its place."""
    later = episode["time"][:] >= 3.0
    vehicle = episode["bodies"][:][later, 0, :3] - np.array([0.0, 0.0, 2.0])
    # The goal is the forearm's frame, turned as it is now: as far off as the gripper is.
    tool = episode["bodies"][-1, 2, :3] - episode["goal"][-1, 0, :3]
    return bool(np.linalg.norm(vehicle, axis=1).max() < 0.05 and np.linalg.norm(tool) < 0.01)


ROPES = [f"couplings.{name}_rod.kind=rope" for name in ("alpha", "bravo", "charlie")]
WORLDS = {
    "cooperative_payload": ([], near_the_goals(0.2)),
    "cooperative_payload on ropes": (ROPES, near_the_goals(0.2)),
    "forest": ([], near_the_goals(0.1)),
    "gates": ([], near_the_goals(0.1)),
    "platform_landing": ([], on_the_deck),
    "windy_hover": ([], near_the_goals(0.5)),
    "downwash_pair": ([], near_the_goals(0.35)),
    "low_battery": ([], near_the_goals(0.2)),
    "rotor_out": ([], near_the_goals(0.5)),
    "arm": ([], tool_in_place),
    "vehicles": ([], near_the_goals(0.3)),
}


@pytest.mark.parametrize("world", WORLDS)
def test_the_baseline_succeeds(world: str, tmp_path: Path) -> None:
    overrides, is_success = WORLDS[world]
    command = [str(PROGRAM), "run", world.split()[0], "--episodes", str(EPISODES), "--no-picture"]
    for override in overrides:
        command += ["--set", override]
    subprocess.run([*command, "--out", str(tmp_path / "log")], check=True, capture_output=True)
    with h5py.File(tmp_path / "log/flight.h5") as log:
        episodes = list(log["episodes"].values())
        successes = [episode["status"][-1] == 2 and is_success(episode) for episode in episodes]
    assert len(successes) == EPISODES
    assert np.mean(successes) >= 0.95
