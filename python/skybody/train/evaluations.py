"""Evaluations beside training: a process each, one at a time, while training goes on.

One takes a processor away from training for about a second. A training that takes no longer than
a few of these has all processors for itself, and is evaluated when it is over.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from collections import deque
from pathlib import Path
from typing import IO

from skybody.program import module_command
from skybody.train.checkpoint import checkpoint_folders
from skybody.train.evaluation_file import read_evaluation

UNDISTURBED = 5.0  # seconds from the beginning on, in which training is alone


class Evaluations:
    """A queue of checkpoints to be evaluated by evaluate.py."""

    def __init__(self, run: Path, episodes: int, seed: int, plugin_path: list[str]) -> None:
        """Begins with checkpoints of before an interruption that have no evaluation yet."""
        self._episodes, self._seed = episodes, seed
        self._plugin_path = plugin_path
        self._waiting: deque[Path] = deque()
        self._running: subprocess.Popen[str] | None = None
        self._errors: IO[str]  # of the one that runs
        self.failures: list[str] = []
        self._begins = time.perf_counter() + UNDISTURBED
        for folder in checkpoint_folders(run):
            self.add(folder)

    def add(self, checkpoint: Path) -> None:
        """Evaluates a checkpoint when those before it are done."""
        if self._episodes > 0 and read_evaluation(checkpoint) is None:
            self._waiting.append(checkpoint)
        self.poll()

    def poll(self) -> bool:
        """Starts what can start. Returns whether an evaluation has ended since the last call."""
        ended = self._running is not None and self._running.poll() is not None
        if ended:
            self._collect()
        if self._running is None and self._waiting and time.perf_counter() >= self._begins:
            self._running = self._start(self._waiting.popleft())
        return ended

    def wait(self) -> bool:
        """To be called when training is over. Waits for one. Returns whether there was one."""
        self._begins = 0.0
        self.poll()
        if self._running is None:
            return False
        self._running.wait()  # what it says goes to a file: no pipe can fill
        return self.poll()

    def stop(self) -> None:
        """Gives up; a resumed run makes up for it."""
        self._waiting.clear()
        if self._running is not None:
            self._running.terminate()
            self._running.wait()
            self._errors.close()
            self._running = None

    def _start(self, checkpoint: Path) -> subprocess.Popen[str]:
        self._errors = tempfile.TemporaryFile("w+")  # noqa: SIM115 (closed by _collect)
        command = module_command("skybody.train.evaluate", str(checkpoint))
        command += ["--episodes", str(self._episodes), "--seed", str(self._seed)]
        command += ["--threads", "1", "--json", str(checkpoint / "evaluation.json")]
        command += [word for folder in self._plugin_path for word in ("--plugin-path", folder)]
        return subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            text=True,
            # one BLAS thread: the other processors are training's
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
            start_new_session=True,  # a Ctrl-C at the terminal is for training to handle
        )

    def _collect(self) -> None:
        assert self._running is not None
        self._errors.seek(0)
        errors = self._errors.read().strip()
        self._errors.close()
        if self._running.returncode != 0:
            self.failures.append(f"{' '.join(self._running.args)}\n{errors}")  # type: ignore[arg-type]
        self._running = None
