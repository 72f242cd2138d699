"""Held-out flights of a trained policy by `skybody run`, and their results."""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray
from skybody.train.checkpoint import checkpoint_folders, read_meta

from research.common.pages import write_json
from research.common.programs import run_skybody
from research.common.training_runs import Run

SEED = 4242  # of the flights; used neither in training nor in its evaluations
SUCCESS = "success"
TERMINATED, FAULT = 1, 4  # bits of the log's `status` (docs/flight-log.md)
FORMAT = 2  # of the file of flights
INFOS = ("at_the_end", "last_second", "whole_flight")  # members of Flights


@dataclass
class Flights:
    """Results of all episodes, one value each."""

    succeeded: NDArray[np.bool_]  # by the task's own info, at the end
    failed: NDArray[np.bool_]  # ended by a fault, or by the task without success
    at_the_end: dict[str, NDArray[np.float64]]  # infos
    last_second: dict[str, NDArray[np.float64]]  # infos, averaged over it
    whole_flight: dict[str, NDArray[np.float64]]  # likewise
    line: str = ""  # printed by `skybody run` on successes


def fly(program: Path, run: Run, episodes: int) -> Flights:
    """Flies the newest checkpoint; earlier flights are read from a file beside it."""
    checkpoint = checkpoint_folders(run.folder)[-1]
    asked = {
        "parameter_hash": read_meta(checkpoint)["parameter_hash"],
        "episodes": episodes,
        "seed": SEED,
        "format": FORMAT,
    }
    path = checkpoint / f"flights-{SEED}-{episodes}.json"
    if path.exists():
        found = json.loads(path.read_text())
        if found["asked"] == asked:
            return from_json(found)
    with tempfile.TemporaryDirectory(dir=run.folder, prefix=".flight-") as folder:
        line = _command(program, run, checkpoint, episodes, Path(folder))
        flights = read_log(Path(folder) / "flight.h5", line)
    write_json(path, {"asked": asked, **to_json(flights)})
    return flights


def _command(program: Path, run: Run, policy: Path, episodes: int, out: Path) -> str:
    """Flies into `out`; returns the line on successes."""
    words = ["run", run.scenario, "--policy", policy, "--no-picture", "--episodes", str(episodes)]
    words += ["--seed", str(SEED), "--out", out]
    printed = run_skybody(*words, overrides=run.overrides, program=program)
    return next((x for x in printed.splitlines() if x.startswith(f"{SUCCESS}: ")), "")


def read_log(log: Path, line: str = "") -> Flights:
    """Reads a flight.h5."""
    ends, seconds, wholes, statuses = [], [], [], []
    with h5py.File(log) as file:
        period = float(file.attrs["dt"]) * int(file.attrs["action_repeat"])
        for episode in file["episodes"].values():
            names = [_text(name) for name in episode["info"].attrs["columns"]]
            info = np.asarray(episode["info"][1:], np.float64)  # row 0 is the reset's
            ends.append(info[-1])
            seconds.append(info[-max(1, round(1.0 / period)) :].mean(axis=0))
            wholes.append(info.mean(axis=0))
            statuses.append(int(episode["status"][-1]))
    status = np.array(statuses)

    def by_name(rows: list[NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
        return {name: np.array(rows)[:, k] for k, name in enumerate(names)}

    at_the_end = by_name(ends)
    succeeded = at_the_end[SUCCESS] > 0.5
    return Flights(
        succeeded=succeeded,
        failed=(status & FAULT != 0) | ((status & TERMINATED != 0) & ~succeeded),
        at_the_end=at_the_end,
        last_second=by_name(seconds),
        whole_flight=by_name(wholes),
        line=line,
    )


def _text(name: Any) -> str:
    return name.decode() if isinstance(name, bytes) else str(name)


def to_json(flights: Flights) -> dict[str, Any]:
    """Converts to lists, for a file."""
    return {
        "line": flights.line,
        "succeeded": flights.succeeded.tolist(),
        "failed": flights.failed.tolist(),
        **{part: {n: x.tolist() for n, x in getattr(flights, part).items()} for part in INFOS},
    }


def from_json(found: dict[str, Any]) -> Flights:
    """The inverse of to_json()."""
    return Flights(
        succeeded=np.array(found["succeeded"], bool),
        failed=np.array(found["failed"], bool),
        **{part: {n: np.array(x, float) for n, x in found[part].items()} for part in INFOS},
        line=found["line"],
    )
