"""Errors for which PyTorch has no exception class."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator


@contextlib.contextmanager
def memory_errors() -> Iterator[None]:
    """Raises MemoryError if PyTorch's allocator raises RuntimeError within the scope."""
    try:
        yield
    except RuntimeError as error:
        if "allocate memory" not in str(error):
            raise
        raise MemoryError(str(error)) from error
