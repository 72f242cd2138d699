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
        (["--set", "stepping.dt=0.001"], "`--override` sets a value of the scenario"),
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
        (["--plugin-path", "/nonexist"], "--plugin-path: directory does not exist: /nonexist"),
        (["--override", "stepping.horizon"], "--override stepping.horizon: error: a path"),
        (["--override", "stepping.dt=abc"], "--override stepping.dt=abc: error: `dt` is"),
    ],
)
def test_wrong_options_are_one_clear_message(
    changes: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*arguments("ppo", tmp_path / "run"), *changes]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--threads", "100000"], "--threads: 100000 is out of range; allowed: 0..1024"),
        (["--envs", "0"], "--envs: 0 is out of range; allowed: 1..16777216"),
        (["--seed", "x"], "--seed: `x` is not a whole number; allowed: 0..4294967295"),
        (["--total-steps", "1.5"], "--total-steps: `1.5` is not a whole number; allowed: 1.."),
        (["--sed", "1"], "unknown option `--sed`; did you mean `--seed`?"),
        (["--seed"], "--seed: is given without its value"),
        (["hover", "landing"], "unexpected argument `landing`"),
    ],
)
def test_a_wrong_command_line_is_one_line_in_the_form_of_the_program(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: {message}")
    assert said.endswith("; see `skybody train --help`\n")
    assert said.count("\n") == 1


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
    assert said.startswith(f"error: {message}")
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--seed", "-1"], "--seed: -1 is out of range; allowed: 0.."),
        (["--seed", str(2**64)], f"--seed: {2**64} is out of range; allowed: 0..{2**64 - 1}"),
        (
            ["--episodes", str(2**31)],
            "--episodes: 2147483648 is out of range; allowed: 1..16777216",
        ),
        (["--threads", "-1"], "--threads: -1 is out of range; allowed: 0..1024"),
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
