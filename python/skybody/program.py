"""Start and end of Skybody's Python programs, including Ctrl-C and lack of memory."""

from __future__ import annotations

import contextlib
import logging
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
BLAS_BYTES = 48 << 20  # OpenBLAS allocates 32 MiB at its first product
# Of the loader; and of CPython, whose imports lose the MemoryError if memory runs out in them.
_NO_ROOM = re.compile(
    "failed to map segment|cannot allocate memory|error return without exception set", re.IGNORECASE
)

# Matplotlib warns, when imported, that without a home that can be written its cache is temporary.
logging.getLogger("matplotlib").addFilter(lambda record: record.levelno > logging.WARNING)


def module_command(module: str, *arguments: str) -> list[str]:
    """Command line that runs a module as a program with this Python.

    Without -P Python would import from the working folder first and run another user's `numpy.py`.
    """
    return [sys.executable, "-P", "-m", module, *arguments]


def run_program(main: Callable[[], int | None]) -> NoReturn:
    """Calls `main` and exits with its status; after Ctrl-C with INTERRUPTED and one line.

    If memory runs out, it exits with 2 and one line.
    """
    # If the import of its 3D axes runs out of memory, matplotlib reports a broken installation.
    warnings.filterwarnings("ignore", "Unable to import Axes3D", module="matplotlib")
    try:
        _claim_blas_memory()
        status = main()
    except (MemoryError, ImportError, SystemError) as error:
        if not isinstance(error, MemoryError) and not _NO_ROOM.search(str(error)):
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
    """Makes NumPy's BLAS allocate its memory now. Raises MemoryError if there is not enough.

    OpenBLAS allocates at the first product, and ends the process if that fails.
    """
    try:
        mmap.mmap(-1, BLAS_BYTES).close()
    except OSError as error:
        raise MemoryError from error
    square = np.ones((8, 8))
    np.matmul(square, square)


@contextlib.contextmanager
def ignoring_interrupts() -> Iterator[None]:
    """Processes started within this scope ignore Ctrl-C; their parent ends them.

    Otherwise each would print a traceback.
    """
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _end_at_once_after_another() -> None:
    """A second Ctrl-C, while Python ends, would print a traceback."""
    signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))


def _end_children() -> None:
    """Ends the processes of `multiprocessing`; `subprocess.run` ends its own."""
    for child in multiprocessing.active_children():
        child.terminate()
        child.join()
