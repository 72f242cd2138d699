"""Absolute names of files and folders, for processes in another working folder."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def absolute_scenario(scenario: str) -> str:
    """A scenario's file as an absolute path; the name of a shipped one is unchanged."""
    path = Path(scenario)
    return str(path.absolute()) if path.is_file() else scenario


def folders_from_anywhere(folders: Iterable[str]) -> list[str]:
    """Folders as absolute paths."""
    return [str(Path(folder).absolute()) for folder in folders]
