"""Little memory (`ulimit -v`): one message of Skybody and exit code 2, none of a library's."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from skybody.program import module_command
from training import arguments

PROGRAM = Path(__file__).resolve().parents[2] / "build/release/bin/skybody"
MIB = 1 << 20

pytestmark = pytest.mark.timeout(120)


def run(command: list[str], megabytes: int) -> subprocess.CompletedProcess[str]:
    limit = megabytes * MIB
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        env={**os.environ, "SKYBODY_PYTHON": sys.executable},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
        check=False,
        timeout=60,
    )


@pytest.mark.parametrize("command", ["train", "tune"])
def test_less_than_python_needs_is_refused(command: str, tmp_path: Path) -> None:
    done = run([str(PROGRAM), command, "hover_learn", "--out", str(tmp_path / "out")], 200)
    assert done.returncode == 2
    assert done.stderr == (
        "error: the address space is limited to 200 MiB (ulimit -v); Python needs 256 MiB or more\n"
    )


def training(folder: Path) -> list[str]:
    words = arguments("fast-ppo", folder)
    words[words.index("--total-steps") + 1] = "600"
    return ["train", *words]


def tuning(folder: Path) -> list[str]:
    return ["tune", "qdrone2", "--candidates", "4", "--threads", "2", "--out", str(folder)]


@pytest.mark.parametrize("words", [training, tuning])
def test_what_is_enough_works_and_what_is_not_is_one_message(
    words: Callable[[Path], list[str]], tmp_path: Path
) -> None:
    """The point at which memory runs out does not matter: it depends on the machine's libraries."""
    status = {}
    for megabytes in range(256, 768, 32):
        done = run([str(PROGRAM), *words(tmp_path / str(megabytes))], megabytes)
        status[megabytes] = done.returncode
        if done.returncode == 0:
            break
        assert done.returncode == 2, done.stderr
        assert "memory" in done.stderr
        assert len(done.stderr.splitlines()) == 1
    assert list(status.values())[-1] == 0, status


def test_a_program_whose_memory_ends_says_so(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "from skybody.program import run_program\nrun_program(lambda: len(bytes(1 << 34)))\n"
    )
    done = run([sys.executable, str(script)], 2048)
    assert (done.returncode, done.stderr) == (2, "error: out of memory\n")
    curve = run(module_command("skybody.train.curve", str(tmp_path)), 2048)
    assert "has no rows" in curve.stderr  # this limit suffices
