"""Files and folders that appear under their name only when they are complete."""

from __future__ import annotations

import contextlib
import errno
import tempfile
from collections.abc import Iterator
from pathlib import Path

from skybody import InputError

FORBIDDEN = (errno.EROFS, errno.EACCES, errno.EPERM)


@contextlib.contextmanager
def whole_output(path: Path) -> Iterator[Path]:
    """A place for a file or a folder that moves to `path` at the end and replaces a file there.

    Nothing is left of it if the body raises an exception.

    Raises:
        InputError: it cannot be written, or `path` is a folder.
    """
    try:
        if path.is_dir():
            raise InputError(f"{path}: is a folder; remove it, or give another name")
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.parent) as folder:
            part = Path(folder) / path.name
            yield part
            part.replace(path)
    except OSError as error:
        raise InputError(not_written(path, error)) from None


def not_written(path: Path, error: OSError) -> str:
    """The message for a place that cannot be written."""
    remedy = "; give a place that you may write" if error.errno in FORBIDDEN else ""
    return f"{path}: cannot be written ({error.strerror or error}){remedy}"


def refuse_source(path: Path, source: Path) -> None:
    """Raises InputError if a command would replace the file that it reads by its output."""
    if path.exists() and source.exists() and path.samefile(source):
        raise InputError(f"{path}: is the file to read; give the output another name")
