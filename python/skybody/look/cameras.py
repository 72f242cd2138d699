"""Cameras of films: where the eye is at a time, and where it looks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from skybody import InputError

from .flight import Array
from .scene import Scene

UP = np.array([0.0, 0.0, 1.0])
LEAST_HEIGHT = 0.08  # of an eye above the ground [m]
FAR_UP = 10.0 * UP
MARGIN = 0.92  # share of the field of view in which a fixed camera has the whole flight


@dataclass(frozen=True)
class View:
    """A place to see from."""

    eye: Array  # W [m], (3,)
    axes: Array  # W from right, down, forward, (3, 3)


Camera = Callable[[float], View]


def look_at(eye: Array, target: Array) -> View:
    """A level view of a point."""
    eye = np.array([eye[0], eye[1], max(eye[2], LEAST_HEIGHT)])
    forward = target - eye
    forward = forward / max(float(np.linalg.norm(forward)), 1e-9)
    right = np.cross(forward, UP)
    aside = float(np.linalg.norm(right))
    right = right / aside if aside > 1e-6 else np.array([0.0, -1.0, 0.0])
    return View(eye, np.column_stack([right, np.cross(forward, right), forward]))


def fit(points: Array, azimuth: float, elevation: float, half: tuple[float, float]) -> View:
    """The nearest view from a direction that has all points in the picture.

    Args:
        points: (n, 3), W [m].
        azimuth, elevation: of the eye, seen from the points [rad].
        half: tangents of half the horizontal and half the vertical field of view.
    """
    view = look_at(direction(azimuth, elevation) + FAR_UP, FAR_UP)
    seen = points @ view.axes
    eye = np.empty(3)
    away = 0.0
    for k, tangent in enumerate(half):
        low = float(np.min(seen[:, k] + tangent * seen[:, 2]))
        high = float(np.max(seen[:, k] - tangent * seen[:, 2]))
        eye[k] = 0.5 * (low + high)
        away = max(away, (high - low) / (2.0 * tangent))
    eye[2] = -away
    return View(view.axes @ eye, view.axes)


def fixed(scene: Scene, field_of_view: float, aspect: float) -> Camera:
    """Sees the whole flight from one place, of several directions that of the nearest one."""
    points = scene.points()
    half = np.tan(0.5 * field_of_view) * MARGIN
    views = [
        fit(points, np.radians(azimuth), np.radians(24.0), (half, half * aspect))
        for azimuth in range(-200, -80, 15)  # the sun behind
    ]
    middle = points.mean(axis=0)
    nearest = min(views, key=lambda view: float(np.linalg.norm(view.eye - middle)))
    return lambda time: nearest


def orbit(scene: Scene, field_of_view: float, aspect: float) -> Camera:
    """Goes about the middle of the robots, a turn in 24 s."""
    times = np.linspace(0.0, scene.flight.duration, 61)
    middles = np.array([smooth_center(scene, float(t)) for t in times])
    bodies = np.array([scene.flight.at(float(t))[0] for t in times])
    apart = np.linalg.norm(bodies - middles[:, None], axis=-1).max(axis=1)
    away = 5.0 * scene.size() + 2.3 * float(np.nanpercentile(apart, 95.0))

    def view(time: float) -> View:
        azimuth = np.radians(-125.0 + 15.0 * time)
        middle = smooth_center(scene, time)
        return look_at(middle + away * direction(azimuth, np.radians(22.0)), middle)

    return view


def chase(scene: Scene, field_of_view: float, aspect: float) -> Camera:
    """Follows the first robot from behind, along its way."""
    away = 9.0 * scene.size()
    times = np.arange(0.0, scene.flight.duration + 0.1, 0.1)
    first = next(iter(scene.robots.values()))[0]
    place = np.array([scene.flight.at(t)[0][first] for t in times])
    heading = headings(place, scene.flight.at(0.0)[1][first])

    def view(time: float) -> View:
        target = scene.flight.at(time)[0][first]
        angle = np.interp(time, times, heading)
        back = -np.array([np.cos(angle), np.sin(angle), 0.0]) + 0.38 * UP
        return look_at(target + away * back, target + 0.1 * away * UP)

    return view


def onboard(scene: Scene, field_of_view: float, aspect: float) -> Camera:
    """Looks ahead from the first robot."""
    first = next(iter(scene.robots.values()))[0]
    ahead = np.column_stack([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])

    def view(time: float) -> View:
        position, axes = scene.flight.at(time)
        eye = position[first] + axes[first] @ np.array([0.0, 0.0, 0.45 * scene.size()])
        return View(eye, axes[first] @ ahead)

    return view


CAMERAS: dict[str, Callable[[Scene, float, float], Camera]] = {
    "chase": chase,
    "fixed": fixed,
    "orbit": orbit,
    "onboard": onboard,
}


def camera(name: str, scene: Scene, field_of_view: float, aspect: float = 0.5625) -> Camera:
    """A camera by its name.

    Args:
        field_of_view: horizontal [rad].
        aspect: height of the picture over its width.

    Raises:
        InputError: there is no such camera.
    """
    if name not in CAMERAS:
        raise InputError(f"no camera `{name}`; there are: {', '.join(CAMERAS)}")
    return CAMERAS[name](scene, field_of_view, aspect)


def direction(azimuth: float, elevation: float) -> Array:
    """Unit vector, W; angles [rad]."""
    c = np.cos(elevation)
    return np.array([c * np.cos(azimuth), c * np.sin(azimuth), np.sin(elevation)])


def smooth_center(scene: Scene, time: float) -> Array:
    """Mean of the robots' middle over 1.5 s about a time, W [m]."""
    times = np.clip(time + np.linspace(-0.75, 0.75, 7), 0.0, scene.flight.duration)
    return np.asarray(np.mean([scene.center(float(t)) for t in times], axis=0))


def headings(place: Array, axes: Array) -> Array:
    """Direction of travel at equal times [rad], smooth; while it stands still the last one."""
    angle = float(np.arctan2(axes[1, 0], axes[0, 0]))
    found = [angle]
    for step in np.diff(place[:, :2], axis=0):
        if np.linalg.norm(step) > 0.02:
            turn = np.arctan2(step[1], step[0]) - angle
            turn = (turn + np.pi) % (2.0 * np.pi) - np.pi
            angle += float(np.clip(0.25 * turn, -0.35, 0.35))
        found.append(angle)
    return np.array(found)
