"""The baseline of every world of contact, couplings and air ends as the file's head states."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from measurements import module
from skybody._native import shipped_scenarios

EPISODES = 25  # of the 100 that research/physics/worlds.py flies
ROOT = Path(__file__).resolve().parents[2]


def experiment() -> ModuleType:
    """The experiment's list of worlds, with the success criterion of each."""
    return module("worlds")


worlds = experiment()


@pytest.mark.parametrize("world", worlds.WORLDS)
def test_the_baseline_succeeds(world: str, tmp_path: Path) -> None:
    successes = worlds.fly(world, EPISODES, tmp_path / "log")
    assert len(successes) == EPISODES
    assert np.mean(successes) >= 0.95


def test_every_scenario_is_flown_or_said_to_be_a_demonstration() -> None:
    flown = {world.split()[0] for world in worlds.ALL_WORLDS}
    assert set(shipped_scenarios()) == flown | worlds.DEMONSTRATIONS
