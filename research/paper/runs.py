"""Runs the measurements of all items, one after the other; finished ones are not repeated."""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from research.common.pages import write_json
from research.common.places import FLIGHTS, ROOT, command_of
from research.paper.items import Item

RECORD = FLIGHTS / "paper/done.json"
Runner = Callable[[str], int]


@dataclass
class Record:
    """Measurements that have ended well, and their times [s]."""

    file: Path = RECORD

    def read(self) -> dict[str, Any]:
        """By the words of the run; empty if nothing was run."""
        return dict(json.loads(self.file.read_text())) if self.file.is_file() else {}

    def add(self, run: str, seconds: float) -> None:
        """Adds a run that has ended."""
        write_json(self.file, self.read() | {run: round(seconds, 1)})


def run_measurement(words: str) -> int:
    """Runs `python -m research run WORDS`; returns its exit code."""
    name, *options = words.split()
    return subprocess.run([*command_of(name), *options], cwd=ROOT, check=False).returncode


def run_all(
    items: Sequence[Item], again: bool, record: Record, run: Runner = run_measurement
) -> list[str]:
    """Runs each measurement once, also if several items need it; returns those that failed.

    Args:
        again: also those that have ended before.
    """
    wanted = list(dict.fromkeys(words for item in items for words in item.runs))
    failed = []
    done = {} if again else record.read()
    for number, words in enumerate(wanted, 1):
        place = f"[{number}/{len(wanted)}] {words}"
        if words in done:
            print(f"{place}: done before, in {done[words]:.0f} s", flush=True)
            continue
        print(place, flush=True)
        began = time.monotonic()
        if run(words) == 0:
            record.add(words, time.monotonic() - began)
        else:
            failed.append(words)
    return failed


def minutes(item: Item, record: Record) -> float:
    """Measured time of the item's runs, if all have ended here, or the estimate of items.yaml."""
    done = record.read()
    if item.runs and all(run in done for run in item.runs):
        return float(sum(done[run] for run in item.runs)) / 60.0
    return item.minutes
