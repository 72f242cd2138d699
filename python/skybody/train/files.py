"""Files written whole or not at all, also after a power cut or kill -9, and read in bounds."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import secrets
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path

LOCK = ".lock"  # of folder_lock()
MOST_BYTES = 2 << 30  # of a file that is read; checkpoints of the largest runs have a tenth


def write_file(path: Path, content: bytes) -> None:
    """Replaces `path` atomically. Raises OSError with its name; the file is then as it was."""
    # Nobody can foresee the name, and "x" follows no link that lies there.
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
    """A file of a folder that publish_folder() has reach the disk. Raises OSError with its name."""
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
    flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
    handle = os.open(folder / LOCK, flags, 0o644)
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
    """SHA-256 of a file's bytes. Raises as read_file()."""
    return hashlib.sha256(read_file(path)).hexdigest()
