"""`skybody new lab` writes a repository that builds, passes its tests, trains and flies."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/release"
PROGRAM = BUILD / "bin/skybody"
# -O1 compiles faster than the default and gives the same bits.
QUICK = ("-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG")


def make(folder: Path, name: str = "my_lab") -> subprocess.CompletedProcess[str]:
    command = [PROGRAM, "new", "lab", name, "--dir", folder]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def test_a_new_lab_builds_against_skybody_and_its_tests_pass(tmp_path: Path) -> None:
    assert make(tmp_path).returncode == 0
    environment = {
        **os.environ,
        "PATH": f"{PROGRAM.parent}:{os.environ['PATH']}",
        "PYTHON": sys.executable,
        "PYTHONPATH": str(ROOT / "python"),
        "SKYBODY_PYTHON": sys.executable,
    }
    command = [tmp_path / "my_lab/check", f"-DSkybody_DIR={BUILD}", *QUICK]
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=110, check=False
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    assert "100% tests passed" in done.stdout
    assert "3 passed" in done.stdout


def test_the_files_of_a_new_lab_are_complete(tmp_path: Path) -> None:
    assert make(tmp_path).returncode == 0
    lab = tmp_path / "my_lab"
    files = [path for path in lab.rglob("*") if path.is_file()]
    assert [path for path in files if re.search("@[A-Z_]+@", path.read_text())] == []
    workflow = yaml.safe_load((lab / ".github/workflows/test.yml").read_text())
    commands = [step.get("run", "") for step in workflow["jobs"]["test"]["steps"]]
    assert any("./check" in command for command in commands)
    for part in ("vehicles/my_lab_quad", "controllers/my_lab_law", "tasks/my_lab_task"):
        assert (lab / part / "README.md").is_file()


def test_a_lab_never_replaces_a_folder(tmp_path: Path) -> None:
    (tmp_path / "my_lab").mkdir()
    done = make(tmp_path)
    assert done.returncode == 2
    assert "my_lab exists; nothing was written" in done.stderr
    assert list((tmp_path / "my_lab").iterdir()) == []
