"""skybody.train without optional packages, and without memory."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import torch
from conftest import Finished
from skybody.train.__main__ import main
from skybody.train.algorithms import NATIVE
from skybody.train.native_learners import NativeLearner
from skybody.train.torch_errors import memory_errors
from training import SCENARIO, arguments

pytestmark = pytest.mark.timeout(120)


SB3 = ["stable_baselines3", "torch"]


def train_without(packages: list[str], words: list[str], python: Callable[[str], Finished]) -> Any:
    """`skybody train` without some packages installed."""
    return python(f"""
        import runpy, sys
        for name in {packages}:
            sys.modules[name] = None  # importing it raises ModuleNotFoundError
        sys.argv = ["train", *{words}]
        runpy.run_module("skybody.train", run_name="__main__", alter_sys=True)
    """)


@pytest.mark.parametrize(
    ("algorithm", "packages", "extras"),
    [
        ("fast-ppo", ["matplotlib"], ""),
        ("gradient", ["tqdm"], ""),
        ("ppo", ["torch"], "[sb3]"),
        ("ppo", ["stable_baselines3"], "[sb3]"),
        ("ppo", ["matplotlib", "torch"], "[sb3]"),
    ],
)
def test_a_missing_package_is_one_message_with_the_remedy(
    algorithm: str,
    packages: list[str],
    extras: str,
    python: Callable[[str], Finished],
    tmp_path: Path,
) -> None:
    out = tmp_path / "run"
    words = ["hover", "--algo", algorithm, "--out", str(out)]
    done = train_without(packages, words, python)
    assert done.returncode == 2
    assert done.stderr == (
        f"error: needs {', '.join(packages)}, not installed here: `pip install '.{extras}'` in "
        "Skybody's source folder\n"
    )
    assert not out.exists()


@pytest.mark.parametrize("algorithm", NATIVE)
def test_learners_in_cpp_train_and_go_on_without_pytorch(
    algorithm: str, python: Callable[[str], Finished], tmp_path: Path
) -> None:
    out = str(tmp_path / "run")
    words = [SCENARIO, "--algo", algorithm, "--envs", "16", "--eval-episodes", "0", "--out", out]
    words += ["--set", "rollout_steps=8", "--set", "hidden=8", "--total-steps", "256"]
    words += ["--set", "minibatch=64"] if algorithm == "fast-ppo" else []
    done = train_without(SB3, words, python)
    assert done.returncode == 0, done.stderr
    done = train_without(SB3, ["--resume", "--out", out, "--total-steps", "512"], python)
    assert done.returncode == 0, done.stderr


def test_a_run_of_ppo_that_is_to_go_on_names_its_missing_package(
    python: Callable[[str], Finished], tmp_path: Path
) -> None:
    words = arguments("ppo", tmp_path / "run")
    words[words.index("--total-steps") + 1] = "300"
    assert main(words) == 0
    done = train_without(["torch"], ["--resume", "--out", str(tmp_path / "run")], python)
    assert done.returncode == 2
    assert done.stderr.startswith("error: needs torch, not installed here: `pip install '.[sb3]'`")


@pytest.mark.parametrize("module", ["train", "train.evaluate", "train.curve"])
def test_help_needs_no_package_of_the_extra(module: str, python: Callable[[str], Finished]) -> None:
    done = python(f"""
        import runpy, sys
        for name in ("h5py", "matplotlib", "stable_baselines3", "torch", "tqdm"):
            sys.modules[name] = None
        sys.argv = ["train", "--help"]
        runpy.run_module("skybody.{module}", run_name="__main__", alter_sys=True)
    """)
    assert done.returncode == 0, done.stderr
    assert "usage:" in done.stdout


def test_memory_that_is_at_its_end_in_training_is_one_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def iterate(learner: NativeLearner) -> None:
        raise MemoryError

    monkeypatch.setattr(NativeLearner, "iterate", iterate)
    assert main(arguments("fast-ppo", tmp_path / "run")) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: not enough memory: take fewer envs or rollout_steps")
    assert len(said.splitlines()) == 1


def test_memory_that_pytorch_does_not_get_is_a_memory_error() -> None:
    with pytest.raises(MemoryError, match="allocate"), memory_errors():
        torch.empty(2**58)  # beyond the address space of any processor
