"""The event file of a run, for TensorBoard."""

from __future__ import annotations

import contextlib
import threading
import time
from pathlib import Path
from typing import Any

from skybody.train import files


class EventFile:
    """Curves by name. A thread of TensorBoard's writes them; its failure is the next call's."""

    def __init__(self, run: Path, first_step: int) -> None:
        """Begins a new file in `run`; curves of earlier ones end before `first_step`."""
        from tensorboard.compat.proto import event_pb2  # type: ignore[import-untyped]
        from tensorboard.summary.writer import (  # type: ignore[import-untyped]
            event_file_writer,
        )

        _keep_writers_quiet()
        self._run, self._event = run, event_pb2.Event
        with files.naming(run):
            self._writer = event_file_writer.EventFileWriter(str(run))
        start = event_pb2.SessionLog(status=event_pb2.SessionLog.START)
        self._write(self._event(step=first_step, session_log=start))

    def add(self, name: str, value: float, step: int) -> None:
        """A point of a curve. Raises OSError, which names the run's folder."""
        event = self._event(step=step)
        event.summary.value.add(tag=name, simple_value=value)
        self._write(event)

    def _write(self, event: Any) -> None:
        event.wall_time = time.time()
        with files.naming(self._run):
            self._writer.add_event(event)

    def close(self) -> None:
        """Writes what waits."""
        with files.naming(self._run):
            self._writer.close()

    def abandon(self) -> None:
        """Closes it where writing has failed before."""
        with contextlib.suppress(OSError):
            self._writer.close()


def _keep_writers_quiet() -> None:
    """TensorBoard's thread notes its failure for us, and then dies of it with a traceback."""
    others = threading.excepthook
    if getattr(others, "keeps_writers_quiet", False):
        return

    def hook(failure: threading.ExceptHookArgs) -> None:
        is_writer = type(failure.thread).__module__.startswith("tensorboard.")
        if not (is_writer and isinstance(failure.exc_value, OSError)):
            others(failure)

    hook.keeps_writers_quiet = True  # type: ignore[attr-defined]
    threading.excepthook = hook
