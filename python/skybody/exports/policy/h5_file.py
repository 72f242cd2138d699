"""A policy as policy.h5, which `skybody run --policy` flies."""

from __future__ import annotations

import argparse
from pathlib import Path

from .source import PolicySource


def write(source: PolicySource, path: Path, options: argparse.Namespace) -> None:
    """Writes the file."""
    path.write_bytes(source.file.read_bytes())
