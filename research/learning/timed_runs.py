"""Runs whose time from the command counts, and evaluations of their checkpoints."""

from __future__ import annotations

import json
import os
import shutil
import time
from pathlib import Path
from typing import Any

from skybody.program import module_command
from skybody.train.checkpoint import checkpoint_folders
from skybody.train.evaluation_file import read_evaluation

from research.common.pages import write_json
from research.common.programs import output_of
from research.common.training_runs import Run

EPISODES = 100


def measure(run: Run) -> dict[str, Any]:
    """Trains and returns the times [s]; for a finished run, its recorded times.

    `wall_clock` is the whole command's. `published` has, by the checkpoint's folder, the time from
    the command to the moment at which the folder got its final name: then it can be flown.
    """
    run.check()
    path = run.folder / "measured.json"
    if not path.exists():
        shutil.rmtree(run.folder, ignore_errors=True)
        load, begun = os.getloadavg()[0], time.time()
        run.train()
        seconds = time.time() - begun
        # A folder's ctime is the time of its renaming, until an evaluation is written into it.
        published = {
            folder.name: folder.stat().st_ctime - begun for folder in checkpoint_folders(run.folder)
        }
        write_json(path, {"wall_clock": seconds, "load_before": load, "published": published})
    measured: dict[str, Any] = json.loads(path.read_text())
    return measured


def evaluate(checkpoint: Path) -> None:
    """Flies EPISODES in a new process, unless an evaluation exists."""
    found = read_evaluation(checkpoint)
    if found is not None and found["episodes"] == EPISODES:
        return
    command = module_command("skybody.train.evaluate", str(checkpoint))
    path = str(checkpoint / "evaluation.json")
    output_of([*command, "--episodes", str(EPISODES), "--json", path])
