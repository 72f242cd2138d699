"""A full disk: one message, exit code 2, no incomplete file; training continues later."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
SCRIPT = Path(__file__).with_name("disk_full.py")
NOT_POSSIBLE = 3  # exit code of the script


@pytest.mark.timeout(240)
def test_every_program_meets_a_full_disk_with_one_message() -> None:
    command = [sys.executable, "-P", str(SCRIPT), "--program", str(PROGRAM)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=230, check=False)
    if done.returncode == NOT_POSSIBLE:
        pytest.skip(done.stdout.strip())
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_full_device_is_no_success(tmp_path: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [str(PROGRAM), "schema"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert done.returncode == 2
    assert done.stderr == "error: cannot write the standard output: No space left on device\n"


def test_a_pipe_whose_reader_has_ended_is_no_error() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [str(PROGRAM), "schema"],
        stdout=writer,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
        restore_signals=False,  # SIGPIPE stays ignored: the write itself fails
    )
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, "")
