"""Fixtures and helpers shared by the tests of the native module."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from skybody._native import CompiledScenario, Pool

Finished = subprocess.CompletedProcess[str]

# A background job starts with SIGINT ignored; tests of Ctrl-C need the default handler.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def hover() -> CompiledScenario:
    """Compiled hover, shared by tests: a compiled scenario is immutable."""
    return CompiledScenario("hover")


@pytest.fixture(scope="session")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Logs of short flights in the scenarios of tests of exports."""
    from exported import PROGRAM, SCENARIOS, STEPS

    found = {}
    for name in SCENARIOS:
        folder = tmp_path_factory.mktemp(name)
        command = [PROGRAM, "run", name, "--steps", str(STEPS), "--no-picture", "--out", folder]
        subprocess.run(command, check=True, capture_output=True, timeout=100)
        found[name] = folder / "flight.h5"
    return found


@pytest.fixture
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Exports read short logs in several blocks, too."""
    from skybody.exports import table

    monkeypatch.setattr(table, "MOST_ROWS", 7)


@pytest.fixture
def python() -> Callable[[str], Finished]:
    """Runs a script in a process of its own; a hang fails the test."""

    def run(script: str) -> Finished:
        return subprocess.run(
            [sys.executable, "-c", textwrap.dedent(script)],
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )

    return run


def begin(pool: Pool) -> NDArray[np.float32]:
    """Resets all environments of a pool that waits for all; returns one action row for each."""
    pool.send_reset()
    pool.recv()
    return np.zeros((pool.num_envs, pool.compiled.action_size), np.float32)
