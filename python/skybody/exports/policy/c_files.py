"""C sources of a policy: NAME.h, NAME.c and NAME.md in a folder."""

from __future__ import annotations

import argparse
from pathlib import Path

from .c_header import header
from .c_source import source_text
from .network import network_of
from .page import page
from .self_test import STEPS, actions_of, hash_of
from .source import PolicySource


def write(source: PolicySource, path: Path, options: argparse.Namespace) -> None:
    """Writes the folder; with --check also compares flights."""
    write_sources(source, path)
    if options.check:
        from .c_evaluator import CEvaluator
        from .lockstep import check

        print(check(source, lambda robot: CEvaluator(source, path, robot), options.check, 0.0))


def write_sources(source: PolicySource, folder: Path) -> None:
    """Writes the three files into a new folder."""
    network = network_of(source.policy)
    expected = hash_of(actions_of(source, STEPS))
    texts = {
        f"{source.name}.h": header(source, network, (STEPS, expected)),
        f"{source.name}.c": source_text(source, network),
        f"{source.name}.md": page(source),
    }
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (folder / name).write_text(text)
