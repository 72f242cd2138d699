"""The panels over time: a table of rows, each with the curves that a flight has for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from skybody.look.flight import Array
from skybody.look.palette import colors
from skybody.look.shapes import Color

from .measures import carried, height_over_deck, separation, swing, tilt, touch_down
from .subject import Subject

GOAL, COMMAND, STEPS, LINE = "goal", "command", "steps", "line"  # styles of curves
BLACK: Color = (0.0, 0.0, 0.0)
GREY: Color = (0.35, 0.35, 0.35)
LEAST_ERROR = 1e-4  # [m]; smaller errors are drawn as this
MOST_NAMED = 15  # joints with individual names; of more only the lines are drawn
MOST_APART = 6  # robots whose rotors are drawn apart, and rotors with names


@dataclass(frozen=True)
class Curve:
    """A line over time."""

    values: Array  # (rows,)
    color: Color = BLACK
    label: str = ""  # empty: not in the legend
    style: str = LINE
    band: tuple[Array, Array] | None = None  # least and greatest, drawn as an area


@dataclass(frozen=True)
class Row:
    """A panel over time."""

    label: str  # of its axis, with the unit
    curves: Callable[[Subject], list[Curve]]  # empty: the flight has none
    scale: str = "linear"
    span: float = 0.0  # least that is shown, so that rounding noise does not fill the panel
    marks: Callable[[Subject], list[tuple[float, str]]] = lambda subject: []  # times [s], texts
    note: Callable[[Subject], str] = lambda subject: ""  # above the panel


# --- curves of every flight -----------------------------------------------------------------------


def positions(subject: Subject, axis: int) -> list[Curve]:
    """A coordinate of all tracks and goals."""
    tracks = subject.moving
    found = [Curve(track.position[:, axis], track.color) for track in tracks]
    goals = [track.goal for track in tracks if track.goal is not None]
    return found + [Curve(goal[:, axis], style=GOAL) for goal in goals]


def angles(subject: Subject, axis: int) -> list[Curve]:
    """Roll, pitch or yaw of all robots, and the yaw of their goals."""
    turning = [(track, track.angles) for track in subject.moving if track.angles is not None]
    found = [Curve(turned[:, axis], track.color) for track, turned in turning]
    if axis == 2:
        headed = [track for track, _ in turning if track.goal is not None]
        found += [Curve(whole_turns_cut(track.goal_yaw()), style=GOAL) for track in headed]
    return found


def whole_turns_cut(degrees: Array) -> Array:
    """Without the line between two rows that are half a turn apart or more."""
    cut = degrees.copy()
    cut[1:][np.abs(np.diff(degrees)) >= 180.0] = np.nan
    return cut


def errors(subject: Subject) -> list[Curve]:
    """Distance from the goal."""
    tracks = [track for track in subject.tracks if track.goal is not None]
    return [Curve(np.maximum(track.error(), LEAST_ERROR), track.color) for track in tracks]


def speeds(subject: Subject) -> list[Curve]:
    """Speed of each base."""
    return [
        Curve(np.linalg.norm(subject.base(name)[:, 7:10], axis=1), subject.color(name))
        for name in subject.flown
    ]


def rewards(subject: Subject) -> list[Curve]:
    """Reward of each step; none if all are 0."""
    reward = subject.reward[subject.rows]
    if not np.any(reward[1:]):
        return []
    reward[0] = np.nan
    return [Curve(reward, GREY)]


def total_reward(subject: Subject) -> str:
    """The return."""
    return f"return {subject.reward.sum():.5g}"


def effort(subject: Subject) -> list[Curve]:
    """The rotors' cubed speeds, proportional to power, over their mean in the episode."""
    if not subject.flown:
        return []
    cubed = np.mean(np.abs(subject.rotor_speed) ** 3, axis=1)
    return [Curve(cubed / max(float(cubed.mean()), 1e-12), GREY)]


def rotors(subject: Subject) -> list[Curve]:
    """Speed and command: of one robot for each rotor, of several the mean with least and most."""
    names, speed = subject.flight.rotor_names, subject.rotor_speed
    if not names:
        return []
    command = subject.command
    command[:1] = np.nan
    if len(subject.flown) == 1:
        found = []
        for k, (name, color) in enumerate(zip(names, colors(len(names)), strict=True)):
            label = name.split(".", 1)[-1] if len(names) <= MOST_APART else ""
            found.append(Curve(speed[:, k], color, label))
            if command.size:
                found.append(Curve(command[:, k], color, "command" if k == 0 else "", COMMAND))
        return found
    groups = {robot: [n.split(".")[0] == robot for n in names] for robot in subject.flown}
    if len(groups) > MOST_APART:
        groups = {"": [True] * len(names)}
    found = []
    for robot, chosen in groups.items():
        color = subject.color(robot) if robot else GREY
        part, label = speed[:, chosen], "" if found else "mean, least and greatest"
        band = part.min(axis=1), part.max(axis=1)
        found.append(Curve(part.mean(axis=1), color, label, band=band))
    return found


def joints(subject: Subject, unit: str) -> list[Curve]:
    """Angles or travels of joints."""
    series = subject.joints[unit]
    tints = colors(len(series))
    named = len(series) <= MOST_NAMED
    return [
        Curve(values, tint, name.split(".", 1)[-1] if named else "")
        for (name, values), tint in zip(series, tints, strict=True)
    ]


# --- curves of certain tasks ----------------------------------------------------------------------


def infos(subject: Subject, *names: str, style: str = LINE) -> list[Curve]:
    """Infos by their last names; of several robots in their colours."""
    found: list[Curve] = []
    one = subject.tracks[0].color if len(subject.robots) == 1 else GREY
    tints = colors(len(names)) if len(names) > 1 else [one]
    for name, tint in zip(names, tints, strict=True):
        for prefix, values, _ in subject.infos(name):
            drawn = values.copy()
            drawn[0] = np.nan  # row 0 of infos is 0 by definition
            color = subject.color(prefix) if prefix in subject.robots else tint
            label = name.replace("_", " ") if len(names) > 1 else ""
            found.append(Curve(drawn, color, label, style))
    return found


def distances(subject: Subject, name: str) -> list[Curve]:
    """An info that is the distance of a load or a tool from its target."""
    ends = [track.color for track in subject.tracks if track.angles is None]
    ends += [subject.color(robot) for robot in carried(subject)]
    return [
        Curve(np.maximum(curve.values, LEAST_ERROR), ends[0] if ends else curve.color)
        for curve in infos(subject, name)
    ]


def laps(subject: Subject) -> list[tuple[float, str]]:
    """Times at the end of laps; of one racer alone, else they overlap."""
    found = subject.infos("lap_time")
    if len(found) != 1:
        return []
    _, values, _ = found[0]
    ends = np.flatnonzero(np.diff(values)) + 1
    return [(float(subject.time[row]), f"{values[row]:.2f} s") for row in ends]


def upright(subject: Subject) -> list[Curve]:
    """Angle of a standing pendulum from the vertical."""
    return [
        Curve(np.degrees(np.arccos(np.clip(curve.values, -1.0, 1.0))), curve.color)
        for curve in infos(subject, "upright")
    ]


def apart(subject: Subject) -> list[Curve]:
    """Smallest distance between two robots' bases."""
    values = separation(subject)
    return [] if values is None else [Curve(values, GREY)]


def height(subject: Subject) -> list[Curve]:
    """Height of each robot over a deck."""
    return [Curve(values, subject.color(name)) for name, values in height_over_deck(subject)]


def swings(subject: Subject) -> list[Curve]:
    """Angles of loads that hang from a robot, from straight down."""
    return [Curve(values, track.color) for track, values in swing(subject)]


def tilts(subject: Subject) -> list[Curve]:
    """Tilts of loads that several robots carry."""
    return [Curve(values, subject.color(name)) for name, values in tilt(subject)]


ROWS: dict[str, Row] = {
    "x": Row("x [m]", partial(positions, axis=0), span=0.02),
    "y": Row("y [m]", partial(positions, axis=1), span=0.02),
    "z": Row("z [m]", partial(positions, axis=2), span=0.02),
    "error": Row("distance to goal [m]", errors, scale="log"),
    "roll": Row("roll [deg]", partial(angles, axis=0), span=2.0),
    "pitch": Row("pitch [deg]", partial(angles, axis=1), span=2.0),
    "yaw": Row("yaw [deg]", partial(angles, axis=2), span=2.0),
    "speed": Row("speed [m/s]", speeds, span=0.05),
    "reward": Row("reward a step", rewards, span=1e-3, note=total_reward),
    "effort": Row("effort / its mean", effort, span=0.05),
    "rotors": Row("rotor speed [rad/s]", rotors, span=20.0),
    "joints": Row("joints [deg]", partial(joints, unit="deg"), span=0.2),
    "sliders": Row("joints [m]", partial(joints, unit="m"), span=0.002),
    "gates": Row(
        "gates passed, lap times",
        lambda subject: infos(subject, "gates_passed", style=STEPS),
        marks=laps,
    ),
    "load": Row(
        "load's error [m]",
        partial(distances, name="payload_error"),
        scale="log",
    ),
    "swing": Row("load's swing [deg]", swings, span=2.0),
    "tilt": Row("load's tilt [deg]", tilts, span=2.0),
    "upright": Row("pendulum's tilt [deg]", upright, span=2.0),
    "tool": Row(
        "gripper to target [m]",
        partial(distances, name="tool_error"),
        scale="log",
    ),
    "escape": Row(
        "smallest distance [m]",
        lambda subject: infos(subject, "evader_distance", "pursuers_distance"),
        span=0.1,
    ),
    "formation": Row(
        "formation [m]",
        lambda subject: infos(subject, "formation_error", "centroid_error"),
        span=0.02,
    ),
    "separation": Row("smallest distance [m]", apart, span=0.1),
    "height": Row("height over deck [m]", height, span=0.1, marks=touch_down),
    "clearance": Row("clearance [m]", lambda subject: infos(subject, "clearance"), span=0.1),
    "charge": Row("charge", lambda subject: infos(subject, "charge"), span=0.01),
}

# The rows that come first, by the info that a flight must have for them; "": any flight.
FIRST: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("gates_passed", ("gates", "speed")),
    ("payload_error", ("load", "swing", "tilt", "separation")),
    ("upright", ("upright",)),
    ("tool_error", ("tool", "joints")),
    ("evader_distance", ("escape", "speed")),
    ("formation_error", ("formation", "separation")),
    ("clearance", ("clearance", "speed")),
    ("charge", ("charge",)),
    ("", ("height", "separation", "error", "speed", "joints", "sliders", "reward", "effort")),
)
INSTEAD = {
    "gates": "error",
    "load": "error",
    "tool": "error",
    "escape": "separation",
}  # rows that say the same
EVERY = ("x", "y", "z", "rotors", "roll", "pitch", "yaw")  # after those


def chosen(subject: Subject) -> list[str]:
    """The rows of a flight, those of its task first."""
    found: list[str] = []
    for info, names in FIRST:
        if info and not subject.infos(info):
            continue
        said: set[str | None] = {*found, *(INSTEAD.get(name) for name in found)}
        found += [name for name in names if name not in said and ROWS[name].curves(subject)]
    return found
