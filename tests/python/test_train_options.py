"""Wrong options of skybody.train, each a clear message."""

from __future__ import annotations

from pathlib import Path

import pytest
from skybody.train import evaluate
from skybody.train.__main__ import main
from skybody.train.algorithms import ALGORITHMS
from skybody.train.hyperparameters import UsageError, with_settings
from skybody.train.presets import preset
from training import SCENARIO, arguments, finished_run

pytestmark = pytest.mark.timeout(120)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run with evaluations."""
    return finished_run(tmp_path_factory.mktemp("train") / "run")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (["--set", "rate=3"], "no hyper-parameter `rate`"),
        (["--set", "leraning_rate=3"], "did you mean `learning_rate`? Allowed: envs,"),
        (["--set", "epochs=many"], "`many` is not an integer"),
        (["--set", "hidden=a"], "`a` is not sizes as 64,64"),
        (["--set", "hidden=64,,64"], "`64,,64` is not sizes as 64,64"),
        (
            ["--set", f"hidden={','.join(['4'] * 64)}"],
            "hyper-parameter hidden = 64 sizes: allowed is at most 63, as a policy file has 64",
        ),
        (["--set", "epochs"], "write KEY=VALUE"),
        (["--set", "discount=1.5"], "hyper-parameter discount = 1.5: allowed is 0 to 1"),
        (["--set", "log_std=nan"], "hyper-parameter log_std = nan: allowed is a finite number"),
        (["--set", "envs=4"], "--envs and --set envs=...: give one of them"),
        (
            ["--override", "stepping.horizon=0", "--eval-episodes", "1"],
            "no horizon, evaluations might never end",
        ),
        (["--threads", "100000"], "--threads 100000: at most 1024"),
        (["--envs", str(2**31)], "hyper-parameter envs = 2147483648: allowed is 1 to 16777216"),
        (["--plugin-path", "/nonexist"], "--plugin-path: directory does not exist: /nonexist"),
        (["--override", "stepping.horizon"], "train: --override stepping.horizon: error: a path"),
        (["--override", "stepping.dt=abc"], "train: --override stepping.dt=abc: error: `dt` is"),
        (["--envs", "0"], "hyper-parameter envs = 0: allowed is 1 to 16777216"),
        (["--total-steps", "0"], "--total-steps 0: at least 1"),
        (["--seed", str(2**32)], "--seed 4294967296: at most 4294967295"),
    ],
)
def test_wrong_options_are_one_clear_message(
    changes: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*arguments("ppo", tmp_path / "run"), *changes]) == 2
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
    assert main(arguments("ppo", run)) == 2
    assert "not empty" in capsys.readouterr().err
    assert main(arguments("ppo", run / "config.json")) == 2
    assert "config.json is a file: name a new folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (["--algo", "lean-ppo"], "the learner `lean-ppo` has gone: `fast-ppo` learns by the same"),
        (["--algo", "fast-pp"], "no learner `fast-pp`; did you mean `fast-ppo`?"),
        (["--workers", "4"], "--workers 4 is of a cluster: give --ray ADDRESS, too"),
        (["--ray", "local"], "--algo gradient: with --ray there is fast-ppo alone"),
    ],
)
def test_a_learner_that_there_is_not_is_one_message(
    changes: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = [SCENARIO, "--algo", "gradient", "--out", str(tmp_path / "run"), *changes]
    assert main(command) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"train: {message}")
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--seed", "-1"], "--seed -1: at least 0"),
        (["--seed", str(2**64)], f"--seed {2**64}: at most {2**64 - 1}"),
        (["--episodes", str(2**31)], "--episodes 2147483648: at most 16777216"),
        (["--threads", "-1"], "--threads -1: at least 0"),
    ],
)
def test_numbers_out_of_range_are_evaluates_own_errors(
    options: list[str], message: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        evaluate.main([str(run), *options])
    assert ended.value.code == 2
    assert message in capsys.readouterr().err


def test_presets_are_consistent() -> None:
    for algorithm in ALGORITHMS:
        preset(SCENARIO, algorithm).hyper.check()
    with pytest.raises(UsageError, match="minibatch"):
        with_settings(preset(SCENARIO, "ppo").hyper, ["minibatch=1"]).check()
