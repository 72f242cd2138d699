"""No command runs Python files of the working folder, which may be untrusted."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from measurements import RUN
from skybody.program import module_command
from skybody.ray.trials import Trial
from training import arguments, finished_run

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
# Modules that our programs import: third-party packages, the standard library, and our own.
PLANTED = (
    "numpy",
    "h5py",
    "matplotlib",
    "tqdm",
    "cmaes",
    "dataclasses",
    "skybody",
    "skybody.train",
)

pytestmark = pytest.mark.timeout(120)


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finished_run(tmp_path_factory.mktemp("trained") / "run")


@pytest.fixture
def folder(tmp_path: Path, trained: Path) -> Path:
    """A working folder with a run, and files that leave a mark when they are run."""
    shutil.copytree(trained, tmp_path / "run")
    code = f"from pathlib import Path\nPath({str(tmp_path / 'mark')!r}).write_text(__file__)\n"
    for name in PLANTED:
        package = tmp_path / name.replace(".", "/")
        package.mkdir()
        for file in ("__init__.py", "__main__.py"):
            (package / file).write_text(code)
    return tmp_path


def run(command: list[str], folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    inherited = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    done = subprocess.run(
        command,
        cwd=folder,
        capture_output=True,
        text=True,
        env={**inherited, "SKYBODY_PYTHON": sys.executable, **environment},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert not (folder / "mark").exists(), (folder / "mark").read_text()
    return done


def training(folder: Path) -> list[str]:
    words = arguments("fast-ppo", folder / "new")
    words[words.index("--total-steps") + 1] = "600"
    words[words.index("--eval-episodes") + 1] = "1"
    return [str(PROGRAM), "train", *words]


def flying(folder: Path) -> list[str]:
    return [str(PROGRAM), "run", "hover", "--steps", "5", "--out", str(folder / "flight")]


def plotting(folder: Path) -> list[str]:
    subprocess.run([*flying(folder), "--no-picture"], cwd=folder, check=True, capture_output=True)
    return [str(PROGRAM), "plot", str(folder / "flight/flight.h5")]


def tuning(folder: Path) -> list[str]:
    options = ["--candidates", "2", "--draws", "1", "--out", str(folder / "gains")]
    return [str(PROGRAM), "tune", "hummingbird", *options]


COMMANDS: dict[str, Callable[[Path], list[str]]] = {
    "train": training,
    "run": flying,
    "plot": plotting,
    "tune": tuning,
    "evaluate": lambda folder: module_command("skybody.train.evaluate", "run", "--episodes", "1"),
    "curve": lambda folder: module_command("skybody.train.curve", "run"),
    "sweep": lambda folder: module_command("skybody.ray.sweep", "--help"),
    "experiment": lambda folder: [
        *(*RUN, "hash_run", "hover", "--envs", "1", "--steps", "2"),
    ],
}


@pytest.mark.parametrize("name", COMMANDS)
def test_planted_files_are_not_run(name: str, folder: Path) -> None:
    path = {"PYTHONPATH": str(ROOT)} if name == "experiment" else {}
    run(COMMANDS[name](folder), folder, **path)
    if name == "train":  # evaluated in a separate process
        assert list(folder.glob("new/checkpoints/*/evaluation.json"))
    if name == "run":
        assert (folder / "flight/flight-0001.png").exists()


@pytest.mark.parametrize("name", ["run", "tune"])
def test_nor_through_an_empty_entry_of_pythonpath(name: str, folder: Path) -> None:
    run(COMMANDS[name](folder), folder, PYTHONPATH=":/nowhere:")


@pytest.mark.parametrize("name", ["run", "tune"])
def test_who_has_a_safe_path_by_default_gets_the_same(name: str, folder: Path) -> None:
    run(COMMANDS[name](folder), folder, PYTHONSAFEPATH="1")
    if name == "run":
        assert (folder / "flight/flight-0001.png").exists()


def test_a_trial_of_a_sweep_runs_none(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    common = ("--eval-episodes", "0", "--envs", "6", "--override", "stepping.horizon=40")
    small = ("rollout_steps=50", "minibatch=100", "epochs=2", "hidden=8,8")
    trial = Trial(folder / "trial", "hover_learn", "fast-ppo", 1, small, 300, common, False)
    trial.train(threads=1)
    assert trial.finished()
    assert not (folder / "mark").exists()


def test_a_matplotlibrc_of_the_working_folder_changes_no_picture(
    folder: Path, trained: Path
) -> None:
    (folder / "matplotlibrc").write_text("text.usetex: True\nfigure.facecolor: red\n")
    run(COMMANDS["curve"](folder), folder)
    assert (folder / "curve.png").read_bytes() == (trained / "curve.png").read_bytes()
    run(flying(folder), folder)
    assert (folder / "flight/flight-0001.png").exists()


def test_no_page_or_message_advises_to_leave_the_safe_path_out() -> None:
    words = ["git", "grep", "-nE", "python3? -m skybody", "--", ":!CHANGELOG.md"]
    found = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert found.stdout == ""
