"""`skybody train --algo gradient` with a camera: bits, resumption, flights of its policies."""

from __future__ import annotations

import dataclasses
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from skybody._native import CompiledScenario
from skybody.train.algorithms import algorithm_of
from skybody.train.checkpoint import checkpoint_folders, read_meta
from skybody.train.native_learners import GradientLearner

pytestmark = pytest.mark.timeout(120)

PROGRAM = Path(__file__).resolve().parents[2] / "build/release/bin/skybody"
SCENARIO = "obstacles_vision"
SMALL: dict[str, Any] = {
    "envs": 12,
    "rollout_steps": 6,
    "hidden": (8, 8),
    "cnn_channels": (4, 4),
    "cnn_kernels": (5, 3),
    "cnn_strides": (3, 2),
    "cnn_features": 8,
    "physics_steps": 5,
}
ROLLOUT = 12 * 6
STEPS = 8 * ROLLOUT


@pytest.fixture(scope="module")
def compiled() -> CompiledScenario:
    return CompiledScenario(SCENARIO)


def settings(**changes: Any) -> list[str]:
    words = []
    for name, value in {**SMALL, **changes}.items():
        text = ",".join(map(str, value)) if isinstance(value, tuple) else str(value)
        words += ["--set", f"{name}={text}"]
    return words


def skybody_run(*words: str) -> subprocess.CompletedProcess[str]:
    """Runs the program."""
    return subprocess.run(
        [str(PROGRAM), *words],
        capture_output=True,
        text=True,
        check=False,
        env={"PATH": "/usr/bin:/bin", "SKYBODY_PYTHON": sys.executable},
    )


def train(out: Path, *more: str) -> Path:
    words = ["--seed", "3", "--out", str(out), "--total-steps", str(STEPS)]
    words += ["--checkpoint-every", str(2 * ROLLOUT), "--eval-episodes", "0", "--threads", "1"]
    done = skybody_run("train", SCENARIO, "--algo", "gradient", *words, *more)
    assert done.returncode == 0, done.stderr
    return out


def hashes(run: Path) -> list[str]:
    return [read_meta(folder)["parameter_hash"] for folder in checkpoint_folders(run)]


def learner(compiled: CompiledScenario, threads: int = 1, **changes: Any) -> GradientLearner:
    row = algorithm_of("gradient")
    hyper = dataclasses.replace(row.defaults(), **{**SMALL, **changes})
    made = row.make(compiled, hyper, 1, threads, 10_000)
    assert isinstance(made, GradientLearner)
    return made


def hash_after(compiled: CompiledScenario, threads: int, **changes: Any) -> int:
    made = learner(compiled, threads, **changes)
    for _ in range(3):
        made.iterate()
    return made.native_hash


@pytest.mark.parametrize("value", [0.0, 0.5])
def test_threads_change_no_bits(compiled: CompiledScenario, value: float) -> None:
    """Also with a value function that has the privileged rays."""
    changes = {"reward_weight": 1.0, "end_value_weight": value}
    one = hash_after(compiled, 1, **changes)
    assert hash_after(compiled, 2, **changes) == one
    assert hash_after(compiled, 4, **changes) == one


def test_a_run_goes_on_with_the_same_bits_and_its_policy_flies(tmp_path: Path) -> None:
    whole = train(tmp_path / "whole", *settings())
    assert len(hashes(whole)) >= 4
    cut = shutil.copytree(whole, tmp_path / "cut")
    for folder in checkpoint_folders(cut)[2:]:
        shutil.rmtree(folder)
    done = skybody_run("train", "--resume", "--out", str(cut), "--threads", "2")
    assert done.returncode == 0, done.stderr
    assert hashes(cut) == hashes(whole)

    fly = ["run", SCENARIO, "--policy", str(whole), "--episodes", "2", "--no-picture"]
    flown = skybody_run(*fly, "--out", str(tmp_path / "flight"))
    assert flown.returncode == 0, flown.stderr
    assert "warning" not in flown.stderr


@pytest.mark.parametrize(
    ("algorithm", "more", "message"),
    [
        ("ppo", [], "`ppo` learns from vectors alone"),
        ("gradient", ["--set", "cnn_kernels=40,3"], "too small or large for its network"),
        ("gradient", ["--set", "cnn_kernels=3"], "have 2, 1 and 2 entries"),
        ("gradient", ["--set", "value_images=false"], "no hyper-parameter `value_images`"),
        (
            "gradient",
            ["--override", "sensors.front.parameters.period=24"],
            "`period` of the sensor `front` is 24 physics steps of 0.002 s",
        ),
        (
            "gradient",
            ["--override", "observe=[front.depth, rays.range]"],
            "observe the task's own values",
        ),
    ],
)
def test_other_images_and_sensors_are_refused_in_one_message(
    tmp_path: Path, algorithm: str, more: list[str], message: str
) -> None:
    given = settings() if algorithm == "gradient" else []
    words = ["train", SCENARIO, "--algo", algorithm, "--out", str(tmp_path / "run"), *given, *more]
    done = skybody_run(*words)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr


def test_a_policy_has_the_networks_of_its_images(compiled: CompiledScenario) -> None:
    made = learner(compiled)
    made.iterate()
    policy = made.policy()
    assert [image.column for image in policy.images] == ["front.depth"]
    assert policy.layers[0].weight.shape[1] == compiled.observation_size + 8
