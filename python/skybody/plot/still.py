"""The picture of a flight in space: its path, with vehicles at some instants, drawn by the renderer
of films.
"""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from skybody._native import Renderer
from skybody.look.cameras import View, fixed, look_at
from skybody.look.film import FARTHEST, Frame
from skybody.look.flight import Array
from skybody.look.scene import Scene, Style
from skybody.look.shapes import Shapes
from skybody.look.trails import breaks

from .measures import decks
from .subject import Subject

FIELD_OF_VIEW = np.radians(40.0)  # horizontal: nearly parallel
WIDTH = 5.0  # of paths [pixels of 1080 rows]
MOST_POINTS = 2000  # of a path
INSTANTS = 6  # number of vehicles along a path
MOST_FREE = 2  # robots with rotors that are drawn at several instants with their times
CLOSE_UP = (0.26, 0.2)  # width and height, as shares of the picture's width
SMALL = 0.06  # radius over half the picture's width of a robot that is shown closer
ROOM = 0.055  # between two texts, as a share of the picture's width


def draw_still(panel: Axes, subject: Subject, pixels: tuple[int, int]) -> None:
    """Draws the picture into a panel.

    Args:
        pixels: width and height of the picture.
    """
    panel.set_axis_off()
    if subject.problem:
        panel.text(0.5, 0.5, fill(subject.problem, 60), ha="center", transform=panel.transAxes)
        return
    scene = Scene(subject.flight, Style(trail=0.0, contacts=False, reference=is_one_path(subject)))
    view = fixed([scene], FIELD_OF_VIEW, pixels[1] / pixels[0])(0.0)
    times = instants(subject)
    panel.imshow(render(subject, scene, view, times, pixels), interpolation="antialiased")
    if len(times) > 1:
        write_times(panel, subject, view, times, pixels)
    free, next_free = free_corners(scene, view, pixels)
    draw_axes(panel, view, pixels, free.place)
    if is_small(subject, view) and next_free.room > CLOSE_UP[0] * pixels[0]:
        draw_close_up(panel, subject, scene, view, pixels, next_free.place)


def first_robot(subject: Subject) -> tuple[int, float]:
    """Index of its base among all bodies, and its radius with its rotors [m]."""
    first, count = subject.robots[(subject.flown or list(subject.robots))[0]]
    place, axes = subject.flight.at(0.0)
    hubs = [
        place[rotor.body] + axes[rotor.body] @ np.array(rotor.position)
        for rotor in subject.flight.compiled.rotors
        if first <= rotor.body < first + count
    ]
    arms = [float(np.linalg.norm(hub - place[first])) for hub in hubs]
    return first, 1.3 * max(arms, default=0.15)


def is_one_path(subject: Subject) -> bool:
    """Whether no goal jumps: those of a race lead through gate after gate."""
    return not any(breaks(goal[:, :3])[1:].any() for goal in subject.goals.values())


def instants(subject: Subject) -> list[float]:
    """Times at which vehicles are drawn [s]: the last one is the end's."""
    if len(subject.flown) > MOST_FREE:
        return [0.0, float(subject.time[-1])]
    base, radius = first_robot(subject)
    rows = instants_along(np.nan_to_num(subject.bodies[:, base, :3]), 2.5 * radius)
    return [float(subject.time[row]) for row in rows]


def instants_along(path: Array, size: float) -> Array:
    """Rows at equal distances along a path; fewer if it is short compared with the vehicles.

    Args:
        path: (rows, 3) [m].
        size: least distance between two drawn vehicles [m].
    """
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    count = int(np.clip(way[-1] / size, 0, INSTANTS - 1)) + 1
    rows = np.searchsorted(way, np.linspace(0.0, way[-1], count))
    return np.unique(np.append(rows[:-1], len(path) - 1))


def render(
    subject: Subject, scene: Scene, view: View, times: list[float], pixels: tuple[int, int]
) -> Frame:
    """The picture."""
    shapes = Shapes()
    scene.add_to(shapes, times[-1])
    standing = decks(subject)
    moving = [name for name in subject.robots if name not in standing]
    for time in times[:-1]:
        scene.add_robots(shapes, time, moving)
    for track in subject.tracks:
        if track.name.split(".")[0] in moving:
            rows = np.unique(np.linspace(0, len(subject.time) - 1, MOST_POINTS).astype(int))
            shapes.lines.add(track.position[rows], WIDTH, track.color)
    return drawn(shapes, view, pixels, len(times) * scene.triangles)


def drawn(shapes: Shapes, view: View, pixels: tuple[int, int], triangles: int) -> Frame:
    """A picture of some shapes.

    Args:
        triangles: number in their meshes.
    """
    focal = 0.5 * pixels[0] / np.tan(0.5 * FIELD_OF_VIEW)
    renderer = Renderer(pixels[0], pixels[1], focal, len(shapes), triangles, FARTHEST)
    rgb = np.empty((pixels[1], pixels[0], 3), np.uint8)
    shapes.draw(renderer, view.eye, view.axes, rgb)
    return rgb


def write_times(
    panel: Axes, subject: Subject, view: View, times: list[float], pixels: tuple[int, int]
) -> None:
    """Writes the time above the first robot at each instant, where there is room."""
    base, radius = first_robot(subject)
    above = np.array([0.0, 0.0, 0.6 * radius])
    written: list[Array] = []
    for time in reversed(times):
        at = projected(view, subject.flight.at(time)[0][base] + above, pixels)
        at[1] = max(at[1], ROOM * pixels[0])
        if any(np.linalg.norm(at - other) < ROOM * pixels[0] for other in written):
            continue
        written.append(at)
        write(panel, at, f"{time:.1f} s" if time else "0 s", "center", "bottom")


def write(panel: Axes, at: Array, words: str, across: str, up: str, **more: Any) -> None:
    """Writes words at a place of the picture [pixels], so that they can be read on anything."""
    halo = patheffects.withStroke(linewidth=2.5, foreground="white", alpha=0.8)
    panel.text(at[0], at[1], words, ha=across, va=up, zorder=5, path_effects=[halo], **more)


def projected(view: View, places: Array, pixels: tuple[int, int]) -> Array:
    """Where places, (..., 3), W [m], are in the picture, (..., 2) [pixels]."""
    seen = (places - view.eye) @ view.axes
    focal = 0.5 * pixels[0] / np.tan(0.5 * FIELD_OF_VIEW)
    return np.asarray(0.5 * np.array(pixels) + focal * seen[..., :2] / seen[..., 2:])


@dataclass(frozen=True)
class Corner:
    """Of the picture."""

    place: Array  # [pixels]
    room: float  # distance of the nearest body [pixels]


def free_corners(scene: Scene, view: View, pixels: tuple[int, int]) -> list[Corner]:
    """The two corners of the picture that are farthest from all bodies and near obstacles."""
    seen = projected(view, scene.points(), pixels)
    width, height = pixels
    found = []
    for corner in [np.array([x, y]) for y in (height, 0) for x in (0, width)]:
        found.append(Corner(corner, float(np.linalg.norm(seen - corner, axis=1).min())))
    return sorted(found, key=lambda corner: -corner.room)[:2]


def is_small(subject: Subject, view: View) -> bool:
    """Whether the first robot can hardly be seen."""
    base, radius = first_robot(subject)
    away = float(np.linalg.norm(subject.bodies[-1, base, :3] - view.eye))
    return bool(radius / away < SMALL * np.tan(0.5 * FIELD_OF_VIEW))


def draw_close_up(
    panel: Axes, subject: Subject, scene: Scene, view: View, pixels: tuple[int, int], corner: Array
) -> None:
    """The first robot in the middle of the flight, in a frame in a corner."""
    base, radius = first_robot(subject)
    time = 0.5 * float(subject.time[-1])
    shapes = Shapes()
    scene.add_to(shapes, time)
    place = subject.flight.at(time)[0][base]
    away = radius / (0.75 * np.tan(0.5 * FIELD_OF_VIEW))
    eye = place - away * view.axes[:, 2]
    width, height = (round(share * pixels[0]) for share in CLOSE_UP)
    rgb = drawn(shapes, look_at(eye, place), (width, height), scene.triangles)
    left = corner[0] - (corner[0] > 0) * width
    top = corner[1] - (corner[1] > 0) * height
    panel.imshow(rgb, extent=(left, left + width, top + height, top), zorder=3)
    frame = Rectangle((left, top), width, height, fill=False, edgecolor="white", linewidth=1.5)
    panel.add_patch(frame).set_zorder(4)
    write(
        panel, np.array([left + 0.04 * width, top + 0.04 * width]), f"{time:.1f} s", "left", "top"
    )
    panel.set(xlim=(0, pixels[0]), ylim=(pixels[1], 0))


def draw_axes(panel: Axes, view: View, pixels: tuple[int, int], corner: Array) -> None:
    """Directions of x, y and z in a corner, and the size of the tiles below them."""
    inset = 0.09 * pixels[0]
    origin = np.clip(corner, inset, np.array(pixels) - inset)
    arrow = {"arrowstyle": "-|>,head_width=0.15,head_length=0.3", "shrinkA": 0, "shrinkB": 0}
    for name, axis in zip("xyz", view.axes[:, :2], strict=True):
        tip, end = (origin + length * pixels[0] * axis for length in (0.05, 0.064))
        panel.annotate("", (tip[0], tip[1]), (origin[0], origin[1]), arrowprops=arrow)
        write(panel, end, name, "center", "center", fontstyle="italic")
    below = origin[1] + 0.055 * pixels[0]
    place = np.array([origin[0], below])
    write(panel, place, "tiles: 1 m", "center", "center", fontsize="small")
