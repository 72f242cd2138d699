"""Folders that cannot be written: one message with the folder and a remedy, exit code 2.

A read-only file system is mounted in a private namespace, since permissions do not stop root.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from skybody.program import module_command

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = str(ROOT / "build/release/bin/skybody")
MOUNT = 'mount -t tmpfs -o ro none "$1" && cd "$2" && shift 2 && exec "$@"'
NAMESPACE = ("unshare", "--user", "--map-root-user", "--mount", "sh", "-c", MOUNT, "sh")


def run(
    folder: Path, *command: str, cwd: Path | None = None, **more: str
) -> subprocess.CompletedProcess[str]:
    """Runs a command to which `folder` is a read-only file system."""
    return subprocess.run(
        [*NAMESPACE, str(folder), str(cwd or folder.parent), *command],
        env={**os.environ, **more},
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "fixed"
    made.mkdir()
    if shutil.which("unshare") is None or run(made, "true").returncode != 0:
        pytest.skip("no file system can be mounted here")
    return made


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("flight") / "log"
    words = [PROGRAM, "run", "hover", "--steps", "300", "--no-picture", "--out", str(out)]
    subprocess.run(words, check=True, capture_output=True, timeout=100)
    return out


COMMANDS = {
    "run": "{program} run hover --steps 100 --out {folder}/out",
    "hash": "{program} hash hover --steps 10 --record {folder}/run.h5",
    "new": "{program} new controller my_law --dir {folder}",
    "plot": "{program} plot {flight} --out {folder}/figures",
    "render": "{program} render {flight} -o {folder}/film.gif",
    "view": "{program} view {flight} -o {folder}/page.html",
    "export": "{program} export {flight} --to csv -o {folder}/out",
    "train": "{program} train hover_learn --out {folder}/run",
    "tune": "{program} tune crazyflie --out {folder}/tuned",
    "identify": "{program} identify {flight} --model qdrone2 --out {folder}/vehicle",
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_that_cannot_be_written_is_one_message(
    name: str, folder: Path, flight: Path
) -> None:
    words = COMMANDS[name].format(program=PROGRAM, folder=folder, flight=flight).split()
    done = run(folder, *words)
    assert done.returncode == 2, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert str(folder) in done.stderr
    assert "Read-only file system" in done.stderr
    if name not in ("hash", "new"):  # their messages have the given path, without a remedy
        assert re.search("give a place that you may write|--out", done.stderr)


def test_default_folders_below_a_working_folder_that_cannot_be_written(folder: Path) -> None:
    done = run(folder, PROGRAM, "run", "hover", "--steps", "100", cwd=folder)
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert "Read-only file system" in done.stderr
    assert "--out" in done.stderr


@pytest.mark.parametrize("name", ["run", "plot", "train"])
def test_a_home_that_cannot_be_written_changes_nothing(
    name: str, folder: Path, flight: Path, tmp_path: Path
) -> None:
    commands = {
        "run": [PROGRAM, "run", "hover", "--steps", "100", "--out", str(tmp_path / "out")],
        "plot": [PROGRAM, "plot", str(flight), "--out", str(tmp_path / "figures")],
        "train": module_command(
            "skybody.train", "hover_learn", "--out", str(tmp_path / "run"),
            "--total-steps", "2000", "--eval-episodes", "0", "--envs", "6",
            "--set", "rollout_steps=50", "--set", "minibatch=100", "--set", "hidden=8,8",
        ),
    }  # fmt: skip
    cache = {"XDG_CACHE_HOME": str(folder / "cache"), "XDG_CONFIG_HOME": str(folder / "config")}
    done = run(folder, *commands[name], HOME=str(folder), **cache)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr


def flown(folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """A short flight with these variables of the environment."""
    return subprocess.run(
        [PROGRAM, "run", "hover", "--steps", "100", "--out", str(folder / "out")],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )


def test_a_proxy_that_does_not_answer_changes_nothing(tmp_path: Path) -> None:
    """Nothing uses the network at run time."""
    proxy = dict.fromkeys(("http_proxy", "https_proxy", "HTTPS_PROXY"), "http://127.0.0.1:9")
    done = flown(tmp_path, **proxy)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_missing_temporary_folder_is_no_error(tmp_path: Path) -> None:
    done = flown(tmp_path, TMPDIR=str(tmp_path / "none"))
    assert done.returncode == 0, done.stderr


def test_no_module_opens_a_connection_to_another_machine_by_itself() -> None:
    """Sockets are those of ROS, autopilots, Ray and `view`, which their options name."""
    names = ("urllib.request", "http.client", "import requests", "urlopen")
    found = [
        path
        for path in (ROOT / "python/skybody").rglob("*.py")
        if any(name in path.read_text(encoding="utf-8") for name in names)
    ]
    assert found == []
