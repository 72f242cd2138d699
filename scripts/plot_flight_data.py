"""The data of an episode for plot_flight.py, read from a Skybody flight log."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

SHAPES = ("box", "sphere", "cylinder", "capsule", "gate", "plane", "height_field")
ENDINGS = ("terminated", "truncated", "fault", "stopped", "interrupted")


@dataclass
class Track:
    """Track and goal of one body."""

    name: str
    color: str
    position: np.ndarray
    angles: np.ndarray | None  # attitude_degrees(); only of a robot's base
    goal: np.ndarray | None  # x, y, z [m], yaw [rad]

    def follows(self) -> bool:
        """Whether the goal moves between instants: a reference instead of a position."""
        if self.goal is None or len(self.goal) < 3:
            return False
        moves = np.any(np.diff(self.goal[:, :3], axis=0) != 0.0, axis=1)
        return bool(np.mean(moves) > 0.1)

    def goal_yaw(self) -> np.ndarray:
        """The goal's heading in degrees, without jumps, in the same initial turn as the body's."""
        goal = np.degrees(np.unwrap(self.goal[:, 3]))
        return goal + 360.0 * np.round((self.angles[0, 2] - goal[0]) / 360.0)

    def error(self) -> np.ndarray:
        """Distance to the goal in mm."""
        return 1e3 * np.linalg.norm(self.position - self.goal[:, :3], axis=1)


@dataclass
class Joints:
    """The joints of one unit."""

    unit: str  # deg or m
    names: list[str]
    values: np.ndarray  # one row per instant, one column per joint


@dataclass
class Obstacle:
    """A static shape."""

    kind: str  # box, sphere, cylinder, capsule, plane or height_field
    size: np.ndarray  # edges; radius; radius and length along z; none; edges along x and y [m]
    position: np.ndarray
    rotation: np.ndarray  # matrix, W from the shape
    heights: np.ndarray | None = None  # of a height field: a row for each y [m]


@dataclass
class Flight:
    """One episode, read."""

    title: str
    subtitle: str
    time: np.ndarray
    reward: np.ndarray
    bodies: np.ndarray  # instants x bodies x 13
    body_names: list[str]
    tracks: list[Track]
    rotors: list[str]
    rotor_speed: np.ndarray | None
    rotor_command: np.ndarray | None
    joints: list[Joints]
    obstacles: list[Obstacle]
    touching: list[tuple[float, float]]  # time spans with a contact


def attitude_degrees(quaternion: np.ndarray) -> np.ndarray:
    """Roll and pitch (z-y'-x'') and yaw of rows w x y z, without jumps.

    Yaw is that of the tables of `skybody run` and of the controllers: the rotation about z before
    the shortest rotation that tilts.
    """
    w, x, y, z = quaternion.T
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1, 1))
    yaw = 2 * np.arctan2(z, w)
    return np.degrees(np.stack([np.unwrap(roll), pitch, np.unwrap(yaw)], axis=1))


def texts(values) -> list[str]:
    return [v.decode() if isinstance(v, bytes) else str(v) for v in values]


def colors(count: int) -> list:
    """Distinct colours from the cycle if it has enough, otherwise from a continuous map."""
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
        angles = attitude_degrees(body[:, 3:7]) if name in bases else None
        goal = episode["goal"][:, goals.index(name), :] if name in goals else None
        tracks.append(Track(name, color, body[:, :3], angles, goal))
    return tracks


def joints_of(episode: h5py.Group) -> list[Joints]:
    """Angles of revolute and universal joints, the rotation angle of a ball joint from zero, and
    travels of sliders. Joints of free bodies are not drawn.
    """
    if "q" not in episode:
        return []
    dataset = episode["q"]
    columns, units = texts(dataset.attrs["columns"]), texts(dataset.attrs["units"])
    place = {name: k for k, name in enumerate(columns)}
    series: dict[str, list[tuple[str, np.ndarray]]] = {"deg": [], "m": []}
    for name, unit in zip(columns, units, strict=True):
        body, _, part = name.rpartition(".")
        is_free = f"{body}.x" in place and f"{body}.qw" in place
        if is_free or part in ("qx", "qy", "qz"):
            continue
        values = dataset[:, place[name]]
        if part == "qw":
            vector = dataset[:, [place[f"{body}.{q}"] for q in ("qx", "qy", "qz")]]
            turned = 2 * np.arctan2(np.linalg.norm(vector, axis=1), np.abs(values))
            series["deg"].append((f"{body} (ball)", np.degrees(turned)))
        elif unit == "rad":
            series["deg"].append((name.removesuffix(".angle"), np.degrees(values)))
        else:
            series["m"].append((name, values))
    return [
        Joints(unit, [name for name, _ in found], np.stack([v for _, v in found], axis=1))
        for unit, found in series.items()
        if found
    ]


def rotation_of(quaternions: np.ndarray) -> np.ndarray:
    """Matrices, W from body, of rows w x y z."""
    w, x, y, z = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def numbers_in(text: str) -> np.ndarray:
    """The numbers of a list such as `[1, 2]`, or one number."""
    return np.array([float(n) for n in text.strip("[]").split(",") if n.strip()])


def heights_of(keys: dict[str, str], folder: Path) -> np.ndarray | None:
    """The grid of a height field; None if its file is missing."""
    if "heights" in keys:
        return numbers_in(keys["heights"]).reshape(-1, int(keys["columns"]))
    file = folder / keys["file"].strip("\"'")
    return np.loadtxt(file, delimiter=",", ndmin=2) if file.is_file() else None


def obstacles_of(scenario: str, drawn: dict[str, float], folder: Path = Path()) -> list[Obstacle]:
    """Obstacles of a scenario as core/io/yaml/config_writer.cpp writes it: one key per line.

    Args:
        scenario: its text.
        drawn: values of the episode's EnvParams by path, including poses and sizes.
        folder: the scenario's folder, for files of heights.
    """
    section = re.search(r"^obstacles:\n((?:[ -].*\n?)*)", scenario, re.MULTILINE)
    found = []
    for entry in re.split(r"^  - ", section.group(1) if section else "", flags=re.MULTILINE)[1:]:
        keys = dict(re.findall(r"^ *(\w+): (.*)$", entry, re.MULTILINE))
        shapes = re.findall(r"^ *(\w+):", entry, re.MULTILINE)
        kind = next((k for k in SHAPES if k in shapes), None)
        path = f"obstacles.{keys.get('name', '')}."
        if kind is None or not drawn.get(path + "present", 1.0):
            continue
        of_field = kind == "height_field"
        written = numbers_in(keys["size" if of_field else kind] if kind != "plane" else "")
        size = np.array([drawn.get(f"{path}size[{k}]", n) for k, n in enumerate(written)])
        position = np.array([drawn.get(f"{path}position[{k}]", 0.0) for k in range(3)])
        turn = np.array([drawn.get(f"{path}rotation[{k}]", float(k == 0)) for k in range(4)])
        rotation = rotation_of(turn / np.linalg.norm(turn))
        if kind == "gate":
            found += bars_of_gate(size, position, rotation)
        else:
            heights = heights_of(keys, folder) if of_field else None
            found.append(Obstacle(kind, size, position, rotation, heights))
    return found


def bars_of_gate(size: np.ndarray, position: np.ndarray, rotation: np.ndarray) -> list[Obstacle]:
    """Two posts and two beams about an opening of `size[0]` x `size[1]`, `size[2]` thick."""
    width, height, thickness = size
    aside, above = 0.5 * (width + thickness), 0.5 * (height + thickness)
    post = np.array([thickness, thickness, height + 2 * thickness])
    beam = np.array([thickness, width, thickness])
    places = [((0, s * aside, 0), post) for s in (1, -1)] + [
        ((0, 0, s * above), beam) for s in (1, -1)
    ]
    return [
        Obstacle("box", bar, position + rotation @ np.array(at), rotation) for at, bar in places
    ]


def drawn_of(log: h5py.File, episode: h5py.Group) -> dict[str, float]:
    """The episode's EnvParams by path."""
    if "params" not in log or "params" not in episode:
        return {}
    return dict(zip(texts(log["params"]["paths"][:]), episode["params"][:].tolist(), strict=False))


def ending(episode: h5py.Group) -> str:
    events = [e["text"].decode() for e in episode["events"][:]]
    last = events[-1] if events else ""
    return last if last.split(":")[0] in ENDINGS else "unfinished"


def touching_spans(touching: np.ndarray, time: np.ndarray) -> list[tuple[float, float]]:
    """Spans from the row before the first contact to the last one."""
    later = touching[1:] == 1
    edges = np.flatnonzero(np.diff(np.concatenate([[False], later, [False]]).astype(int)))
    return [(time[a], time[b]) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def refusal(log: h5py.File) -> str:
    """The reason why a file is not a flight log; empty: it is one."""
    found = log.attrs.get("format", "")
    if str(found).startswith("skybody flight log"):
        return ""
    if texts([found]) == ["skybody-replay"]:
        return (
            "a recording of many environments, which has no flight to draw; `skybody replay` runs "
            "it again, and `skybody run` writes flight.h5"
        )
    return "no flight log: draw a flight.h5, which `skybody run` writes"


def read_flight(log: h5py.File, name: str) -> Flight:
    episode = log["episodes"][name]
    time = episode["time"][:]
    about = log.attrs
    title = str(about["scenario"])
    if followed := dict.fromkeys(texts(about.get("references", []))):
        title += f" along {', '.join(followed)}"
    title += f"  ·  episode {int(name)} of {len(log['episodes'])}"
    if "action" in episode:  # otherwise there is no policy
        title += f"  ·  policy {about['policy']}"
    title += f"  ·  seed {about['seed']}"
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
        bodies=episode["bodies"][:],
        body_names=texts(episode["bodies"].attrs["items"]),
        tracks=read_tracks(episode),
        rotors=rotors,
        rotor_speed=episode["rotor_speed"][:] if rotors else None,
        rotor_command=episode["rotor_command"][:] if rotors else None,
        joints=joints_of(episode),
        obstacles=obstacles_of(
            str(about["scenario_text"]),
            drawn_of(log, episode),
            Path(str(about["scenario_file"])).parent,
        ),
        touching=touching_spans(episode["touching"][:], time) if "touching" in episode else [],
    )
