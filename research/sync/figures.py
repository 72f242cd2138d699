"""The paper's figures 4 and 5, made anew."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from research.common.plots import panels, save
from research.sync.summary import EVERY, label, rows_of
from research.sync.work import LOOPS, WRENCHES

COLORS = {"in process": "C2", "lockstep": "C0", "free-running": "C3"}
Rows = Sequence[dict[str, Any]]


def draw_timing(path: Path, rows: Rows) -> None:
    """Figure 4: latency of actions, delay of observations, physics steps between."""
    figure, axes = panels(1, 3, (12.0, 0.4 * len(rows) + 1.6), sharey=True)
    for axis, (key, title) in zip(
        axes[0],
        (
            ("latency_ms", "(a) action to its first physics step [ms]"),
            ("delay_ms", "(b) physics step to its odometry [ms]"),
            ("intervening", "(c) physics steps between"),
        ),
        strict=True,
    ):
        boxes(axis, rows, key)
        axis.set_xlabel(title)
    for axis in axes[0, :2]:
        axis.set_xscale("log")
        axis.xaxis.set_major_formatter("{x:g}")
    axes[0, 2].set_xscale("symlog", linthresh=1.0)
    axes[0, 2].set_xlim(left=-0.2)
    axes[0, 2].xaxis.set_major_formatter("{x:g}")
    save(figure, path)


def draw_spread(path: Path, rows: Rows) -> None:
    """Figure 5: spread of positions, and errors against the flight in process."""
    count = len(rows) // len(LOOPS)
    size = (12.0, 0.8 * count + 3.0)
    figure, axes = panels(2, 2, size, width_ratios=(1.0, 1.0))
    for (left, right), loop in zip(axes, LOOPS, strict=True):
        found = rows_of(rows, loop)
        lines(left, found)
        left.set_title(f"{loop} loop", loc="left", fontsize=10)
        boxes(right, found, "error_mm")
        right.set_xscale("symlog", linthresh=0.01)
        right.set_xlim(left=-0.002)
        right.xaxis.set_major_formatter("{x:g}")
        right.set_xlabel("(b) RMSE of a trial against the flight in process [mm]")
    axes[0, 0].legend(fontsize=8)
    save(figure, path)


def lines(axis: Any, rows: Rows) -> None:
    """Spread over the index of the action; ways with none share a line."""
    styles = itertools.cycle(("-", "--", "-.", ":"))
    for row in rows:
        if row["stepping"] == "free-running":
            where = np.arange(0, WRENCHES, EVERY)
            axis.plot(where, row["spread_mm"], label=label(row), color="C3", linestyle=next(styles))
    axis.plot([0, WRENCHES], [0.0, 0.0], color="C0", label="in process, and lockstep of each: 0")
    axis.set_xlabel("(a) action")
    axis.set_ylabel("spread of the position [mm]")


def boxes(axis: Any, rows: Rows, key: str) -> None:
    """A box of quartiles for each row, with whiskers from 1 % to 99 %, and extremes as points."""
    names = ("least", "whislo", "q1", "med", "q3", "whishi", "most")
    for place, row in enumerate(rows):
        found = dict(zip(names, row[key], strict=True))
        color = COLORS[row["stepping"]]
        style = {"color": color, "linewidth": 1.5}
        extremes = {"fliers": [found.pop("least"), found.pop("most")]}
        axis.bxp(
            [found | extremes],
            positions=[-place],
            orientation="horizontal",
            widths=0.6,
            boxprops=style,
            medianprops=style,
            whiskerprops={"color": color},
            capprops={"color": color},
            flierprops={"marker": ".", "markeredgecolor": color, "markersize": 4},
            manage_ticks=False,
        )
    axis.set_yticks([-place for place in range(len(rows))], [label(row) for row in rows])
    axis.set_ylim(0.4 - len(rows), 0.6)
