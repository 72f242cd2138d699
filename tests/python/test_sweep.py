"""Arguments that a sweep passes to its trials; test_ray.py flies one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from skybody.ray import sweep
from skybody.ray.trials import Trial
from skybody.train.hyperparameters import UsageError
from skybody.train.presets import TOTAL_STEPS, preset

FOLDER = Path(__file__).resolve().parent


def trials(out: Path, *words: str) -> list[Trial]:
    """Options of a command line."""
    return sweep.trials_of(sweep.parser().parse_args(["--out", str(out), *words]))


def words_after(command: list[str], option: str) -> list[str]:
    """The values of an option that may be repeated."""
    return [command[k + 1] for k, word in enumerate(command) if word == option]


def test_a_trial_that_goes_on_is_told_where_its_plugins_are(tmp_path: Path) -> None:
    (trial,) = trials(tmp_path / "sweep", "hover_learn", "--plugin-path", str(FOLDER))
    assert words_after(trial.command(1), "--plugin-path") == [str(FOLDER)]
    trial.folder.mkdir(parents=True)
    (trial.folder / "config.json").write_text("{}")
    resumed = trial.command(1)
    assert "--resume" in resumed
    assert words_after(resumed, "--plugin-path") == [str(FOLDER)]


def test_trials_find_scenario_and_plugins_from_any_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine.yaml").write_text("include: hover_learn\n")
    (tmp_path / "plugins").mkdir()
    monkeypatch.chdir(tmp_path)
    of_file, of_name = trials(Path("sweep"), "mine.yaml", "hover_learn", "--plugin-path", "plugins")
    command = of_file.command(1)
    assert str(tmp_path / "mine.yaml") in command
    assert words_after(command, "--plugin-path") == [str(tmp_path / "plugins")]
    assert words_after(command, "--out") == [str(tmp_path / "sweep" / "mine-seed=0")]
    assert "hover_learn" in of_name.command(1)


def test_a_sweep_takes_each_scenarios_own_steps_where_it_is_told_none(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("include: hover\n")
    scenarios = ["hover_learn", str(tmp_path / "mine.yaml")]
    found = trials(tmp_path / "sweep", *scenarios, "--algo", "gradient")
    own = preset("hover_learn", "gradient").total_steps
    assert own != TOTAL_STEPS
    assert [trial.total_steps for trial in found] == [own, TOTAL_STEPS]
    assert words_after(found[0].command(1), "--total-steps") == [str(own)]
    told = trials(tmp_path / "sweep", *scenarios, "--total-steps", "2e6")
    assert [trial.total_steps for trial in told] == [2_000_000, 2_000_000]


def test_a_sweep_of_other_steps_than_the_folders_is_refused(tmp_path: Path) -> None:
    def spec(*words: str) -> dict[str, Any]:
        command = ["hover_learn", "--out", str(tmp_path), *words]
        return sweep.spec_of(sweep.parser().parse_args(command))

    sweep.write_spec(tmp_path, spec())
    sweep.check_folder(tmp_path, spec())
    with pytest.raises(UsageError, match="with total_steps left out, not 640; put it back"):
        sweep.check_folder(tmp_path, spec("--total-steps", "640"))
