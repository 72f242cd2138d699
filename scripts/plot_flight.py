#!/usr/bin/env python3
"""Draws the flights of a Skybody log: one picture per episode.

    skybody plot flights/hover-0/flight.h5 [--pdf] [--panels z,yaw,path] [--out DIR] [--most 3]

Positions with their goals, attitude, rotor speeds with their commands, joints, reward, and the
path in space with the vehicle at some instants and the obstacles. Times of contact with the
ground, an obstacle or another robot are shaded. Writes flight-0001.png, flight-0002.png,
... beside the log (with --pdf flight-0001.pdf, ...) and prints a line `picture PATH` for each.
--panels draws only some of the panels, one below another.
Needs matplotlib, numpy and h5py.
"""

from __future__ import annotations

import argparse
import functools
import math
import os
import secrets
import sys
from pathlib import Path
from typing import NoReturn

try:
    import h5py
    import matplotlib
    import numpy as np
except ImportError as error:
    sys.exit(f"{sys.executable} has no {error.name}; pip install matplotlib h5py")

sys.path.insert(0, str(Path(__file__).resolve().parent))  # which python -P omits
matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from plot_flight_data import Flight, colors, read_flight, refusal
from plot_flight_scene import TOUCHING, draw_path

DPI = 150
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
}
GOAL = {"color": "black", "linestyle": (0, (4, 3)), "linewidth": 0.9}
LEGEND_WIDTH = 72  # characters that fit above a panel, each line and its gap counted as 7
HEADING_WIDTH = 165  # characters of the legend below the title
MOST_NAMED = 15  # joints with individual names; of more only the lines are drawn
LEAST_ERROR = 1e-3  # mm; smaller errors are drawn as this
COMMAND = {"linestyle": (0, (1, 1.5)), "linewidth": 1.0, "alpha": 0.8}


# --- drawing ----------------------------------------------------------------------------------


def widen(axes, span: float) -> None:
    """Shows at least `span`, so that rounding noise does not fill the panel."""
    low, high = axes.get_ylim()
    if high - low < span:
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.5 * span, middle + 0.5 * span)


def draw_position(panel, flight: Flight, axis: int) -> None:
    for track in flight.tracks:
        panel.plot(flight.time, track.position[:, axis], color=track.color)
        if track.goal is not None:
            panel.plot(flight.time, track.goal[:, axis], **GOAL)
    panel.set_ylabel(f"{'xyz'[axis]} [m]")
    widen(panel, 0.02)


def draw_errors(panel, flight: Flight) -> None:
    for track in flight.tracks:
        if track.goal is not None:
            panel.plot(flight.time, np.maximum(track.error(), LEAST_ERROR), color=track.color)
    panel.set_yscale("log")
    low, high = panel.get_ylim()
    if high < 10.0 * low:  # at least a decade: its ticks are round numbers
        middle = np.sqrt(low * high)
        panel.set_ylim(middle / np.sqrt(10.0), middle * np.sqrt(10.0))
    panel.set_ylabel("to goal [mm]")


def draw_angle(panel, flight: Flight, axis: int) -> None:
    for track in flight.tracks:
        if track.angles is None:
            continue
        panel.plot(flight.time, track.angles[:, axis], color=track.color)
        if axis == 2 and track.goal is not None:
            panel.plot(flight.time, track.goal_yaw(), **GOAL)
    panel.set_ylabel(f"{('roll', 'pitch', 'yaw')[axis]} [deg]")
    widen(panel, 2.0)


def draw_reward(panel, flight: Flight) -> None:
    panel.plot(flight.time[1:], flight.reward[1:], color="tab:purple")
    panel.set_ylabel("reward a step")
    panel.set_title(f"return {flight.reward.sum():.6g}", loc="right", fontsize=9)
    widen(panel, 1e-3)


def draw_effort(panel, flight: Flight) -> None:
    """The rotors' cubed speeds, proportional to power, over their mean in the episode."""
    effort = np.mean(np.abs(flight.rotor_speed) ** 3, axis=1)
    panel.plot(flight.time, effort / max(float(effort.mean()), 1e-12), color="tab:purple")
    panel.set_ylabel("effort / its mean")
    widen(panel, 0.05)


def draw_each_rotor(panel, flight: Flight) -> None:
    for k, (name, color) in enumerate(zip(flight.rotors, colors(len(flight.rotors)), strict=True)):
        label = name.split(".", 1)[-1]
        panel.plot(flight.time, flight.rotor_speed[:, k], color=color, label=label)
        panel.plot(flight.time[1:], flight.rotor_command[1:, k], color=color, **COMMAND)
    panel.plot([], [], color="grey", label="command", **COMMAND)
    above(panel)


def draw_rotors_by_robot(panel, flight: Flight) -> None:
    robots = [name.split(".")[0] for name in flight.rotors]
    color_of = {t.name.split(".")[0]: t.color for t in reversed(flight.tracks)}
    for robot in dict.fromkeys(robots):
        columns = [k for k, name in enumerate(robots) if name == robot]
        speed, command = flight.rotor_speed[:, columns], flight.rotor_command[1:, columns]
        color = color_of[robot]
        panel.fill_between(
            flight.time, speed.min(axis=1), speed.max(axis=1), color=color, alpha=0.2, linewidth=0
        )
        panel.plot(flight.time, speed.mean(axis=1), color=color)
        panel.plot(flight.time[1:], command.mean(axis=1), color=color, **COMMAND)
    panel.plot([], [], color="grey", label="mean of rotors")
    panel.fill_between([], [], [], color="grey", alpha=0.2, label="least to greatest")
    panel.plot([], [], color="grey", label="command", **COMMAND)
    above(panel)


def draw_rotors(panel, flight: Flight) -> None:
    panel.set_ylabel("rotor speed [rad/s]")
    if not flight.rotors:
        panel.text(0.5, 0.5, "no rotors", ha="center", transform=panel.transAxes)
        return
    one = len({name.split(".")[0] for name in flight.rotors}) == 1
    (draw_each_rotor if one else draw_rotors_by_robot)(panel, flight)
    widen(panel, max(1.0, 0.02 * float(np.nanmax(np.abs(flight.rotor_speed)))))


def second_scale(panel):
    """Axes on the right of a panel, which leaves room for their numbers."""
    place = panel.get_position()
    panel.set_position([place.x0, place.y0, 0.82 * place.width, place.height])
    axes = panel.twinx()
    axes.spines["right"].set_visible(True)
    axes.grid(False)
    return axes


def draw_joints(panel, flight: Flight) -> None:
    """Angles in degrees; with sliders also their travel, by a scale on the right."""
    if not flight.joints:
        panel.text(0.5, 0.5, "no joints", ha="center", transform=panel.transAxes)
        return
    shown = sum(len(joints.names) for joints in flight.joints)
    palette = iter(colors(shown))
    handles = []
    for k, joints in enumerate(flight.joints):
        axes = panel if k == 0 else second_scale(panel)
        axes.set_ylabel(f"joints [{joints.unit}]")
        style = "-" if k == 0 else (0, (5, 2))
        for column, name in enumerate(joints.names):
            label = name.split(".", 1)[-1]
            values = joints.values[:, column]
            handles += axes.plot(
                flight.time, values, linestyle=style, color=next(palette), label=label
            )
        widen(axes, 0.2 if joints.unit == "deg" else 0.002)
    if shown <= MOST_NAMED:
        above(panel, handles)


def shade_touching(panel, flight: Flight) -> None:
    for begin, end in flight.touching:
        panel.axvspan(begin, end, zorder=0, **TOUCHING)


def above(panel, handles: list | None = None) -> None:
    """A legend above the panel, outside the data: in as few rows as fit, all of similar length."""
    handles = handles or panel.get_legend_handles_labels()[0]
    longest = max(len(handle.get_label()) for handle in handles)
    rows = math.ceil(len(handles) / max(1, LEGEND_WIDTH // (longest + 7)))
    panel.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncol=math.ceil(len(handles) / rows),
        borderaxespad=0.2,
        columnspacing=1.2,
        handlelength=1.8,
        fontsize=8,
    )


def robot_handles(flight: Flight, width: int) -> list:
    """One handle per robot; if they do not fit, the first ones and the last."""
    handles = [Line2D([], [], color=t.color, linewidth=2.5, label=t.name) for t in flight.tracks]
    most = max(2, width // (max((len(t.name) for t in flight.tracks), default=0) + 8))
    if len(handles) <= most:
        return handles
    dots = Line2D([], [], linestyle="none", label=f"... {len(handles)} in all ...")
    return [*handles[: most - 2], dots, handles[-1]]


def draw_heading(figure, flight: Flight) -> None:
    figure.suptitle(flight.title, x=0.02, y=0.985, ha="left", fontsize=14, weight="bold")
    figure.text(0.02, 0.938, flight.subtitle, color="dimgrey", fontsize=9.5)
    handles = robot_handles(flight, HEADING_WIDTH - (30 if flight.touching else 10))
    handles.append(Line2D([], [], label="goal", **GOAL))
    if flight.touching:
        handles.insert(0, Patch(label="something touches", **TOUCHING))
    figure.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(0.013, 0.934),
        ncol=len(handles),
        fontsize=9.5,
    )


def draw(flight: Flight):
    """The whole picture: positions, attitude, and in the last column path and rotors."""
    figure = plt.figure(figsize=(15, 10))
    draw_heading(figure, flight)
    grid = figure.add_gridspec(
        4, 3, left=0.065, right=0.985, top=0.875, bottom=0.055, hspace=0.18, wspace=0.2
    )
    first = figure.add_subplot(grid[0, 0])
    panels = [[first, *(figure.add_subplot(grid[k, 0], sharex=first) for k in (1, 2, 3))]]
    panels.append([figure.add_subplot(grid[k, 1], sharex=first) for k in range(4)])
    heights = (1.3, 0.75, 0.75) if flight.joints else (1.15, 1.0)
    side = grid[:, 2].subgridspec(len(heights), 1, hspace=0.32, height_ratios=heights)
    times = [figure.add_subplot(side[k], sharex=first) for k in range(1, len(heights))]
    for axis in range(3):
        draw_position(panels[0][axis], flight, axis)
        draw_angle(panels[1][axis], flight, axis)
    draw_errors(panels[0][3], flight)
    follows = any(track.follows() for track in flight.tracks)
    judged = np.any(flight.reward[1:] != 0.0) or not flight.rotors
    (draw_effort if follows and not judged else draw_reward)(panels[1][3], flight)
    draw_path(figure.add_subplot(side[0], projection="3d"), flight)
    draw_rotors(times[0], flight)
    if flight.joints:
        draw_joints(times[1], flight)
    for panel in (*panels[0], *panels[1], *times):
        shade_touching(panel, flight)
    for column in panels:
        for panel in column[:3]:
            panel.tick_params(labelbottom=False)
        column[3].set_xlabel("time [s]")
    times[-1].set_xlabel("time [s]")
    first.set_xlim(0.0, max(float(flight.time[-1]), 1e-3))
    return figure


# Panels by name, each drawn by f(panel, flight). `path` is in space.
PANELS = {
    "x": functools.partial(draw_position, axis=0),
    "y": functools.partial(draw_position, axis=1),
    "z": functools.partial(draw_position, axis=2),
    "error": draw_errors,
    "roll": functools.partial(draw_angle, axis=0),
    "pitch": functools.partial(draw_angle, axis=1),
    "yaw": functools.partial(draw_angle, axis=2),
    "reward": draw_reward,
    "effort": draw_effort,
    "rotors": draw_rotors,
    "joints": draw_joints,
    "path": draw_path,
}


def draw_chosen(flight: Flight, names: list[str]):
    """Some panels, one below another: those over time share its axis."""
    heights = [2.5 if name == "path" else 1.0 for name in names]
    height = 1.1 + 2.0 * sum(heights)  # [in]
    figure = plt.figure(figsize=(7.5, height))
    figure.suptitle(flight.title, x=0.02, y=1.0 - 0.1 / height, ha="left", va="top", weight="bold")
    margins = {"left": 0.13, "right": 0.97, "top": 1.0 - 0.55 / height, "bottom": 0.5 / height}
    grid = figure.add_gridspec(len(names), 1, hspace=0.25, height_ratios=heights, **margins)
    times: list = []
    for row, name in enumerate(names):
        if name == "path":
            PANELS[name](figure.add_subplot(grid[row], projection="3d"), flight)
            continue
        panel = figure.add_subplot(grid[row], sharex=times[0] if times else None)
        PANELS[name](panel, flight)
        shade_touching(panel, flight)
        panel.tick_params(labelbottom=False)
        times.append(panel)
    if times:
        times[-1].tick_params(labelbottom=True)
        times[-1].set_xlabel("time [s]")
        times[0].set_xlim(0.0, max(float(flight.time[-1]), 1e-3))
    return figure


# --- program ----------------------------------------------------------------------------------


def save(figure, path: Path) -> None:
    """Writes atomically: no half-written picture is ever visible."""
    partial = path.with_name(f".{path.name}.{secrets.token_hex(8)}")
    try:
        with partial.open("xb") as file:
            figure.savefig(file, dpi=DPI, format=path.suffix[1:])
        os.replace(partial, path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        sys.exit(f"{path}: {error.strerror}")
    plt.close(figure)


LOG = "flight.h5"
REMEDY = f"draw a {LOG}, which `skybody run` writes"


def panel_names(text: str) -> list[str]:
    """Parses --panels."""
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in PANELS:
            raise argparse.ArgumentTypeError(f"no panel `{name}`; allowed: {', '.join(PANELS)}")
    return names


def at_least_one(text: str) -> int:
    """Parses --most."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"`{text}` is not a whole number; allowed: 1 or more")
    return int(text)


class CommandLine(argparse.ArgumentParser):
    """Errors in the form of `skybody run`; the package skybody may be missing here."""

    def error(self, message: str) -> NoReturn:
        missing = "the following arguments are required: "
        if message.startswith(missing):
            message = f"{message.removeprefix(missing)} is missing; see `{self.prog} --help`"
        print(f"error: {message.removeprefix('argument ')}", file=sys.stderr)
        sys.exit(2)


def obstacle(log: Path, error: OSError) -> str:
    """The reason why a file cannot be opened, and the remedy."""
    if log.is_dir():
        return f"a folder; give its {LOG}" if (log / LOG).is_file() else f"a folder; {REMEDY}"
    reason = os.strerror(error.errno) if error.errno else "no HDF5 file"
    return f"{reason}; {REMEDY}"


def main() -> int:
    parser = CommandLine(
        prog="skybody plot",
        description="draw the flights of a Skybody log, one picture per episode",
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG)
    parser.add_argument("--pdf", action="store_true", help="PDF instead of PNG")
    parser.add_argument(
        "--panels",
        type=panel_names,
        metavar="A,B,...",
        help=f"only these panels, one below another: {', '.join(PANELS)}",
    )
    parser.add_argument("--out", type=Path, help="folder of the pictures (default: the log's)")
    parser.add_argument(
        "--most", type=at_least_one, default=3, help="draw the first N episodes (default 3)"
    )
    options = parser.parse_args()
    folder = options.out or options.log.parent
    try:
        log = h5py.File(options.log, "r")
    except OSError as error:
        parser.error(f"{options.log}: {obstacle(options.log, error)}")
    # "default": independent of a matplotlibrc in the working folder.
    with log, plt.style.context(("default", STYLE)):
        if reason := refusal(log):
            parser.error(f"{options.log}: {reason}")
        folder.mkdir(parents=True, exist_ok=True)
        for name in list(log["episodes"])[: options.most]:
            path = folder / f"flight-{name}.{'pdf' if options.pdf else 'png'}"
            flight = read_flight(log, name)
            save(draw_chosen(flight, options.panels) if options.panels else draw(flight), path)
            print(f"picture {path}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
