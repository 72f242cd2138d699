#!/usr/bin/env python3
"""Draws the flights of a Skybody log: one PNG an episode.

    plot_flight.py flights/hover-0/flight.h5 [--out DIR] [--most 3]

Positions against their goals, attitude, rotor speeds with their commands, reward, and the path in
space. Where tree dynamics and Simbody took turns, what Simbody took is shaded. Writes
flight-0001.png, flight-0002.png, ... beside the log and prints a line `picture PATH` for each.
Needs matplotlib, numpy and h5py.
"""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import dataclass
from pathlib import Path

try:
    import h5py
    import matplotlib
    import numpy as np
except ImportError as error:
    sys.exit(f"{sys.executable} has no {error.name}; pip install matplotlib h5py")

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

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
SIMBODY = {"color": "gold", "alpha": 0.4, "linewidth": 0}
COMMAND = {"linestyle": (0, (1, 1.5)), "linewidth": 1.0, "alpha": 0.8}
ENDINGS = ("terminated", "truncated", "fault", "stopped", "interrupted")


@dataclass
class Track:
    """What is drawn of one body."""

    name: str
    color: str
    position: np.ndarray
    angles: np.ndarray | None  # roll, pitch, yaw in degrees; only of a robot's base
    goal: np.ndarray | None  # x, y, z [m], yaw [rad]

    def error(self) -> np.ndarray:
        """Distance to the goal in mm."""
        return 1e3 * np.linalg.norm(self.position - self.goal[:, :3], axis=1)


@dataclass
class Flight:
    """One episode, read."""

    title: str
    subtitle: str
    time: np.ndarray
    reward: np.ndarray
    tracks: list[Track]
    rotors: list[str]
    rotor_speed: np.ndarray | None
    rotor_command: np.ndarray | None
    simbody: list[tuple[float, float]]  # spans of time on Simbody, where tree took others


# --- reading ----------------------------------------------------------------------------------


def euler_degrees(quaternion: np.ndarray) -> np.ndarray:
    """Roll, pitch and yaw (z-y'-x'') of rows w x y z, without jumps."""
    w, x, y, z = quaternion.T
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1, 1))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.degrees(np.stack([np.unwrap(roll), pitch, np.unwrap(yaw)], axis=1))


def texts(values) -> list[str]:
    return [v.decode() if isinstance(v, bytes) else str(v) for v in values]


def colors(count: int) -> list:
    """As many colours that can be told apart as the cycle has, then a continuous map."""
    cycle = plt.rcParams["axes.prop_cycle"].by_key()["color"]
    if count <= len(cycle):
        return cycle[:count]
    return list(plt.get_cmap("turbo")(np.linspace(0.05, 0.95, count)))


def read_tracks(episode: h5py.Group) -> list[Track]:
    """The base of each robot and each body that has a goal."""
    names = texts(episode["bodies"].attrs["items"])
    goals = texts(episode["goal"].attrs["items"]) if "goal" in episode else []
    bases, robots = set(), set()
    for name in names:
        robot = name.split(".")[0]
        if robot not in robots:
            bases.add(name)
            robots.add(robot)
    shown = [name for name in names if name in bases or name in goals]
    tracks = []
    for name, color in zip(shown, colors(len(shown)), strict=True):
        body = episode["bodies"][:, names.index(name), :]
        angles = euler_degrees(body[:, 3:7]) if name in bases else None
        goal = episode["goal"][:, goals.index(name), :] if name in goals else None
        tracks.append(Track(name, color, body[:, :3], angles, goal))
    return tracks


def ending(episode: h5py.Group) -> str:
    events = [e["text"].decode() for e in episode["events"][:]]
    last = events[-1] if events else ""
    return last if last.split(":")[0] in ENDINGS else "unfinished"


def simbody_spans(dynamics: np.ndarray, time: np.ndarray) -> list[tuple[float, float]]:
    """From the row before the first on Simbody to the last; none where nothing was handed over."""
    on_simbody = dynamics[1:] == 1
    if on_simbody.all():
        return []
    edges = np.flatnonzero(np.diff(np.concatenate([[False], on_simbody, [False]]).astype(int)))
    return [(time[a], time[b]) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def read_flight(log: h5py.File, name: str) -> Flight:
    episode = log["episodes"][name]
    time = episode["time"][:]
    about = log.attrs
    title = f"{about['scenario']}  ·  episode {int(name)} of {len(log['episodes'])}"
    title += f"  ·  policy {about['policy']}  ·  seed {about['seed']}"
    subtitle = f"{ending(episode)} after {time[-1]:.3f} s, {len(time) - 1} steps of "
    subtitle += f"{about['action_repeat']} x {1e3 * about['dt']:g} ms"
    subtitle += f"  ·  scenario {about['scenario_hash']}"
    subtitle += f"  ·  Skybody {log['versions'].attrs.get('skybody', '?')}"
    rotors = texts(episode["rotor_speed"].attrs["columns"]) if "rotor_speed" in episode else []
    return Flight(
        title=title,
        subtitle=subtitle,
        time=time,
        reward=episode["reward"][:],
        tracks=read_tracks(episode),
        rotors=rotors,
        rotor_speed=episode["rotor_speed"][:] if rotors else None,
        rotor_command=episode["rotor_command"][:] if rotors else None,
        simbody=simbody_spans(episode["dynamics"][:], time) if "dynamics" in episode else [],
    )


# --- drawing ----------------------------------------------------------------------------------


def widen(axes, span: float) -> None:
    """Shows at least `span`, so that rounding noise does not fill the panel."""
    low, high = axes.get_ylim()
    if high - low < span:
        middle = 0.5 * (low + high)
        axes.set_ylim(middle - 0.5 * span, middle + 0.5 * span)


def draw_positions(panels, flight: Flight) -> None:
    for axis, panel in enumerate(panels):
        for track in flight.tracks:
            panel.plot(flight.time, track.position[:, axis], color=track.color)
            if track.goal is not None:
                panel.plot(flight.time, track.goal[:, axis], **GOAL)
        panel.set_ylabel(f"{'xyz'[axis]} [m]")
        widen(panel, 0.02)


def draw_errors(panel, flight: Flight) -> None:
    for track in flight.tracks:
        if track.goal is not None:
            panel.plot(flight.time, np.maximum(track.error(), 1e-6), color=track.color)
    panel.set_yscale("log")
    panel.set_ylabel("distance to goal [mm]")


def draw_attitude(panels, flight: Flight) -> None:
    for axis, panel in enumerate(panels):
        for track in flight.tracks:
            if track.angles is None:
                continue
            panel.plot(flight.time, track.angles[:, axis], color=track.color)
            if axis == 2 and track.goal is not None:
                panel.plot(flight.time, np.degrees(track.goal[:, 3]), **GOAL)
        panel.set_ylabel(f"{('roll', 'pitch', 'yaw')[axis]} [deg]")
        widen(panel, 2.0)


def draw_reward(panel, flight: Flight) -> None:
    panel.plot(flight.time[1:], flight.reward[1:], color="tab:purple")
    panel.set_ylabel("reward a step")
    panel.set_title(f"return {flight.reward.sum():.6g}", loc="right", fontsize=9)
    widen(panel, 1e-3)


def draw_each_rotor(panel, flight: Flight) -> None:
    for k, (name, color) in enumerate(zip(flight.rotors, colors(len(flight.rotors)), strict=True)):
        label = name.split(".", 1)[-1]
        panel.plot(flight.time, flight.rotor_speed[:, k], color=color, label=label)
        panel.plot(flight.time[1:], flight.rotor_command[1:, k], color=color, **COMMAND)
    panel.plot([], [], color="grey", label="command", **COMMAND)
    above(panel, 3 if max(map(len, flight.rotors)) > 14 else 5)


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
    above(panel, 3)


def draw_rotors(panel, flight: Flight) -> None:
    panel.set_ylabel("rotor speed [rad/s]")
    if not flight.rotors:
        panel.text(0.5, 0.5, "no rotors", ha="center", transform=panel.transAxes)
        return
    one = len({name.split(".")[0] for name in flight.rotors}) == 1
    (draw_each_rotor if one else draw_rotors_by_robot)(panel, flight)
    widen(panel, max(1.0, 0.02 * float(np.nanmax(np.abs(flight.rotor_speed)))))


def shade_simbody(panel, flight: Flight) -> None:
    for begin, end in flight.simbody:
        panel.axvspan(begin, end, zorder=0, **SIMBODY)


def draw_path(panel, flight: Flight) -> None:
    for track in flight.tracks:
        panel.plot(*track.position.T, color=track.color, linewidth=1.1)
        for begin, end in flight.simbody:
            rows = (flight.time >= begin) & (flight.time <= end)
            panel.plot(*track.position[rows].T, **{**SIMBODY, "linewidth": 5})
        panel.scatter(*track.position[0], color=track.color, marker="o", s=14)
        panel.scatter(*track.position[-1], color=track.color, marker="s", s=18)
        if track.goal is not None:
            panel.scatter(*track.goal[-1, :3], color="black", marker="+", s=60, linewidths=1.2)
    points = [t.position for t in flight.tracks]
    points += [t.goal[:, :3] for t in flight.tracks if t.goal is not None]
    points = np.concatenate(points)
    points = points[np.isfinite(points).all(axis=1)]
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    half = 0.55 * np.maximum(np.ptp(points, axis=0), max(0.05, 0.6 * np.ptp(points, axis=0).max()))
    for axis, limits in enumerate((panel.set_xlim, panel.set_ylim, panel.set_zlim)):
        limits(middle[axis] - half[axis], middle[axis] + half[axis])
    panel.set_box_aspect(half, zoom=0.82)
    panel.locator_params(nbins=4)
    panel.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    panel.tick_params(labelsize=8, pad=0)
    panel.set_title("path: ● start  ■ end  + goal", fontsize=9)


def above(panel, columns: int) -> None:
    """A legend over the panel, where no data is."""
    panel.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncol=columns,
        borderaxespad=0.2,
        columnspacing=1.2,
        handlelength=1.8,
        fontsize=8,
    )


def draw_heading(figure, flight: Flight) -> None:
    figure.suptitle(flight.title, x=0.02, y=0.985, ha="left", fontsize=14, weight="bold")
    figure.text(0.02, 0.938, flight.subtitle, color="dimgrey", fontsize=9.5)
    handles = [Line2D([], [], color=t.color, linewidth=2.5, label=t.name) for t in flight.tracks]
    handles.append(Line2D([], [], label="goal", **GOAL))
    if flight.simbody:
        handles.insert(0, Patch(label="Simbody (within reach)", **SIMBODY))
    figure.legend(
        handles=handles[:12],
        loc="upper left",
        bbox_to_anchor=(0.013, 0.934),
        ncol=min(len(handles), 12),
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
    side = grid[:, 2].subgridspec(2, 1, hspace=0.2, height_ratios=(1.15, 1.0))
    rotors = figure.add_subplot(side[1], sharex=first)
    draw_positions(panels[0][:3], flight)
    draw_errors(panels[0][3], flight)
    draw_attitude(panels[1][:3], flight)
    draw_reward(panels[1][3], flight)
    draw_path(figure.add_subplot(side[0], projection="3d"), flight)
    draw_rotors(rotors, flight)
    for panel in (*panels[0], *panels[1], rotors):
        shade_simbody(panel, flight)
    for column in panels:
        for panel in column[:3]:
            panel.tick_params(labelbottom=False)
        column[3].set_xlabel("time [s]")
    rotors.set_xlabel("time [s]")
    first.set_xlim(0.0, max(float(flight.time[-1]), 1e-3))
    return figure


# --- program ----------------------------------------------------------------------------------


def save(figure, path: Path) -> None:
    """Nobody finds a half-written picture."""
    partial = path.with_name("." + path.name + ".partial")
    try:
        figure.savefig(partial, dpi=DPI, format="png")
        os.replace(partial, path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        sys.exit(f"{path}: {error.strerror}")
    plt.close(figure)


def main() -> int:
    parser = argparse.ArgumentParser(description="draw the flights of a Skybody log")
    parser.add_argument("log", type=Path, help="flight.h5")
    parser.add_argument("--out", type=Path, help="folder of the pictures (default: the log's)")
    parser.add_argument("--most", type=int, default=3, help="draw the first N episodes (default 3)")
    options = parser.parse_args()
    folder = options.out or options.log.parent
    folder.mkdir(parents=True, exist_ok=True)
    with plt.rc_context(STYLE), h5py.File(options.log, "r") as log:
        for name in list(log["episodes"])[: options.most]:
            path = folder / f"flight-{name}.png"
            save(draw(read_flight(log, name)), path)
            print(f"picture {path}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
