"""Figures of a flight: the whole page, chosen panels, and single panels for a paper."""

from __future__ import annotations

from dataclasses import replace

import matplotlib.pyplot as plt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .panels import LINES, TOUCHING, draw_row, share_time
from .rows import EVERY, GOAL, ROWS, Curve, Row, chosen
from .still import draw_still
from .subject import Subject

PATH = "path"  # the panel in space
PANELS = (PATH, *ROWS)
FIRST_ROWS = 4  # on the page, beside the path
HEADING_WIDTH = 165  # characters of the legend below the title
COLUMN = 88.0 / 25.4  # width of a paper's column [inches]
PAPER = {  # in points, if nothing else is said
    "font.size": 8,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.fontsize": 8,
}
MOST_KEYS = 6  # in a legend
STILL_DPI = {"page": 200, "paper": 450}


def names_on_page(subject: Subject) -> list[str]:
    """The page's rows over time, in their order."""
    names = chosen(subject)
    every = [name for name in EVERY if ROWS[name].curves(subject)]
    return [*names[:FIRST_ROWS], *every, *names[FIRST_ROWS:]][: FIRST_ROWS + 8]


def draw_page(subject: Subject) -> Figure:
    """The path in space; beside it the rows that matter for the task; below them the rest."""
    figure = plt.figure(figsize=(16, 10))
    draw_heading(figure, subject)
    grid = figure.add_gridspec(
        4, 4, left=0.05, right=0.99, top=0.885, bottom=0.05, hspace=0.3, wspace=0.27
    )
    still = figure.add_subplot(grid[:2, :2])
    draw_still(still, subject, pixels_of(figure, still, STILL_DPI["page"]))
    names = names_on_page(subject)
    columns: list[list[tuple[int, str]]] = [[], [], [], []]
    for k, name in enumerate(names[:FIRST_ROWS]):
        columns[2 + k // 2].append((k % 2, name))
    for k, name in enumerate(names[FIRST_ROWS:]):
        columns[k % 4].append((2 + k // 4, name))
    for column, cells in enumerate(columns):
        panels = [figure.add_subplot(grid[row, column]) for row, _ in cells]
        for panel, (_, name) in zip(panels, cells, strict=True):
            draw_row(panel, subject, ROWS[name], letters=54)
        if panels:
            share_time(panels, subject)
    return figure


def draw_chosen(subject: Subject, names: list[str]) -> Figure:
    """Some panels, one below another: those over time share its axis."""
    heights = [2.5 if name == PATH else 1.0 for name in names]
    height = 1.1 + 2.0 * sum(heights)  # [in]
    figure = plt.figure(figsize=(7.5, height))
    figure.suptitle(subject.title, x=0.02, y=1.0 - 0.1 / height, ha="left", va="top", weight="bold")
    grid = figure.add_gridspec(
        len(names), 1, hspace=0.25, height_ratios=heights,
        left=0.13, right=0.97, top=1.0 - 0.55 / height, bottom=0.5 / height,
    )  # fmt: skip
    times = []
    for row, name in enumerate(names):
        panel = figure.add_subplot(grid[row])
        if name == PATH:
            draw_still(panel, subject, pixels_of(figure, panel, STILL_DPI["page"]))
            continue
        draw_row(panel, subject, ROWS[name], letters=120)
        times.append(panel)
    if times:
        share_time(times, subject)
    return figure


def draw_for_paper(subject: Subject, name: str) -> Figure:
    """One panel as wide as a paper's column, without a title."""
    with plt.style.context(PAPER):
        if name == PATH:
            figure = plt.figure(figsize=(COLUMN, 0.7 * COLUMN))
            panel = figure.add_axes((0.0, 0.0, 1.0, 1.0))
            draw_still(panel, subject, pixels_of(figure, panel, STILL_DPI["paper"]))
            return figure
        figure = plt.figure(figsize=(COLUMN, 0.52 * COLUMN), layout="constrained")
        panel = figure.add_subplot()
        draw_row(panel, subject, ROWS[name], letters=52, keys=keys_of(subject, ROWS[name]))
        share_time([panel], subject)
        return figure


def keys_of(subject: Subject, row: Row) -> list[Curve]:
    """The legend of a panel that stands alone: its bodies, if it has several, and their goals."""
    curves = row.curves(subject)
    used = {curve.color for curve in curves if curve.style != GOAL}
    named = [track for track in subject.tracks if track.color in used]
    if not 1 < len(named) <= MOST_KEYS:
        named = []
    robots = [name.split(".")[0] for name in (track.name for track in named)]
    keys = [
        Curve(track.position[:, 0], track.color, robot if robots.count(robot) == 1 else track.name)
        for track, robot in zip(named, robots, strict=True)
    ]
    goals = [curve for curve in curves if curve.style == GOAL][:1]
    return keys + [replace(curve, label="goal") for curve in goals]


def pixels_of(figure: Figure, panel: Axes, dpi: int) -> tuple[int, int]:
    """Width and height of a picture that fills a panel."""
    place = panel.get_position()
    width, height = figure.get_size_inches() * dpi
    return round(place.width * width), round(place.height * height)


def draw_heading(figure: Figure, subject: Subject) -> None:
    """Title, facts, and the colours of robots."""
    figure.suptitle(subject.title, x=0.015, y=0.985, ha="left", fontsize=14, weight="bold")
    figure.text(0.015, 0.94, subject.subtitle, color="dimgrey", fontsize=9.5)
    handles = robot_handles(subject, HEADING_WIDTH - (30 if subject.touching else 10))
    if any(track.goal is not None for track in subject.tracks):
        handles.append(Line2D([], [], color="black", label="goal", **LINES[GOAL]))
    if subject.touching:
        handles.insert(0, Patch(label="something touches", **TOUCHING))
    figure.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(0.008, 0.936),
        ncols=len(handles),
        fontsize=9.5,
    )


def robot_handles(subject: Subject, width: int) -> list[Artist]:
    """One handle per robot; if they do not fit, the first ones and the last."""
    tracks = subject.tracks
    handles: list[Artist] = [
        Line2D([], [], color=t.color, linewidth=2.5, label=t.name) for t in tracks
    ]
    most = max(2, width // (max((len(t.name) for t in tracks), default=0) + 8))
    if len(handles) <= most:
        return handles
    dots = Line2D([], [], linestyle="none", label=f"... {len(handles)} in all ...")
    return [*handles[: most - 2], dots, handles[-1]]
