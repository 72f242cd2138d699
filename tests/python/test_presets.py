"""Presets: a YAML file beside a shipped or a user's scenario."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from skybody._native import InputError, scenario_file
from skybody.train.__main__ import main
from skybody.train.algorithms import ALGORITHMS, algorithm_of
from skybody.train.hyperparameters import UsageError
from skybody.train.presets import TOTAL_STEPS, preset, presets_file

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    """A user's scenario without presets."""
    (tmp_path / "training").mkdir()
    path = tmp_path / "mine.yaml"
    path.write_text("include: hover\nname: mine\n")
    return path


def write_presets(scenario: Path, text: str) -> Path:
    file = scenario.parent / "training/mine.yaml"
    file.write_text(text)
    return file


def test_a_shipped_scenario_has_its_presets_by_name_and_by_file() -> None:
    file = scenario_file("hover_learn")
    for algorithm in ALGORITHMS:
        by_name = preset("hover_learn", algorithm)
        assert by_name == preset(file, algorithm)
        assert by_name.total_steps != TOTAL_STEPS


def test_every_file_of_presets_is_of_a_shipped_scenario_and_can_be_read() -> None:
    files = sorted((ROOT / "scenarios").glob("*/training/*"))
    assert files
    for file in files:
        scenario = file.parents[1] / file.name
        assert scenario.is_file(), f"{file} is of no scenario"
        for algorithm in ALGORITHMS:
            preset(str(scenario), algorithm)


def test_a_scenario_without_presets_has_the_learners_defaults(scenario: Path) -> None:
    for algorithm in ALGORITHMS:
        found = preset(str(scenario), algorithm)
        assert found.hyper == algorithm_of(algorithm).defaults()
        assert found.total_steps == TOTAL_STEPS


def test_presets_follow_the_includes_of_a_scenario(scenario: Path) -> None:
    scenario.write_text("include: [hover, base.yaml]\nname: mine\n")
    base = scenario.parent / "base.yaml"
    base.write_text("include: hover_learn\n")
    for algorithm in ALGORITHMS:
        assert preset(str(scenario), algorithm) == preset("hover_learn", algorithm)
    nearer = scenario.parent / "training/base.yaml"
    nearer.write_text("fast-ppo: {envs: 24}\n")
    assert presets_file(str(scenario)) == nearer
    assert preset(str(scenario), "fast-ppo").hyper.envs == 24
    own = write_presets(scenario, "fast-ppo: {envs: 40}\n")
    assert presets_file(str(scenario)) == own
    assert preset(str(scenario), "fast-ppo").hyper.envs == 40


def test_values_are_written_as_yaml_and_as_the_command_line_has_them(scenario: Path) -> None:
    write_presets(
        scenario,
        "fast-ppo: {total_steps: 2e6, hidden: [32, 16], bounded_mean: true, activation: elu}\n"
        "ppo: {hidden: 8, epochs: 3, learning_rate: 3e-4}\n",
    )
    fast = preset(str(scenario), "fast-ppo")
    assert fast.total_steps == 2_000_000
    assert (fast.hyper.hidden, fast.hyper.bounded_mean) == ((32, 16), True)  # type: ignore[attr-defined]
    ppo = preset(str(scenario), "ppo")
    assert (ppo.hyper.hidden, ppo.hyper.epochs, ppo.hyper.learning_rate) == ((8,), 3, 3e-4)
    assert ppo.total_steps == preset(str(scenario), "gradient").total_steps == TOTAL_STEPS


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("fast-pp: {envs: 8}\n", ":1:1", "no learner `fast-pp`; did you mean `fast-ppo`?"),
        ("fast-ppo:\n  epoch: 2\n", ":2:3", "no hyper-parameter `epoch`; did you mean `epochs`?"),
        ("fast-ppo:\n  total_step: 2\n", ":2:3", "did you mean `total_steps`?"),
        ("fast-ppo:\n  epochs: many\n", ":2:3", "`many` is not a whole number"),
        ("fast-ppo:\n  total_steps: 1.5\n", ":2:3", "`1.5` is not a whole number"),
        ("fast-ppo:\n  discount: 2\n", ":2:3", "hyper-parameter discount = 2: allowed is 0 to 1"),
        (f"fast-ppo:\n  epochs: 2\n  hidden: {[8] * 64}\n", ":3:3", "hidden = 64 sizes: allowed"),
        ("fast-ppo: 3\n", ":1:11", "it must be a map of keys and values"),
        ("fast-ppo: {envs: {a: 1}}\n", ":1:18", "it must be a value or a list of values"),
        ("fast-ppo: {envs: 8\n", ":2:1", "error"),
        ("- fast-ppo\n", ":1:1", "the file holds a list; a map of keys and values is needed"),
    ],
)
def test_a_mistake_in_presets_is_one_message_with_its_place_and_leaves_nothing(
    text: str,
    place: str,
    message: str,
    scenario: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = write_presets(scenario, text)
    with pytest.raises((UsageError, InputError)):
        preset(str(scenario), "fast-ppo")
    assert main([str(scenario), "--out", str(tmp_path / "run")]) == 2
    said = capsys.readouterr().err
    assert f"{file}{place}" in said
    assert message in said
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "run").exists()


def test_an_error_of_a_python_learner_says_the_key_of_the_wrong_value(scenario: Path) -> None:
    file = write_presets(scenario, "ppo:\n  envs: 8\n  discount: 2\n")
    with pytest.raises(UsageError, match=re.escape(f"{file}:3:3: ppo: ")) as refused:
        preset(str(scenario), "ppo")
    assert refused.value.key == "discount"
    write_presets(scenario, "nobody: {}\n")
    with pytest.raises(UsageError, match="no learner `nobody`") as refused:
        preset(str(scenario), "ppo")
    assert refused.value.key is None


def test_training_takes_the_presets_of_a_users_scenario_and_says_so(
    scenario: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    write_presets(
        scenario,
        "fast-ppo: {total_steps: 640, envs: 20, rollout_steps: 16, minibatch: 100, hidden: 8}\n",
    )
    monkeypatch.chdir(tmp_path)
    assert presets_file("mine.yaml") == Path("training/mine.yaml")
    assert main(["mine.yaml", "--eval-episodes", "0", "--out", "run"]) == 0
    said = capsys.readouterr().out
    assert "640 steps; presets of training/mine.yaml" in said
    short = ["mine.yaml", "--eval-episodes", "0", "--out", "short", "--total-steps", "320"]
    assert main(short) == 0
    assert "320 steps, in which the schedules of 640 are squeezed" in capsys.readouterr().out
    assert "640 steps in" in said
