"""The style of plots, and their files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

LEARNER_COLORS = {"fast-ppo": "C0", "gradient": "C2", "ppo": "C3"}
LIMIT = {"color": "0.3", "linewidth": 0.8, "linestyle": (0, (6, 3))}  # lines of limits


def panels(
    rows: int, columns: int, size: tuple[float, float], **more: Any
) -> tuple[Figure, NDArray[Any]]:
    """A figure of some inches, and its axes with grids (rows, columns)."""
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **more)
    for axis in axes.flat:
        axis.grid(alpha=0.3)
    return figure, axes


def plain_logarithms(*axes: Any) -> None:
    """Plain numbers at 1, 2 and 5 of logarithmic axes, such as `axis.xaxis`."""
    for axis in axes:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FormatStrFormatter("%g"))
        axis.set_minor_formatter(NullFormatter())


def save(figure: Figure, path: Path, dpi: float = 100.0) -> None:
    """Writes a PNG."""
    path.parent.mkdir(parents=True, exist_ok=True)
    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=dpi)
