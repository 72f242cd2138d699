"""The values of a flight that are drawn: tracks of bodies, joints, contacts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from skybody import InputError
from skybody.look.flight import Array, Flight, texts
from skybody.look.palette import colors
from skybody.look.scene import robots_of
from skybody.look.shapes import Color

MOST_ROWS = 50_000  # of a flight that are drawn
ENDINGS = ("terminated", "truncated", "fault", "stopped", "interrupted")


@dataclass
class Track:
    """Track and goal of one body."""

    name: str
    color: Color
    position: Array  # (rows, 3), W [m]
    angles: Array | None  # attitude_degrees(); only of a robot's base
    goal: Array | None  # (rows, 4): x, y, z, W [m], yaw [rad]

    def goal_yaw(self) -> Array:
        """The goal's heading [deg], always in the turn in which it is nearest to the body's."""
        assert self.goal is not None and self.angles is not None
        ahead = np.degrees(self.goal[:, 3]) - self.angles[:, 2]
        return np.asarray(self.angles[:, 2] + (ahead + 180.0) % 360.0 - 180.0)

    def error(self) -> Array:
        """Distance from the goal [m]."""
        assert self.goal is not None
        return np.asarray(np.linalg.norm(self.position - self.goal[:, :3], axis=1))


class Subject:
    """A flight as it is drawn."""

    def __init__(self, flight: Flight) -> None:
        """Of a long flight, takes rows at equal distances.

        Args:
            flight: an episode of a log.
        """
        self.flight = flight
        last = len(flight.time) - 1
        self.rows = np.unique(np.linspace(0, last, min(last + 1, MOST_ROWS)).astype(int))
        self.time = flight.time[self.rows]
        self.robots = robots_of(flight)

    @cached_property
    def bodies(self) -> Array:
        """Rows x bodies x 13, as of Flight.bodies."""
        return self.flight.rows("bodies")[self.rows]

    @cached_property
    def goals(self) -> dict[str, Array]:
        """By the name of the body that has it: rows x 4, as of Flight.goals."""
        return self.flight.goals_in(self.rows)

    @cached_property
    def rotor_speed(self) -> Array:
        """Rows x rotors [rad/s]."""
        return self.flight.rows("rotor_speed")[self.rows]

    @cached_property
    def tracks(self) -> list[Track]:
        """The base of each robot, then other bodies that have a goal."""
        names, goals = self.flight.body_names, self.goals
        bases = [names[first] for first, _ in self.robots.values()]
        shown = [*bases, *(name for name in names if name in goals and name not in bases)]
        found = []
        for name, color in zip(shown, colors(len(shown)), strict=True):
            body = self.bodies[:, names.index(name)]
            angles = attitude_degrees(body[:, 3:7]) if name in bases else None
            found.append(Track(name, color, body[:, :3], angles, goals.get(name)))
        return found

    @property
    def moving(self) -> list[Track]:
        """Tracks of bodies that are not fixed to the world."""
        return [track for track in self.tracks if np.ptp(track.position, axis=0).any()]

    @cached_property
    def problem(self) -> str:
        """The reason why the flight's scenario cannot be loaded; empty: it can."""
        try:
            _ = self.flight.compiled
        except InputError as error:
            return str(error)
        return ""

    @cached_property
    def flown(self) -> list[str]:
        """Names of the robots with rotors."""
        names = dict.fromkeys(name.split(".")[0] for name in self.flight.rotor_names)
        return [name for name in self.robots if name in names]

    def base(self, robot: str) -> Array:
        """States of a robot's base, (rows, 13), as of Flight.bodies."""
        return np.asarray(self.bodies[:, self.robots[robot][0]])

    def color(self, robot: str) -> Color:
        """A robot's colour."""
        return self.tracks[list(self.robots).index(robot)].color

    @property
    def reward(self) -> Array:
        """Of each step of the flight."""
        return self.flight.series("reward")[0]

    @cached_property
    def command(self) -> Array:
        """Commanded speed of each rotor [rad/s], (rows, rotors)."""
        return self.flight.rows("rotor_command")[self.rows]

    def infos(self, name: str) -> list[tuple[str, Array, str]]:
        """Infos NAME and PREFIX.NAME: their prefixes (`` without), values and units."""
        found = []
        for column, _ in self.flight.columns("info"):
            prefix, _, last = column.rpartition(".")
            if last == name:
                values, unit = self.flight.series(column)
                found.append((prefix, values[self.rows], unit))
        return found

    @cached_property
    def joints(self) -> dict[str, list[tuple[str, Array]]]:
        """Names and values of the joints by unit: `deg` or `m`.

        Angles of revolute and universal joints, the rotation angle of a ball joint from zero, and
        travels of sliders; none of free bodies.
        """
        columns = dict(self.flight.columns("q"))
        q = self.flight.rows("q")[self.rows]
        series = {name: np.asarray(q[:, k]) for k, name in enumerate(columns)}
        found: dict[str, list[tuple[str, Array]]] = {"deg": [], "m": []}
        for name, unit in columns.items():
            body, _, part = name.rpartition(".")
            is_free = f"{body}.x" in columns and f"{body}.qw" in columns
            if is_free or part in ("qx", "qy", "qz"):
                continue
            values = series[name]
            if part == "qw":
                vector = [series[f"{body}.{axis}"] for axis in ("qx", "qy", "qz")]
                turned = 2.0 * np.arctan2(np.linalg.norm(vector, axis=0), np.abs(values))
                found["deg"].append((f"{body} (ball)", np.degrees(turned)))
            elif unit == "rad":
                found["deg"].append((name.removesuffix(".angle"), np.degrees(values)))
            else:
                found["m"].append((name, values))
        return found

    @cached_property
    def contact(self) -> NDArray[np.bool_]:
        """Rows before which, since the row before, something touches something."""
        firsts = np.append(0, self.rows[:-1] + 1)
        return np.logical_or.reduceat(self.flight.touching, firsts)

    @cached_property
    def touching(self) -> list[tuple[float, float]]:
        """Spans of time [s] from the row before the first contact to the last one."""
        return touching_spans(self.contact, self.time)

    # --- heading --------------------------------------------------------------------------------

    @property
    def title(self) -> str:
        """Scenario, reference, episode, policy, seed."""
        about = self.flight.attributes
        words = self.flight.scenario
        if followed := dict.fromkeys(texts(about.get("references", []))):
            words += f" along {', '.join(followed)}"
        words += f"  ·  episode {self.flight.episode} of {len(self.flight.episodes)}"
        if self.flight.columns("action"):  # otherwise there is no policy
            words += f"  ·  policy {about['policy']}"
        return words + (f"  ·  seed {about['seed']}" if "seed" in about else "")

    @property
    def subtitle(self) -> str:
        """End, duration, steps, hash, version."""
        about = self.flight.attributes
        last = self.flight.events[-1][1] if self.flight.events else ""
        ending = last if last.split(":")[0] in ENDINGS else "unfinished"
        words = f"{ending} after {self.time[-1]:.3f} s, {len(self.flight.time) - 1} steps"
        if "action_repeat" in about:
            words += f" of {about['action_repeat']} x {1e3 * about['dt']:g} ms"
        words += f"  ·  scenario {about.get('scenario_hash', '?')}"
        return words + f"  ·  Skybody {self.flight.version}"


def attitude_degrees(quaternions: Array) -> Array:
    """Roll and pitch (z-y'-x'') and yaw of rows w x y z, without jumps.

    Yaw is that of the tables of `skybody run` and of the controllers: the rotation about z before
    the shortest rotation that tilts.
    """
    w, x, y, z = quaternions.T
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1, 1))
    yaw = 2 * np.arctan2(z, w)
    return np.asarray(np.degrees(np.stack([np.unwrap(roll), pitch, np.unwrap(yaw)], axis=1)))


def touching_spans(touching: ArrayLike, time: Array) -> list[tuple[float, float]]:
    """Spans from the row before the first contact to the last one."""
    later = np.asarray(touching)[1:] == 1
    edges = np.flatnonzero(np.diff(np.concatenate([[False], later, [False]]).astype(int)))
    return [(float(time[a]), float(time[b])) for a, b in zip(edges[::2], edges[1::2], strict=True)]
