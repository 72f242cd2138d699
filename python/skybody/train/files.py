"""Files that are either there whole or not at all, also after a power cut or kill -9."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path


def write_file(path: Path, content: bytes) -> None:
    """Replaces `path` atomically. Raises OSError with its name; the file is then as it was."""
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    with naming(path):
        try:
            with partial.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            partial.replace(path)
        except OSError:
            partial.unlink(missing_ok=True)
            raise
        sync_folder(path.parent)


def write_part(path: Path, content: bytes) -> None:
    """A file of a folder that publish_folder() has reach the disk. Raises OSError with its name."""
    with naming(path):
        path.write_bytes(content)


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Has an OSError name `path`: those of write() and fsync() name no file."""
    try:
        yield
    except OSError as error:
        raise type(error)(error.errno, error.strerror or str(error), str(path)) from error


def explain(error: Exception) -> str:
    """The file and what the operating system says of it, or the text of another error."""
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return str(error)


@contextlib.contextmanager
def folder_lock(folder: Path) -> Iterator[None]:
    """Has a folder for itself. Raises BlockingIOError while another has it."""
    handle = os.open(folder / ".lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(handle)


def publish_folder(partial: Path, final: Path) -> None:
    """Gives a finished folder its name, after all that is in it has reached the disk."""
    with naming(final):
        for path in partial.iterdir():
            with path.open("rb") as file:
                os.fsync(file.fileno())
        sync_folder(partial)
        partial.rename(final)
        sync_folder(final.parent)


def remove_partial_folders(parent: Path) -> None:
    """Removes what an interrupted publish_folder() left."""
    for path in parent.glob(".partial-*"):
        shutil.rmtree(path)


def sync_folder(path: Path) -> None:
    """Makes the names within a folder durable."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def file_hash(path: Path) -> str:
    """SHA-256 of a file's bytes."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
