"""What a sweep tells its trials; test_ray.py flies one."""

from __future__ import annotations

from pathlib import Path

import pytest
from skybody.ray import sweep
from skybody.ray.trials import Trial

FOLDER = Path(__file__).resolve().parent


def trials(out: Path, *words: str) -> list[Trial]:
    """Those of a command line."""
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
