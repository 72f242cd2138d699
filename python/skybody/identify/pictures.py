"""Pictures of an identification: errors over time, and one window."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from skybody.legend import legend_above

from .identify import Identified
from .judge import UNITS
from .replay import SAMPLE

COLORS = {"identified": "#1f5fa8", "nominal": "#b3541e", "nominal, thrust scaled": "#7a7a7a"}


def draw(made: Identified, folder: Path) -> None:
    """Writes errors.png and replay.png."""
    from matplotlib import style

    with style.context("default"):  # independent of a matplotlibrc in the working folder
        save(errors_figure(made), folder / "errors.png")
        save(replay_figure(made), folder / "replay.png")


def save(figure: Any, file: Path) -> None:
    """Writes a figure without matplotlib's version."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    figure.savefig(file, dpi=110, metadata={"Software": None})


def errors_figure(made: Identified) -> Any:
    """Mean errors of held-out windows over the time since their starts."""
    from matplotlib.figure import Figure

    kinds = [k for k in UNITS if np.isfinite(made.errors["nominal"].curve(k)).all()]
    figure = Figure(figsize=(3.6 * len(kinds), 3.2), layout="constrained")
    for axis, kind in zip(np.atleast_1d(figure.subplots(1, len(kinds))), kinds, strict=True):
        for name, errors in made.errors.items():
            curve = errors.curve(kind)
            times = SAMPLE * np.arange(1, len(curve) + 1)
            axis.plot(times, curve, color=COLORS[name], lw=1.6, label=name)
        axis.set(xlabel="time since the start [s]", ylabel=f"{kind} error [{UNITS[kind]}]")
        axis.set_ylim(bottom=0.0)
        axis.grid(alpha=0.3)
    handles, labels = axis.get_legend_handles_labels()
    legend_above(figure, handles, labels, 3, frameon=False)
    return figure


def replay_figure(made: Identified) -> Any:
    """The held-out window with the median error: rates, and the specific force along z."""
    from matplotlib.figure import Figure

    kind = "attitude"
    last = made.errors["identified"].of[kind][:, -1]
    row = int(np.argsort(last)[len(last) // 2])
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True)
    names = ("roll rate [rad/s]", "pitch rate [rad/s]", "yaw rate [rad/s]", "force z [m/s²]")
    measured = made.curves["identified"][1]
    times = SAMPLE * np.arange(1, measured.rate.shape[1] + 1)
    for k, (axis, name) in enumerate(zip(axes, names, strict=True)):
        wanted = measured.rate[row, :, k] if k < 3 else measured.force[row, :, 2]
        axis.plot(times, wanted, color="#222222", lw=1.2, ls="--", label="measured", zorder=5)
        for label, (predicted, _) in made.curves.items():
            values = predicted.rate[row, :, k] if k < 3 else predicted.force[row, :, 2]
            axis.plot(times, values, color=COLORS[label], lw=1.6, label=label)
        axis.set_ylabel(name, fontsize=8)
        axis.grid(alpha=0.3)
    axes[-1].set_xlabel("time since the start [s]")
    handles, labels = axes[0].get_legend_handles_labels()
    legend_above(figure, handles, labels, 4, frameon=False)
    return figure
