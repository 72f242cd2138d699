"""Wrong options and run folders of skybody.train, each a clear message."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from skybody.train import evaluate
from skybody.train.__main__ import main
from skybody.train.checkpoint import checkpoint_folders, read_checkpoint
from skybody.train.presets import UsageError, preset, with_settings
from training import LEARNERS, SCENARIO, arguments, finished_run

pytestmark = pytest.mark.timeout(120)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run with evaluations."""
    return finished_run(tmp_path_factory.mktemp("train") / "run")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (["--set", "rate=3"], "no hyper-parameter `rate`"),
        (["--set", "epochs=many"], "`many` is not an integer"),
        (["--set", "hidden=a"], "`a` is not sizes as 64,64"),
        (["--set", "epochs"], "write KEY=VALUE"),
        (["--set", "discount=1.5"], "hyper-parameter discount = 1.5: allowed is 0 to 1"),
        (["--set", "log_std=nan"], "hyper-parameter log_std = nan: allowed is a finite number"),
        (["--set", "envs=4"], "--envs and --set envs=...: give one of them"),
        (
            ["--override", "stepping.horizon=0", "--eval-episodes", "1"],
            "no horizon, evaluations might never end",
        ),
        (["--threads", "100000"], "threads"),
        (["--envs", "0"], "hyper-parameter envs = 0: allowed is at least 1"),
        (["--total-steps", "0"], "--total-steps 0: at least 1"),
        (["--seed", str(2**32)], "--seed 4294967296: at most 4294967295"),
    ],
)
def test_wrong_options_are_one_clear_message(
    changes: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*arguments("lean-ppo", tmp_path / "run"), *changes]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_an_unknown_scenario_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["no_such_scenario", "--out", str(tmp_path / "run")]) == 2
    assert "no_such_scenario" in capsys.readouterr().err


def test_a_folder_that_holds_something_is_not_overwritten(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments("lean-ppo", run)) == 2
    assert "not empty" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--seed", "4"], "begun with seed 3, not 4"),
        (["--algo", "ppo"], "begun with algorithm lean-ppo, not ppo"),
        (["--set", "epochs=3"], "leave --set and --envs out"),
    ],
)
def test_a_run_is_resumed_with_its_own_options(
    options: list[str], message: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--resume", "--out", str(run), *options]) == 2
    assert message in capsys.readouterr().err


def test_there_must_be_a_run_to_resume(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--resume", "--out", str(tmp_path)]) == 2
    assert "no run to go on with" in capsys.readouterr().err


@contextmanager
def damaged(path: Path) -> Iterator[None]:
    """With the last bit of a file turned."""
    whole = path.read_bytes()
    path.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    try:
        yield
    finally:
        path.write_bytes(whole)


def test_a_damaged_checkpoint_is_named(run: Path) -> None:
    folder = checkpoint_folders(run)[0]
    with (
        damaged(folder / "environments.bin"),
        pytest.raises(ValueError, match=r"environments\.bin is damaged"),
    ):
        read_checkpoint(folder)


def test_a_damaged_policy_is_not_evaluated(run: Path) -> None:
    folder = checkpoint_folders(run)[0]
    with (
        damaged(folder / "policy.h5"),
        pytest.raises(ValueError, match=r"policy\.h5 is damaged"),
    ):
        evaluate.evaluate_checkpoint(folder, episodes=1, seed=1)


def test_a_damaged_configuration_is_named(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = run / "config.json"
    whole = path.read_bytes()
    try:
        path.write_bytes(whole[: len(whole) // 2])
        assert main(["--resume", "--out", str(run)]) == 2
    finally:
        path.write_bytes(whole)
    assert "config.json is damaged" in capsys.readouterr().err


def test_two_processes_do_not_train_in_one_folder(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    holder = """
import sys
from pathlib import Path
from skybody.train import files
with files.folder_lock(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""
    process = subprocess.Popen(
        [sys.executable, "-c", holder, str(run)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None and process.stdout.readline() == "held\n"
        assert main(["--resume", "--out", str(run)]) == 2
        assert "another process trains there" in capsys.readouterr().err
    finally:
        process.communicate("")


def test_presets_are_consistent() -> None:
    for algorithm in LEARNERS:
        preset(SCENARIO, algorithm).check()
    with pytest.raises(UsageError, match="minibatch"):
        with_settings(preset(SCENARIO, "ppo"), ["minibatch=1"]).check()


def test_a_run_that_goes_on_under_other_versions_says_so(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = run / "config.json"
    whole = path.read_text()
    try:
        path.write_text(whole.replace('"numpy": "', '"numpy": "0.'))
        assert main(["--resume", "--out", str(run)]) == 0
        assert "versions differ, and so may bits: numpy 0." in capsys.readouterr().err
    finally:
        path.write_text(whole)
