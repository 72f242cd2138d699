"""Cameras of films: where the eye is at a time, and where it looks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from skybody import InputError

from .motion import Array, rotation_of
from .scene import Scene

UP = np.array([0.0, 0.0, 1.0])
LEAST_HEIGHT = 0.08  # of an eye above the ground [m]
FAR_UP = 10.0 * UP
FILLED = 0.5  # share of the picture that robots fill for an orbit camera
LEAD = 0.4  # distance of an orbit camera that a metre of way within 2 SMOOTH adds [m]
SMOOTH = 0.6  # half the time over which cameras are smooth [s]
SLOW = 0.5  # speed at which travel and attitude count equally for the chase camera [m/s]
MARGIN = 0.92  # share of the field of view in which a fixed camera has the whole flight


@dataclass(frozen=True)
class View:
    """A place to see from."""

    eye: Array  # W [m], (3,)
    axes: Array  # W from right, down, forward, (3, 3)


Camera = Callable[[float], View]


def look_at(eye: Array, target: Array) -> View:
    """A level view of a point."""
    eye = raised(eye)
    forward = target - eye
    forward = forward / max(float(np.linalg.norm(forward)), 1e-9)
    right = np.cross(forward, UP)
    aside = float(np.linalg.norm(right))
    right = right / aside if aside > 1e-6 else np.array([0.0, -1.0, 0.0])
    return View(eye, np.column_stack([right, np.cross(forward, right), forward]))


def raised(eye: Array) -> Array:
    """A place that is not below the ground."""
    return np.array([eye[0], eye[1], max(eye[2], LEAST_HEIGHT)])


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


def fixed(scenes: Sequence[Scene], field_of_view: float, aspect: float) -> Camera:
    """Sees all of the flights from one place: the one from which they are most spread out."""
    points = np.concatenate([scene.points() for scene in scenes])
    half = np.tan(0.5 * field_of_view) * MARGIN
    views = [
        fit(points, np.radians(azimuth), np.radians(24.0), (half, half * aspect))
        for azimuth in range(-165, -104, 15)  # the sun behind; no axis points at the eye
    ]
    best = max(views, key=lambda view: spread(points, view))
    return lambda time: best


def spread(points: Array, view: View) -> float:
    """How far points (n, 3), W [m], are apart in a picture: the mean logarithm of distances."""
    seen = (points[:: max(1, len(points) // 300)] - view.eye) @ view.axes
    places = seen[:, :2] / seen[:, 2:]
    apart = np.linalg.norm(places[:, None] - places, axis=-1)
    return float(np.mean(np.log(apart + 1e-2)))


def orbit(scenes: Sequence[Scene], field_of_view: float, aspect: float) -> Camera:
    """Goes about the robots, a turn in 24 s, as near as they allow, farther where they are fast."""
    half = np.tan(0.5 * field_of_view) * FILLED

    def view(time: float) -> View:
        azimuth = np.radians(-125.0 + 15.0 * time)
        places = places_about(scenes, time)
        views = [fit(at, azimuth, np.radians(22.0), (half, half * aspect)) for at in places]
        middles = places.mean(axis=1)
        way = float(np.linalg.norm(np.diff(middles, axis=0), axis=1).sum())
        eye = np.mean([view.eye for view in views], axis=0) - LEAD * way * views[0].axes[:, 2]
        return View(raised(eye), views[0].axes)

    return view


def chase(scenes: Sequence[Scene], field_of_view: float, aspect: float) -> Camera:
    """Follows the first robot from behind, along its way."""
    scene = scenes[0]
    first, count = next(iter(scene.robots.values()))
    own = slice(first, first + count)
    position, quaternion = scene.flight.poses([0.0])
    corners = scene.places(position, quaternion)[0, own].reshape(-1, 3)
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    away = 3.5 * max(size, 0.05)

    def view(time: float) -> View:
        position = scene.flight.at(time)[0][own]
        target = 0.5 * (position.min(axis=0) + position.max(axis=0))
        ahead = heading(scene, first, time)
        return look_at(target + away * (0.38 * UP - ahead), target + 0.1 * away * UP)

    return view


def onboard(scenes: Sequence[Scene], field_of_view: float, aspect: float) -> Camera:
    """Looks ahead from the first robot."""
    scene = scenes[0]
    first = next(iter(scene.robots.values()))[0]
    ahead = np.column_stack([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])

    def view(time: float) -> View:
        position, axes = scene.flight.at(time)
        eye = position[first] + axes[first] @ np.array([0.0, 0.0, 0.45 * scene.size()])
        return View(eye, axes[first] @ ahead)

    return view


CAMERAS: dict[str, Callable[[Sequence[Scene], float, float], Camera]] = {
    "chase": chase,
    "fixed": fixed,
    "orbit": orbit,
    "onboard": onboard,
}


def camera(
    name: str, scenes: Sequence[Scene], field_of_view: float, aspect: float = 0.5625
) -> Camera:
    """A camera by its name.

    Args:
        scenes: at least one, of one world; `chase` and `onboard` go with the first one.
        field_of_view: horizontal [rad].
        aspect: height of the picture over its width.

    Raises:
        InputError: there is no such camera.
    """
    if name not in CAMERAS:
        raise InputError(f"no camera `{name}`; there are: {', '.join(CAMERAS)}")
    return CAMERAS[name](scenes, field_of_view, aspect)


def direction(azimuth: float, elevation: float) -> Array:
    """Unit vector, W; angles [rad]."""
    c = np.cos(elevation)
    return np.array([c * np.cos(azimuth), c * np.sin(azimuth), np.sin(elevation)])


def places_about(scenes: Sequence[Scene], time: float) -> Array:
    """Points about all bodies at some times about a time, (times, n, 3), W [m]."""
    about = time + np.linspace(-SMOOTH, SMOOTH, 9)
    found = []
    for scene in scenes:
        poses = scene.flight.poses(np.clip(about, 0.0, scene.flight.duration))
        found.append(scene.places(*poses).reshape(len(about), -1, 3))
    places = np.concatenate(found, axis=1)
    known = np.isfinite(places).all(axis=(1, 2))
    return places[known] if known.any() else np.zeros((1, 1, 3))


def heading(scene: Scene, body: int, time: float) -> Array:
    """Level direction of travel about a time, unit, W; of a body that stands, where it looks."""
    flight = scene.flight
    times = np.clip(time + np.linspace(-1.2, 0.4, 17), 0.0, flight.duration)
    position, quaternion = flight.poses(times)
    way = position[-1, body] - position[0, body]
    looks = rotation_of(quaternion[:, body])[:, :, 0].mean(axis=0)
    along = (way / (times[-1] - times[0] + 1e-9) + SLOW * looks) * [1.0, 1.0, 0.0]
    length = float(np.linalg.norm(along))
    return along / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
