"""The hash of a scenario depends on the content of the files it names, not on their location."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from skybody import CompiledScenario

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
GUSTS = "t,x,y,z\n0,5,0,0\n10,5,0,0\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "one"
    made.mkdir()
    (made / "gusts.csv").write_text(GUSTS)
    (made / "gusty.yaml").write_text(
        "include: hover\neffects: [{plugin: wind_table, parameters: {file: gusts.csv}}]\n"
    )
    return made


def hash_of(file: Path | str) -> int:
    return CompiledScenario(str(file)).scenario_hash


def test_a_scenario_has_one_hash_by_whatever_path(folder: Path, monkeypatch) -> None:
    whole = hash_of(folder / "gusty.yaml")
    monkeypatch.chdir(folder)
    assert hash_of("gusty.yaml") == whole
    assert hash_of(os.path.join("..", "one", "gusty.yaml")) == whole


def test_a_scenario_that_moves_with_its_files_keeps_its_hash(folder: Path, tmp_path: Path) -> None:
    before = hash_of(folder / "gusty.yaml")
    moved = shutil.copytree(folder, tmp_path / "other")
    assert hash_of(moved / "gusty.yaml") == before


def test_an_edited_file_is_another_scenario(folder: Path) -> None:
    before = hash_of(folder / "gusty.yaml")
    (folder / "gusts.csv").write_text(GUSTS.replace("5,0,0", "6,0,0"))
    edited = hash_of(folder / "gusty.yaml")
    assert edited != before
    (folder / "gusts.csv").write_text(GUSTS)
    assert hash_of(folder / "gusty.yaml") == before


def test_what_is_written_out_counts_and_a_key_taken_out_does_not() -> None:
    def hash_with(*overrides: str) -> int:
        return CompiledScenario("hover", overrides=list(overrides)).scenario_hash

    for given in ("sensors=[]", "stepping.integrator=midpoint"):  # the defaults
        assert hash_with(given) != hash_with()
        assert hash_with(given, given.split("=")[0] + "=~") == hash_with()


def test_a_recording_is_replayed_whatever_path_it_was_made_by(folder: Path) -> None:
    def skybody(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [str(PROGRAM), *arguments], cwd=folder, capture_output=True, text=True, check=False
        )

    made = skybody("hash", "gusty.yaml", "--envs", "2", "--steps", "50", "--record", "wt.rep")
    assert made.returncode == 0, made.stderr
    done = skybody("replay", "wt.rep")
    assert done.returncode == 0 and done.stdout.startswith("identical"), done.stdout + done.stderr
    (folder / "gusts.csv").write_text(GUSTS.replace("5,0,0", "6,0,0"))
    edited = skybody("replay", "wt.rep")
    assert edited.returncode == 2 and "hash" in edited.stderr
