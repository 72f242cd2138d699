"""Drawing of panels: curves over time, and the style of all."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, NullFormatter
from skybody.look.motion import Array

from .rows import COMMAND, GOAL, GREY, STEPS, Curve, Row
from .subject import Subject

STYLE = {
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "lines.linewidth": 1.3,
    "legend.frameon": False,
    "agg.path.chunksize": 10000,
    "pdf.fonttype": 42,
    "svg.hashsalt": "skybody",
}
LINES: dict[str, dict[str, Any]] = {
    GOAL: {"linestyle": (0, (4, 3)), "linewidth": 0.9},
    COMMAND: {"linestyle": (0, (1, 1.5)), "linewidth": 1.0, "alpha": 0.8},
    STEPS: {"drawstyle": "steps-post"},
}
TOUCHING: dict[str, Any] = {"color": "gold", "alpha": 0.25, "linewidth": 0}
FEW_DECADES = 2.0
MOST_ROWS = 1500  # of an area
MANY = 8  # robots; the lines of more are thin


def draw_row(
    panel: Axes, subject: Subject, row: Row, letters: int, keys: Sequence[Curve] = ()
) -> None:
    """Draws a row of the table into a panel.

    Args:
        letters: number of characters that fit above the panel.
        keys: of the legend, if the row has none.
    """
    curves = row.curves(subject)
    thin = {"linewidth": 0.6} if len(subject.tracks) > MANY else {}
    for curve in curves:
        look = LINES.get(curve.style, {}) | thin
        panel.plot(subject.time, curve.values, color=curve.color, label=curve.label, **look)
        if curve.band is not None:
            firsts, low, high = coarse(*curve.band)
            time = subject.time[firsts]
            panel.fill_between(time, low, high, color=curve.color, alpha=0.2, linewidth=0)
    panel.set_ylabel(row.label)
    if not curves:
        panel.text(0.5, 0.5, "none in this flight", ha="center", transform=panel.transAxes)
    elif row.scale == "log":
        panel.set_yscale("log")
        show_decades(panel)
    else:
        widen(panel, row.span)
    if any(curve.style == STEPS for curve in curves):
        panel.yaxis.set_major_locator(MaxNLocator(integer=True))
    panel.set_title(row.note(subject), loc="right", fontsize="small", pad=3)
    for time, text in row.marks(subject):
        mark(panel, subject, time, text)
    for begin, end in subject.touching:
        panel.axvspan(begin, end, zorder=0, **TOUCHING)
    legend_above(panel, [c for c in curves if c.label] or keys, letters)


def coarse(low: Array, high: Array) -> tuple[Array, Array, Array]:
    """Rows, and least and greatest values from each to the next: few enough for a paper's file."""
    firsts = np.unique(np.linspace(0, len(low) - 1, min(len(low), MOST_ROWS)).astype(int))
    return firsts, np.minimum.reduceat(low, firsts), np.maximum.reduceat(high, firsts)


def widen(panel: Axes, span: float) -> None:
    """Shows at least `span`."""
    low, high = panel.get_ylim()
    if high - low < span:
        middle = 0.5 * (low + high)
        panel.set_ylim(middle - 0.5 * span, middle + 0.5 * span)


def show_decades(panel: Axes) -> None:
    """Shows whole decades if there are few: numbers are at powers of ten alone."""
    low, high = (math.log10(limit) for limit in panel.get_ylim())
    if high - low < FEW_DECADES:
        low, high = math.floor(low), math.ceil(high)
        panel.set_ylim(10.0**low, 10.0**high)
    panel.yaxis.set_minor_formatter(NullFormatter())


def mark(panel: Axes, subject: Subject, time: float, text: str) -> None:
    """A line at a time, with a text at the top."""
    late = time > 0.5 * float(subject.time[-1])
    panel.axvline(time, color=GREY, linewidth=0.8, linestyle=":")
    panel.annotate(
        text,
        (time, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(-3 if late else 3, -2),
        textcoords="offset points",
        ha="right" if late else "left",
        va="top",
        fontsize="small",
    )


def legend_above(panel: Axes, curves: Sequence[Curve], letters: int) -> None:
    """A legend above the panel, outside the data, in as few rows as fit."""
    handles: list[Artist] = [
        Line2D([], [], color=c.color, label=c.label, **LINES.get(c.style, {})) for c in curves
    ]
    if not handles:
        return
    longest = max(len(curve.label) for curve in curves)
    rows = math.ceil(len(handles) / max(1, letters // (longest + 4)))
    panel.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=math.ceil(len(handles) / rows),
        borderaxespad=0.2,
        columnspacing=1.0,
        handlelength=1.4,
        handletextpad=0.5,
        labelspacing=0.2,
        fontsize="small",
    )


def share_time(panels: list[Axes], subject: Subject) -> None:
    """The time axis of panels one below another: numbers only below the last one."""
    for panel in panels:
        panel.set_xlim(0.0, max(float(subject.time[-1]), 1e-3))
        panel.tick_params(labelbottom=panel is panels[-1])
    panels[-1].set_xlabel("time [s]")
