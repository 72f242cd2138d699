"""Shipped team policies fly as well as the pages of their tasks state; all are found by name."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest
from skybody._native import scenario_file, shipped_policies
from skybody.train.evaluate import main as evaluate
from skybody.train.policy_file import shipped_policy

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = str(ROOT / "build/release/bin/skybody")
POLICIES = shipped_policies()
EPISODES = 20  # the same flights in every run


# Of 100 episodes all succeed (tasks/formation, tasks/cooperative_payload): of 20 one may fail.
@pytest.mark.parametrize(
    "scenario",
    ["formation_learn", "formation_learn_2", "formation_obstacles", "cooperative_payload_learn"],
)
def test_a_shipped_policy_succeeds(scenario: str, tmp_path: Path) -> None:
    command = [PROGRAM, "run", scenario, "--policy", "shipped", "--no-picture"]
    command += ["--episodes", str(EPISODES), "--out", str(tmp_path / "log")]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    assert "warning" not in done.stderr  # it was trained in exactly this scenario
    with h5py.File(tmp_path / "log/flight.h5") as log:
        ends = [
            e["info"][-1, list(e["info"].attrs["columns"]).index("success")]
            for e in log["episodes"].values()
        ]
    assert len(ends) == EPISODES
    assert np.mean(ends) >= 0.95


@pytest.mark.parametrize("scenario", POLICIES)
def test_every_shipped_policy_is_of_its_scenario_and_found_by_name(
    scenario: str, tmp_path: Path
) -> None:
    command = [PROGRAM, "run", scenario, "--policy", "shipped", "--no-picture", "--steps", "2"]
    done = subprocess.run(
        [*command, "--out", str(tmp_path / "log")], check=True, capture_output=True, text=True
    )
    assert "warning" not in done.stderr
    folder = Path(scenario_file(scenario)).parent
    assert Path(shipped_policy(scenario)) == folder / f"policies/{scenario}.h5"


def test_a_scenario_without_a_policy_is_told_which_ones_have_one(tmp_path: Path) -> None:
    command = [PROGRAM, "run", "collision", "--policy", "shipped", "--out", str(tmp_path / "log")]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.count("error") == 1
    assert "no policy is shipped for `collision`" in done.stderr
    assert all(name in done.stderr for name in POLICIES)
    assert not (tmp_path / "log").exists()


def test_who_has_a_file_is_told_to_train_that_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text("include: collision\nname: mine\n")
    command = [PROGRAM, "run", str(file), "--policy", "shipped", "--out", str(tmp_path / "log")]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 2
    assert "no policy is shipped for `mine`" in done.stderr
    assert f"train one with `skybody train {file}` and give its folder" in done.stderr
    assert evaluate(["shipped", "--scenario", str(file)]) == 2
    assert f"train one with `skybody train {file}` and give its folder" in capsys.readouterr().err


def test_evaluation_flies_shipped_policies_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "figures.json"
    arguments = ["shipped", "--scenario", "formation_learn_2", "--episodes", "5"]
    assert evaluate([*arguments, "--json", str(file)]) == 0
    figures = json.loads(file.read_text())
    assert figures["checkpoint"] == "shipped"
    assert figures["steps"] > 0
    assert figures["reached_share"] == 1.0
    capsys.readouterr()
    assert evaluate(["shipped"]) == 2
    assert "shipped: give --scenario" in capsys.readouterr().err
    assert evaluate(["shipped", "--scenario", "collision"]) == 2
    assert "no policy is shipped for `collision`" in capsys.readouterr().err
