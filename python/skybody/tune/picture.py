"""The step-response picture: default gains and tuned gains."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .tuner import Outcome, Tuned

Rows = NDArray[np.float64]

DEFAULT, TUNED, TARGET = "#b3541e", "#1f5fa8", "#444444"


def draw(tuned: Tuned, file: Path) -> list[Path]:
    """Writes it. @returns the file, or nothing if matplotlib is not installed."""
    if importlib.util.find_spec("matplotlib") is None:
        return []
    from matplotlib import style

    with style.context("default"):  # independent of a matplotlibrc in the working folder
        _draw(tuned, file)
    return [file]


def _draw(tuned: Tuned, file: Path) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    program = tuned.program
    rows = len(program.names)
    figure = Figure(figsize=(10, 1.7 * (rows + 1)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows + 1, 1, sharex=True)
    for k in range(rows):
        _draw_value(axes[k], tuned, k)
    for outcome, color in ((tuned.before, DEFAULT), (tuned.after, TUNED)):
        commands = outcome.nominal.rotor_commands[:, 0]
        axes[-1].fill_between(
            program.times, commands.min(axis=1), commands.max(axis=1), color=color, alpha=0.4, lw=0
        )
    axes[-1].set_ylabel("rotors")
    axes[-1].set_xlabel("time [s]")
    axes[0].legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False)
    figure.suptitle(
        f"{tuned.vehicle.name}, {tuned.vehicle.chain}: nominal vehicle in still air; lowest: "
        "least and largest of the rotors' commands",
        fontsize=10,
    )
    figure.savefig(file, dpi=110)


def _draw_value(axis: object, tuned: Tuned, k: int) -> None:
    program = tuned.program
    plot = axis.plot  # type: ignore[attr-defined]
    plot(program.times, program.targets[:, k], color=TARGET, lw=1.0, ls="--", label="target")
    for outcome, color, label in (
        (tuned.before, DEFAULT, f"default, cost {tuned.before.cost:.2f}"),
        (tuned.after, TUNED, f"tuned, cost {tuned.after.cost:.2f}"),
    ):
        plot(program.times, _flown(tuned, outcome, k), color=color, lw=1.3, label=label)
    axis.set_ylabel(f"{program.names[k]} [{program.units[k]}]")  # type: ignore[attr-defined]
    axis.grid(alpha=0.3)  # type: ignore[attr-defined]


def _flown(tuned: Tuned, outcome: Outcome, k: int) -> Rows:
    """A value over the nominal flight, up to the time at which it was lost."""
    program, flights = tuned.program, outcome.nominal
    values: Rows = program.targets[:, k] + program.scale[k] * flights.errors[:, 0, k]
    values[flights.lost_at[0] :] = np.nan
    return values
