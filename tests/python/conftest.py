"""Fixtures and helpers shared by the tests of the native module."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
from collections.abc import Callable

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
