"""The picture of a flight in space: paths, vehicles at some instants, obstacles."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from plot_flight_data import Flight, Obstacle, rotation_of

TOUCHING = {"color": "gold", "alpha": 0.4, "linewidth": 0}
AXES = ("tab:red", "tab:green", "tab:blue")
INSTANTS = 7  # number of drawn vehicles along each path
AROUND = 24  # points of a circle
MOST_CELLS = 60  # of a height field, drawn along an edge


# --- obstacles ----------------------------------------------------------------------------------


def box_faces(size: np.ndarray) -> list[np.ndarray]:
    faces = []
    for axis in range(3):
        for side in (-0.5, 0.5):
            corners = np.full((4, 3), side)
            others = [k for k in range(3) if k != axis]
            corners[:, others] = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
            faces.append(corners * size)
    return faces


def turned_faces(profile: np.ndarray) -> list[np.ndarray]:
    """A surface of revolution about z: quadrilaterals between circles (radius, height)."""
    angles = np.linspace(0, 2 * np.pi, AROUND + 1)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    circles = [np.column_stack([r * ring, np.full(len(ring), h)]) for r, h in profile]
    return [
        np.array([low[k], low[k + 1], high[k + 1], high[k]])
        for low, high in pairwise(circles)
        for k in range(AROUND)
    ]


def field_faces(size: np.ndarray, heights: np.ndarray | None) -> list[np.ndarray]:
    """The triangles of a height field; with too many cells, larger ones; without heights a
    rectangle.
    """
    if heights is None:
        heights = np.zeros((2, 2))
    rows, columns = (
        np.unique(np.linspace(0, n - 1, min(n, MOST_CELLS + 1)).astype(int)) for n in heights.shape
    )
    y, x = (
        size[k] * (places / (n - 1) - 0.5)
        for k, places, n in zip((1, 0), (rows, columns), heights.shape, strict=True)
    )
    grid = np.stack([*np.meshgrid(x, y), heights[np.ix_(rows, columns)]], axis=-1)
    low, right, high, left = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    both = np.stack([np.stack([low, right, high], -2), np.stack([low, high, left], -2)], axis=2)
    return list(both.reshape(-1, 3, 3))


def plane_faces(obstacle: Obstacle, low: np.ndarray, high: np.ndarray) -> list[np.ndarray]:
    """The part of a plane within a box, in W: a polygon, or nothing."""
    normal = obstacle.rotation[:, 2]
    corners = np.array([[(low, high)[k >> a & 1][a] for a in range(3)] for k in range(8)])
    apart = (corners - obstacle.position) @ normal
    points = []
    for k in range(8):
        for other in (k | 1 << a for a in range(3) if not k >> a & 1):
            if apart[k] * apart[other] <= 0 and apart[k] != apart[other]:
                share = apart[k] / (apart[k] - apart[other])
                points.append(corners[k] + share * (corners[other] - corners[k]))
    if len(points) < 3:
        return []
    spread = np.array(points) - np.mean(points, axis=0)
    angles = np.arctan2(spread @ obstacle.rotation[:, 1], spread @ obstacle.rotation[:, 0])
    return [np.array(points)[np.argsort(angles)]]


def faces_of(obstacle: Obstacle) -> list[np.ndarray]:
    """Its faces in W; empty for a plane, which is infinite."""
    if obstacle.kind == "plane":
        return []
    if obstacle.kind == "box":
        faces = box_faces(obstacle.size)
    elif obstacle.kind == "height_field":
        faces = field_faces(obstacle.size, obstacle.heights)
    elif obstacle.kind == "capsule":
        radius, half = obstacle.size[0], 0.5 * obstacle.size[1]
        angles = np.linspace(0, np.pi / 2, AROUND // 4 + 1)
        cap = np.stack([radius * np.cos(angles), half + radius * np.sin(angles)], axis=1)
        faces = turned_faces(np.concatenate([(cap * [1, -1])[::-1], cap]))
    elif obstacle.kind == "sphere":
        angles = np.linspace(-np.pi / 2, np.pi / 2, AROUND // 2 + 1)
        faces = turned_faces(obstacle.size[0] * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    else:
        radius, half = obstacle.size[0], 0.5 * obstacle.size[1]
        faces = turned_faces(np.array([(0, -half), (radius, -half), (radius, half), (0, half)]))
    return [face @ obstacle.rotation.T + obstacle.position for face in faces]


def draw_obstacles(panel, obstacles: list[Obstacle], low: np.ndarray, high: np.ndarray) -> None:
    """Draws obstacles, clipped at the border of the picture."""
    for obstacle in obstacles:
        is_plane = obstacle.kind == "plane"
        faces = np.array(plane_faces(obstacle, low, high) if is_plane else faces_of(obstacle))
        if not len(faces):
            continue
        points = faces.reshape(-1, 3)
        if (points.max(axis=0) < low).any() or (points.min(axis=0) > high).any():
            continue
        has_edges = obstacle.kind in ("box", "plane", "height_field")
        panel.add_collection3d(
            Poly3DCollection(
                np.clip(faces, low, high),
                facecolor=(0.55, 0.55, 0.55, 0.25),
                edgecolor=(0.3, 0.3, 0.3, 0.6 if has_edges else 0.0),
                linewidth=0.6,
            )
        )


# --- vehicles -----------------------------------------------------------------------------------


def instants_along(path: np.ndarray, size: float) -> np.ndarray:
    """Rows at equal distances along a path; fewer if it is short compared with the vehicles."""
    steps = np.linalg.norm(np.nan_to_num(np.diff(path, axis=0)), axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    count = int(np.clip(way[-1] / (2 * size), 1, INSTANTS - 1)) + 1
    return np.unique(np.searchsorted(way, np.linspace(0, way[-1], count)))


def parents(bodies: np.ndarray) -> list[int]:
    """For each body of a robot except the base, the earlier body in whose frame its origin moves
    least.

    Rotary joints keep the origin fixed there. Of several such bodies it is the nearest.
    """
    found = []
    for k in range(1, bodies.shape[1]):
        offsets = bodies[:, k, None, :3] - bodies[:, :k, :3]
        local = np.einsum("tkji,tkj->tki", rotation_of(bodies[:, :k, 3:7]), offsets)
        spread = np.linalg.norm(local.std(axis=0), axis=1)
        distance = np.linalg.norm(local.mean(axis=0), axis=1)
        found.append(int(np.argmin(np.where(spread <= spread.min() + 1e-6, distance, np.inf))))
    return found


def draw_vehicles(panel, flight: Flight, size: float) -> None:
    """Each robot at some instants: the axes of its base, and lines to the bodies on its joints."""
    robots: dict[str, list[int]] = {}
    for k, name in enumerate(flight.body_names):
        robots.setdefault(name.split(".")[0], []).append(k)
    many = len(robots) > 3
    for columns in robots.values():
        bodies = flight.bodies[:, columns]
        bodies = bodies[np.isfinite(bodies).all(axis=(1, 2))]
        if not len(bodies):
            continue
        rows = instants_along(bodies[:, 0, :3], (2 if many else 1) * size)
        origins, rotations = bodies[rows, 0, :3], rotation_of(bodies[rows, 0, 3:7])
        for axis, color in enumerate(AXES):
            tips = origins + size * rotations[:, :, axis]
            lines = np.stack([origins, tips], axis=1)
            panel.add_collection3d(Line3DCollection(lines, colors=color, linewidths=1.3))
        for k, parent in enumerate(parents(bodies), start=1):
            lines = np.stack([bodies[rows, parent, :3], bodies[rows, k, :3]], axis=1)
            panel.add_collection3d(Line3DCollection(lines, colors="dimgrey", linewidths=1.0))
            panel.scatter(*bodies[rows, k, :3].T, color="dimgrey", s=5, depthshade=False)


# --- the panel ----------------------------------------------------------------------------------


def limits_of(flight: Flight) -> tuple[np.ndarray, np.ndarray]:
    """A box around paths, goals and moving bodies, and the nearby part of the obstacles."""
    sets = [flight.bodies[:, :, :3].reshape(-1, 3)]
    sets += [t.goal[:, :3] for t in flight.tracks if t.goal is not None]
    points = np.concatenate(sets)
    points = points[np.isfinite(points).all(axis=1)]
    low, high = points.min(axis=0), points.max(axis=0)
    margin = max(0.05, 0.5 * float((high - low).max()))
    for obstacle in flight.obstacles:
        if obstacle.kind == "plane":
            continue
        corners = np.array(faces_of(obstacle)).reshape(-1, 3)
        if (corners.max(axis=0) > low - margin).all() and (
            corners.min(axis=0) < high + margin
        ).all():
            points = np.concatenate([points, np.clip(corners, low - margin, high + margin)])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, span = 0.5 * (low + high), high - low
    half = 0.55 * np.maximum(span, max(0.05, 0.6 * float(span.max())))
    return middle - half, middle + half


def draw_path(panel, flight: Flight) -> None:
    low, high = limits_of(flight)
    draw_obstacles(panel, flight.obstacles, low, high)
    for track in flight.tracks:
        panel.plot(*track.position.T, color=track.color, linewidth=1.1)
        for begin, end in flight.touching:
            rows = (flight.time >= begin) & (flight.time <= end)
            panel.plot(*track.position[rows].T, **{**TOUCHING, "linewidth": 5})
        panel.scatter(*track.position[0], color=track.color, marker="o", s=14)
        panel.scatter(*track.position[-1], color=track.color, marker="s", s=18)
        if track.goal is not None:
            if track.follows():
                panel.plot(
                    *track.goal[:, :3].T, color="black", linestyle=(0, (4, 3)), linewidth=0.9
                )
            panel.scatter(*track.goal[-1, :3], color="black", marker="+", s=60, linewidths=1.2)
    draw_vehicles(panel, flight, 0.07 * float((high - low).max()))
    for axis, limits in enumerate((panel.set_xlim, panel.set_ylim, panel.set_zlim)):
        limits(low[axis], high[axis])
    panel.set_box_aspect(high - low, zoom=0.87)
    panel.locator_params(nbins=4)
    panel.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    panel.tick_params(labelsize=8, pad=0)
    words = "path: ● start  ■ end  + goal; axes of the base: x red, y green, z blue"
    panel.set_title(words, fontsize=8.5, y=1.0)
