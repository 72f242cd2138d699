"""Atomic file writes, safe against a power cut or kill -9, and reads of limited size."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import os
import secrets
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path

LOCK = ".lock"  # of folder_lock()
MOST_BYTES = 2 << 30  # limit of a file that is read; the largest runs' checkpoints have a tenth


def write_file(path: Path, content: bytes) -> None:
    """Replaces `path` atomically. Raises OSError with its name; the file is then unchanged."""
    # The name is unpredictable, and "x" follows no existing link.
    partial = path.with_name(f".{path.name}.{secrets.token_hex(8)}")
    with naming(path):
        opened = partial.open("xb")
        try:
            with opened as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            partial.replace(path)
        except OSError:
            partial.unlink(missing_ok=True)
            raise
        sync_folder(path.parent)


def write_part(path: Path, content: bytes) -> None:
    """Writes a file of a folder that publish_folder() syncs. Raises OSError with its name."""
    with naming(path):
        path.write_bytes(content)


def read_file(path: Path, most: int = MOST_BYTES) -> bytes:
    """A file's bytes.

    Raises:
        ValueError: it has more than `most` bytes, or is a pipe or a device, which may never end;
            without the file's name.
        OSError: it cannot be read.
    """
    with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
        found = os.fstat(file.fileno())
        if not stat.S_ISREG(found.st_mode):
            raise ValueError("is no regular file")
        if found.st_size > most:
            raise ValueError(f"has {found.st_size} bytes; at most {most} are read")
        return file.read(found.st_size)


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Adds the name `path` to an OSError: those of write() and fsync() have no file name."""
    try:
        yield
    except OSError as error:
        raise type(error)(error.errno, error.strerror or str(error), str(path)) from error


def explain(error: Exception) -> str:
    """The file and the operating system's message, or the text of another error."""
    if isinstance(error, OSError) and error.filename is not None:
        remedy = "; --out names another folder" if error.errno == errno.EROFS else ""
        return f"{error.filename}: {error.strerror}{remedy}"
    return str(error)


@contextlib.contextmanager
def folder_lock(folder: Path) -> Iterator[None]:
    """Locks a folder. Raises BlockingIOError if another process has the lock."""
    flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
    handle = os.open(folder / LOCK, flags, 0o644)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(handle)


def publish_folder(partial: Path, final: Path) -> None:
    """Syncs a finished folder to the disk, then gives it its final name."""
    with naming(final):
        for path in partial.iterdir():
            with path.open("rb") as file:
                os.fsync(file.fileno())
        sync_folder(partial)
        partial.rename(final)
        sync_folder(final.parent)


def remove_partial_folders(parent: Path) -> None:
    """Removes folders left by an interrupted publish_folder()."""
    for path in parent.glob(".partial-*"):
        shutil.rmtree(path)


def sync_folder(path: Path) -> None:
    """Syncs the names in a folder to the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def file_hash(path: Path) -> str:
    """SHA-256 of a file's bytes. Raises the errors of read_file()."""
    return hashlib.sha256(read_file(path)).hexdigest()
