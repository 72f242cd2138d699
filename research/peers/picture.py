"""Bars of a run of the peers: steps per second per core, on a logarithmic axis, by task."""

from __future__ import annotations

import pathlib

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from research.peers import results
from research.peers.report import Report
from research.peers.results import Row

# Task, robots, several steps per call, title.
PANELS = (
    ("hover", 1, False, "hover: one quadrotor, one physics step a call"),
    ("hover", 1, True, "hover, several physics steps a call"),
    ("payload", 1, False, "quadrotor, rod and bob, one physics step a call"),
    ("robots", 20, False, "20 quadrotors in a world"),
    ("engine", 1, False, "environment steps of an engine, N = 1024"),
)
OURS, PEER, LIMIT = "#0b6e4f", "#b9c4cf", "#e3ded1"


def best_rows(rows: list[Row], task: str, robots: int, several: bool) -> list[Row]:
    """The fastest row per core of each contestant, the fastest last (at the top)."""
    best: dict[str, Row] = {}
    for row in rows:
        if (row.task, row.robots, row.substeps > 1) != (task, robots, several):
            continue
        if task == "engine" and row.envs != 1024:
            continue
        if row.contestant not in best or row.per_core > best[row.contestant].per_core:
            best[row.contestant] = row
    return sorted(best.values(), key=lambda row: row.per_core)


def number(value: float) -> str:
    return f"{value / 1e6:.3g} M" if value >= 1e6 else f"{value / 1e3:.3g} k"


def panel(axes: Axes, rows: list[Row], title: str) -> None:
    colours = {results.OURS: OURS, results.LIMIT: LIMIT}
    rates = [row.per_core for row in rows]
    axes.barh(range(len(rows)), rates, color=[colours.get(row.peer, PEER) for row in rows])
    axes.set_xscale("log")
    axes.set_xlim(min(rates) / 3.0, max(rates) * 12.0)
    axes.set_yticks(range(len(rows)), [row.contestant for row in rows], fontsize=9)
    for label, row in zip(axes.get_yticklabels(), rows, strict=True):
        label.set_fontweight("bold" if row.peer == results.OURS else "normal")
    for place, row in enumerate(rows):
        steps = f", K={row.substeps}" if row.substeps > 1 else ""
        text = f" {number(row.per_core)}  (N={row.envs}{steps})"
        axes.text(row.per_core, place, text, va="center", fontsize=8)
    axes.set_title(title, loc="left", fontsize=11)
    axes.spines[["top", "right"]].set_visible(False)


def draw(report: Report, path: pathlib.Path) -> None:
    """Writes the picture."""
    panels = [
        (best_rows(report.rows, task, robots, several), title)
        for task, robots, several, title in PANELS
    ]
    panels = [(rows, title) for rows, title in panels if rows]
    heights = [1.5 + len(rows) for rows, _ in panels]
    figure, axes = plt.subplots(
        len(panels),
        1,
        figsize=(9.0, 0.3 * sum(heights) + 0.8),
        height_ratios=heights,
        layout="constrained",
        squeeze=False,
    )
    for axis, (rows, title) in zip(axes[:, 0], panels, strict=True):
        panel(axis, rows, title)
    axes[-1, 0].set_xlabel("steps a second by core (logarithmic), each at its best N")
    figure.suptitle(f"Skybody and its peers on the same work\n{report.head()}", fontsize=9)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=130)
    plt.close(figure)
