"""Partial files: not found under their final name, and a link in their place is not followed."""

from __future__ import annotations

import contextlib
import os
import subprocess
from pathlib import Path

import numpy as np
from skybody.train.policy_file import Layer, Policy, write_policy

PROGRAM = Path(__file__).resolve().parents[2] / "build/release/bin/skybody"
POLICY = Policy(
    [Layer(np.ones((1, 2), np.float32), np.zeros(1, np.float32), "none")],
    np.zeros(2),
    np.ones(2),
    10.0,
)


def test_a_flight_does_not_write_through_a_link(tmp_path: Path) -> None:
    victim, out = tmp_path / "victim", tmp_path / "out"
    victim.write_text("kept")
    out.mkdir()
    (out / ".flight.h5.partial").symlink_to(victim)
    command = [PROGRAM, "run", "hover", "--steps", "3", "--no-picture", "--out", out]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert victim.read_text() == "kept"
    assert {path.name for path in out.iterdir()} == {".flight.h5.partial", "flight.h5"}


def test_a_policy_is_not_written_through_a_link(tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_text("kept")
    link = tmp_path / f".policy.h5.{os.getpid()}"
    link.symlink_to(victim)
    write_policy(tmp_path / "policy.h5", POLICY)
    assert victim.read_text() == "kept"
    assert link.is_symlink()


def test_nothing_is_left_where_a_file_cannot_get_its_name(tmp_path: Path) -> None:
    (tmp_path / "policy.h5").mkdir()
    with contextlib.suppress(OSError):
        write_policy(tmp_path / "policy.h5", POLICY)
    assert [path.name for path in tmp_path.iterdir()] == ["policy.h5"]
