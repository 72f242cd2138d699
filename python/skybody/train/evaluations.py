"""Evaluations during training: separate processes, one at a time.

An evaluation occupies one processor for about a second. A training that takes no longer than
a few of these keeps all processors, and is evaluated at its end.
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

UNDISTURBED = 5.0  # seconds from the start in which no evaluation starts


class Evaluations:
    """A queue of checkpoints for evaluate.py."""

    def __init__(self, run: Path, episodes: int, seed: int, plugin_path: list[str]) -> None:
        """Begins with the checkpoints before an interruption that have no evaluation yet."""
        self._episodes, self._seed = episodes, seed
        self._plugin_path = plugin_path
        self._waiting: deque[Path] = deque()
        self._running: subprocess.Popen[str] | None = None
        self._errors: IO[str]  # of the running evaluation
        self.failures: list[str] = []
        self._begins = time.perf_counter() + UNDISTURBED
        for folder in checkpoint_folders(run):
            self.add(folder)

    def add(self, checkpoint: Path) -> None:
        """Evaluates a checkpoint after those before it."""
        if self._episodes > 0 and read_evaluation(checkpoint) is None:
            self._waiting.append(checkpoint)
        self.poll()

    def poll(self) -> bool:
        """Starts the next evaluation if possible. Returns whether one ended since the last call."""
        ended = self._running is not None and self._running.poll() is not None
        if ended:
            self._collect()
        if self._running is None and self._waiting and time.perf_counter() >= self._begins:
            self._running = self._start(self._waiting.popleft())
        return ended

    def wait(self) -> bool:
        """Waits for one evaluation after the end of training. Returns whether there was one."""
        self._begins = 0.0
        self.poll()
        if self._running is None:
            return False
        self._running.wait()  # its output goes to a file: no pipe can fill
        return self.poll()

    def stop(self) -> None:
        """Stops the evaluations; a resumed run repeats them."""
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
            # one BLAS thread: training uses the other processors
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
            start_new_session=True,  # Ctrl-C at the terminal goes to training only
        )

    def _collect(self) -> None:
        assert self._running is not None
        self._errors.seek(0)
        errors = self._errors.read().strip()
        self._errors.close()
        if self._running.returncode != 0:
            self.failures.append(f"{' '.join(self._running.args)}\n{errors}")  # type: ignore[arg-type]
        self._running = None
