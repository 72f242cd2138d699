"""Policies of a training run, flown for its page: some checkpoints, and the learning curve."""

from __future__ import annotations

import math
from pathlib import Path

from skybody import CompiledScenario, FlightPolicy, Simulation
from skybody.train.checkpoint import checkpoint_folders, read_meta
from skybody.train.hyperparameters import UsageError
from skybody.train.run_folder import Config, load_recorded, read_table

from .page import Curve, Shown, write_page
from .sampler import fly
from .samples import Samples

MOST_SHOWN = 4  # checkpoints
MOST_SECONDS = 20.0  # of a flight
SEED = 2_000  # of the flights' draws: those of no training


def is_run(path: Path) -> bool:
    """Whether a folder is that of a training run."""
    return (path / "config.json").exists()


def write_run_page(run: Path, out: Path) -> None:
    """Writes the page of a run: flights of some checkpoints, and the learning curve.

    Raises:
        UsageError: the scenario cannot be loaded, or there is no checkpoint.
        ValueError: a checkpoint is damaged.
        InputError: the page cannot be written.
    """
    config = Config.read(run)
    compiled = load_recorded(
        run / "config.json", config.scenario, config.overrides, config.plugin_path
    )
    folders = spread(checkpoint_folders(run), MOST_SHOWN)
    if not folders:
        raise UsageError(f"{run}: there is no checkpoint yet; `skybody train` writes them")
    steps = [int(read_meta(folder)["steps"]) for folder in folders]
    shown = [
        Shown(fly_checkpoint(compiled, folder), label_of(count))
        for folder, count in zip(folders, steps, strict=True)
    ]
    write_page(out, compiled.name, shown, curve_of(run, steps))


def fly_checkpoint(compiled: CompiledScenario, folder: Path) -> Samples:
    """An episode flown by a checkpoint's policy."""
    step = compiled.dt * compiled.action_repeat
    simulation = Simulation(compiled, seed=SEED)
    return fly(simulation, FlightPolicy(compiled, str(folder)), round(MOST_SECONDS / step))


def label_of(steps: int) -> str:
    """Name of the checkpoint after a number of steps."""
    return f"{steps:,} steps"


def spread(folders: list[Path], most: int) -> list[Path]:
    """At most `most` of them, the newest first, the others at equal distances."""
    if len(folders) <= most:
        return folders[::-1]
    last = len(folders) - 1
    return [folders[round(last * (1.0 - k / (most - 1)))] for k in range(most)]


def curve_of(run: Path, shown: list[int]) -> Curve | None:
    """The mean return over the steps of a run; None before its first row.

    Args:
        run: its folder.
        shown: steps of the checkpoints that the page shows; they are marked.
    """
    rows = read_table(run / "progress.csv")
    points = [(float(row["steps"]), float(row["recent_return_mean"])) for row in rows]
    points = [(x, y) for x, y in points if math.isfinite(y)]
    if not points:
        return None
    thin = points[:: max(1, len(points) // 400)]
    marks = [(float(steps), label_of(steps)) for steps in shown]
    return Curve("Learning curve", "environment steps", "return", thin, marks)
