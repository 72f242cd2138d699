"""Files of release 0.2.0 are read as docs/compatibility.md says; tests/compatibility has them."""

from __future__ import annotations

import gzip
import hashlib
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from skybody.look.flight import Flight
from skybody.program import module_command
from skybody.train.policy_file import read_policy

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = str(ROOT / "build/release/bin/skybody")
OLD = ROOT / "tests/compatibility/0.2"
FACTS: dict[str, Any] = json.loads((OLD / "facts.json").read_text())
MISSION = str(OLD / "mission.yaml")


def run(*words: str | Path, **more: Any) -> subprocess.CompletedProcess[str]:
    """Output of a command."""
    return subprocess.run(
        list(map(str, words)), capture_output=True, text=True, timeout=100, check=False, **more
    )


def test_the_files_are_small_and_of_that_release() -> None:
    assert FACTS["skybody"].startswith("0.2.0")
    assert Flight(OLD / "log").version.startswith("0.2.0")
    size = sum(path.stat().st_size for path in OLD.parent.rglob("*") if path.is_file())
    assert size < 300_000


def test_a_policy_gives_the_same_actions() -> None:
    policy = read_policy(OLD / "policy.h5")
    actions = policy(np.array(FACTS["observations"]))
    # 0.2.0 summed in double, this release in float: an action may differ by 1e-6 (CHANGELOG.md).
    np.testing.assert_allclose(actions, FACTS["actions"], rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("policy", ["policy.h5", "run", "run/checkpoints/step_000000001200"])
def test_a_policy_flies(policy: str, tmp_path: Path) -> None:
    words = ("--policy", OLD / policy, "--steps", "40", "--no-picture", "--out", tmp_path / "log")
    done = run(PROGRAM, "run", MISSION, *words)
    assert done.returncode == 0, done.stderr
    old, new = Flight(OLD / "log"), Flight(tmp_path / "log")
    assert len(new.time) == len(old.time)
    np.testing.assert_array_equal(new.bodies[0], old.bodies[0])  # the same draw of the start
    first = [flight.data["action"][1] for flight in (old, new)]
    np.testing.assert_allclose(first[1], first[0], rtol=0.0, atol=1e-6)


def test_a_flight_log_is_read_with_the_same_values() -> None:
    flight = Flight(OLD / "log")
    with h5py.File(flight.path) as file:
        for name, (shape, digest) in FACTS["log"].items():
            values = file[name][()]
            assert list(values.shape) == shape, name
            assert hashlib.sha256(values.tobytes()).hexdigest() == digest, name
    assert flight.body_names == ["quad.base_link"]
    assert flight.bodies.shape == (41, 1, 13)
    assert np.isfinite(flight.bodies).all()


DRAWN = (
    "plot {log} --out {out}",
    "export {log} --to csv -o {out}",
    "render {log} -o {out}.png",
    "view {log} -o {out}.html",
)


@pytest.mark.parametrize("words", DRAWN)
def test_a_flight_log_is_drawn_and_exported(words: str, tmp_path: Path) -> None:
    log = shutil.copytree(OLD / "log", tmp_path / "log")
    with h5py.File(log / "flight.h5", "r+") as file:  # its scenario's files are where they were
        file.attrs["scenario_file"] = str(MISSION)
    (tmp_path / "drawn").mkdir()
    done = run(PROGRAM, *words.format(log=log, out=tmp_path / "drawn/out").split())
    assert done.returncode == 0, done.stderr
    assert any((tmp_path / "drawn").iterdir())


def test_a_scenario_has_the_same_meaning(tmp_path: Path) -> None:
    done = run(PROGRAM, "check", MISSION)
    assert done.returncode == 0, done.stderr
    words = ("--steps", "1", "--no-picture", "--out", tmp_path / "log")
    assert run(PROGRAM, "run", MISSION, "--policy", "zero", *words).returncode == 0
    with h5py.File(tmp_path / "log/flight.h5") as file:
        paths = [text.decode() for text in file["params/paths"][:]]
        values = dict(zip(paths, file["episodes/0001/params"][:].tolist(), strict=True))
    missing = {path for path in FACTS["params"] if path not in values}
    assert missing == set()
    for path, value in FACTS["params"].items():
        assert values[path] == pytest.approx(value, rel=1e-12, abs=1e-12), path


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    file = tmp_path / "recording.h5"
    file.write_bytes(gzip.decompress((OLD / "recording.h5.gz").read_bytes()))
    return file


def test_a_recording_is_read(recording: Path) -> None:
    done = run(PROGRAM, "replay", recording, "--against", recording)
    assert done.returncode == 0, done.stderr
    assert "42 transitions" in done.stdout


def test_a_recording_is_not_run_with_a_scenario_of_another_hash(recording: Path) -> None:
    done = run(PROGRAM, "replay", recording, "--scenario", MISSION)
    assert done.returncode == 2, done.stdout
    warning, error = done.stderr.strip().splitlines()
    assert "was recorded by Skybody 0.2.0" in warning
    assert FACTS["scenario_hash"] in error


def test_a_run_is_evaluated(tmp_path: Path) -> None:
    folder = shutil.copytree(OLD / "run", tmp_path / "run")
    evaluate = module_command("skybody.train.evaluate", str(folder), "--episodes", "2")
    done = run(*evaluate, cwd=OLD)
    assert done.returncode == 0, done.stderr


def test_a_run_of_another_release_is_not_resumed(tmp_path: Path) -> None:
    folder = shutil.copytree(OLD / "run", tmp_path / "run")
    words = ("--resume", "--out", folder, "--total-steps", "1800")
    done = run(PROGRAM, "train", *words, cwd=OLD)
    assert done.returncode == 2, done.stdout
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert str(folder) in done.stderr


def test_a_built_plugin_is_refused_with_one_message(tmp_path: Path) -> None:
    plugins = tmp_path / "plugins"
    shutil.copytree(OLD / "plugins", plugins)
    for path in (plugins, *plugins.iterdir()):
        path.chmod(path.stat().st_mode & ~0o022)
    words = ("--set", "effects=[{plugin: pull}]", "--plugin-path", plugins)
    done = run(PROGRAM, "check", "hover", *words)
    assert done.returncode == 2, done.stdout
    assert "was built for plugin API" in done.stderr
    assert "rebuild it against this Skybody" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
