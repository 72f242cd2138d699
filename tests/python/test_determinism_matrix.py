"""The experiment on determinism, in small; it must detect a flight that differs."""

from __future__ import annotations

import subprocess
from pathlib import Path

from measurements import run

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"


def matrix(*options: str) -> subprocess.CompletedProcess[str]:
    return run("determinism_matrix", "--quick", "--envs", "6", "--steps", "24", *options)


def test_program_and_python_fly_the_same_in_every_shape_restored_and_under_load():
    done = matrix()
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert [text.split()[0] for text in lines] == ["hover", "payload"]
    for text in lines:  # 3 shapes, 5 ways of flying each, without and with load
        assert text.endswith("30 runs of  24 steps  identical")


def test_a_flight_that_differs_is_named_and_fails(tmp_path: Path):
    program = tmp_path / "skybody"
    program.write_text(
        f'#!/bin/sh\ncase "$*" in *--threads=4*) echo 00000000deadbeef;; *) {PROGRAM} "$@";; esac'
    )
    program.chmod(0o755)
    done = matrix("--scenarios", "hover", "--program", str(program))
    assert done.returncode == 1
    assert done.stdout.splitlines()[0].endswith("2 differ")
    where = "  differs: skybody hash, 4 threads, batches of 2, arrival"
    assert f"\n{where}: 00000000deadbeef\n" in done.stdout
    assert f"\n{where}, under load: 00000000deadbeef\n" in done.stdout


def test_a_program_that_is_not_there_is_an_error():
    done = matrix("--scenarios", "hover", "--program", "nowhere/skybody")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("determinism_matrix: nowhere/skybody: No such file")
