"""The experiment on training reproducibility, in small; it must detect a single different bit."""

from __future__ import annotations

import copy
import dataclasses
import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from measurements import module, run
from skybody.train.algorithms import algorithm_of
from skybody.train.hyperparameters import Hyperparameters

CHECKPOINTS = 10

pytestmark = pytest.mark.timeout(
    240
)  # takes half a minute on a free machine and longer on a busy one


def experiment(out: Path) -> subprocess.CompletedProcess[str]:
    """Two processes per group, 20,000 steps each."""
    options = ("--quick", "--scenarios", "hover_learn", "--out", str(out))
    return run("training_reproducibility", *options, timeout=220)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The folder of the experiment, and its report."""
    out = tmp_path_factory.mktemp("reproducibility")
    done = experiment(out)
    assert done.returncode == 0, done.stdout + done.stderr
    report = out
    content: dict[str, Any] = json.loads(
        (report / "data/training_reproducibility.json").read_text()
    )
    assert (report / "images/training_reproducibility.png").stat().st_size > 10_000
    assert "| `hover_learn` | same seed | 2 |" in (
        report / "training_reproducibility.md"
    ).read_text(encoding="utf-8")
    return out, content


def records(content: dict[str, Any], group: str) -> list[dict[str, Any]]:
    """The runs of a group."""
    figures = content["scenarios"]["hover_learn"]
    by_folder = {run["folder"]: run for run in figures["runs"]}
    return [by_folder[folder] for folder in figures["members"][group]]


def test_processes_of_one_seed_and_other_threads_have_the_same_parameters_at_every_checkpoint(
    finished: tuple[Path, dict[str, Any]],
) -> None:
    one, other = records(finished[1], "same seed")
    assert (one["threads"], other["threads"]) == (1, 2)
    assert len(one["checkpoints"]) == CHECKPOINTS
    assert one["checkpoints"] == other["checkpoints"]  # evaluations too
    assert len({point["parameter_hash"] for point in one["checkpoints"]}) == CHECKPOINTS


def test_another_seed_has_other_parameters_at_every_checkpoint(
    finished: tuple[Path, dict[str, Any]],
) -> None:
    one, other = records(finished[1], "different seeds")
    for mine, theirs in zip(one["checkpoints"], other["checkpoints"], strict=True):
        assert mine["steps"] == theirs["steps"]
        assert mine["parameter_hash"] != theirs["parameter_hash"]


def test_finished_runs_are_not_repeated(finished: tuple[Path, dict[str, Any]]) -> None:
    out = finished[0]
    before = {path: path.stat().st_mtime_ns for path in out.glob("hover_learn/*/config.json")}
    again = experiment(out)
    assert again.returncode == 0, again.stdout + again.stderr
    assert "3 runs, 3 of them finished before" in again.stdout
    assert before == {path: path.stat().st_mtime_ns for path in before}


def test_a_single_checkpoint_with_another_hash_is_reported(
    finished: tuple[Path, dict[str, Any]],
) -> None:
    experiment = module("training_reproducibility")
    group_figures, reproducible = experiment.group_figures, experiment.reproducible

    figures = finished[1]["scenarios"]["hover_learn"]
    assert reproducible(figures)
    altered = copy.deepcopy(records(finished[1], "same seed"))
    altered[1]["checkpoints"][3]["parameter_hash"] = "0" * 64
    group = group_figures(altered)
    assert group["identical_checkpoints_percent"] == 90.0
    groups = {**figures["groups"], "same seed": group}
    assert not reproducible({**figures, "groups": groups})


def test_the_experiment_writes_out_every_hyper_parameter() -> None:
    written = set(module("training_reproducibility").PAPER)
    assert written >= {field.name for field in dataclasses.fields(Hyperparameters)}
    known = (vars(algorithm_of(name).defaults()) for name in ("ppo", "fast-ppo"))
    assert written <= set().union(*known)
