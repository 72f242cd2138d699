"""Programs of ours in Python: how they are started, and how they end, also by Ctrl-C."""

from __future__ import annotations

import contextlib
import mmap
import multiprocessing
import os
import re
import signal
import sys
import warnings
from collections.abc import Callable, Iterator
from typing import NoReturn

import numpy as np

INTERRUPTED = 130  # exit code after Ctrl-C
NO_MEMORY = "error: out of memory"
BLAS_BYTES = 48 << 20  # OpenBLAS takes 32 MiB at its first product
_NO_ROOM = re.compile("failed to map segment|cannot allocate memory", re.IGNORECASE)  # the loader's


def module_command(module: str, *arguments: str) -> list[str]:
    """The words that run a module as a program, by this Python.

    Without -P Python would import from the working folder first: a stranger's `numpy.py` would run.
    """
    return [sys.executable, "-P", "-m", module, *arguments]


def run_program(main: Callable[[], int | None]) -> NoReturn:
    """Calls `main` and exits with its status; after Ctrl-C with INTERRUPTED and one line.

    Where memory runs out, it exits with 2 and one line.
    """
    # matplotlib takes a lack of memory in its import of 3D axes for a broken installation.
    warnings.filterwarnings("ignore", "Unable to import Axes3D", module="matplotlib")
    try:
        _claim_blas_memory()
        status = main()
    except (MemoryError, ImportError) as error:
        if isinstance(error, ImportError) and not _NO_ROOM.search(str(error)):
            raise
        print(NO_MEMORY, file=sys.stderr)
        status = 2
    except KeyboardInterrupt:
        _end_at_once_after_another()
        _end_children()
        print("interrupted", file=sys.stderr)
        status = INTERRUPTED
    if status == INTERRUPTED:
        _end_at_once_after_another()
    raise SystemExit(status)


def _claim_blas_memory() -> None:
    """Has NumPy's BLAS take its memory now. Raises MemoryError where there is none.

    OpenBLAS takes it at the first product, and ends the process where it fails.
    """
    try:
        mmap.mmap(-1, BLAS_BYTES).close()
    except OSError as error:
        raise MemoryError from error
    square = np.ones((8, 8))
    np.matmul(square, square)


@contextlib.contextmanager
def ignoring_interrupts() -> Iterator[None]:
    """Processes that are started within it take no notice of Ctrl-C: whoever starts them ends them.

    They would else print a traceback each.
    """
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _end_at_once_after_another() -> None:
    """One more Ctrl-C, while Python ends, would print a traceback."""
    signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))


def _end_children() -> None:
    """Ends what `multiprocessing` has started; `subprocess.run` ends its own."""
    for child in multiprocessing.active_children():
        child.terminate()
        child.join()
