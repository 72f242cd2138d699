"""The world of a flight as shapes to draw: vehicles, obstacles, couplings, goals, trails."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from skybody._native import Mesh, Rotor, Shape, Visual

from .flight import Array, Flight, rotation_of
from .palette import colors
from .shapes import (
    BOX,
    CAPSULE,
    CYLINDER,
    GROUND,
    IDENTITY,
    MESH,
    SPHERE,
    Color,
    Shapes,
    towards,
)

KINDS = {
    "box": BOX,
    "sphere": SPHERE,
    "cylinder": CYLINDER,
    "capsule": CAPSULE,
    "plane": GROUND,
    "mesh": MESH,
}
FLOOR: tuple[Color, Color] = ((0.74, 0.76, 0.77), (0.80, 0.82, 0.83))
GRASS: Color = (0.52, 0.58, 0.48)
OBSTACLES: dict[str, Color] = {
    "gate": (0.95, 0.42, 0.10),
    "cylinder": (0.47, 0.33, 0.21),
    "capsule": (0.27, 0.45, 0.22),
    "sphere": (0.25, 0.45, 0.70),
}
STONE: Color = (0.62, 0.56, 0.47)
ROPE: Color = (0.13, 0.13, 0.14)
BLADE: Color = (0.10, 0.10, 0.11)
GOAL: Color = (0.10, 0.62, 0.28)
THRUST: Color = (0.90, 0.72, 0.10)


@dataclass(frozen=True)
class Fixed:
    """A shape fixed to a body, or standing in the world."""

    kind: int
    body: int  # -1: the world
    position: Array
    axes: Array
    half: tuple[float, float, float]
    color: Color
    mesh: Mesh | None = None
    corners: Array | None = None  # of the mesh's triangles, (n, 3, 3), in the shape's frame [m]


@dataclass(frozen=True)
class Style:
    """The parts of a flight that are drawn beside its bodies."""

    trail: float = 2.0  # length of trails [s]; 0: none
    trail_value: str = "speed"  # colours trails: `speed`, `error` or empty: one colour a robot
    thrust: bool = False  # arrows of the rotors' thrust
    goal: bool = True
    ghost: Color | None = None  # all bodies in this colour, without the world


class Scene:
    """Shapes of a flight at any time."""

    def __init__(self, flight: Flight, style: Style = Style()) -> None:
        self.flight, self.style = flight, style
        compiled = flight.compiled
        self._rotors = compiled.rotors
        self._couplings = compiled.couplings
        self._bodies = [fixed_to_body(visual) for visual in compiled.visuals]
        self._obstacles = [] if style.ghost else list(standing(flight))
        self._radii = blade_radii(self._rotors)
        self.robots = robots_of(flight)
        self._colors = colors(len(self.robots))
        self.triangles = sum(s.mesh.count for s in (*self._bodies, *self._obstacles) if s.mesh)
        self._marks = speeds(flight) if style.trail_value == "speed" else errors(flight)

    @property
    def most(self) -> int:
        """An upper bound of the number of shapes."""
        moving = len(self._bodies) + 5 * len(self._rotors) + 32 * len(self._couplings)
        return moving + len(self._obstacles) + 1 + len(self.robots) * (2 * TRAIL_PARTS + 8)

    def center(self, time: float) -> Array:
        """Middle of the box about all bodies, W [m]."""
        position, _ = self.flight.at(time)
        return np.asarray(0.5 * (position.min(axis=0) + position.max(axis=0)))

    def points(self) -> Array:
        """Points about all bodies, goals and near obstacles of the flight, (n, 3), W [m]."""
        rows = np.unique(np.linspace(0, len(self.flight.time) - 1, MOST_ROWS).astype(int))
        bodies = self.flight.bodies[rows, :, :3].reshape(-1, 3)
        places = [bodies + self.size() * sign * axis for axis in IDENTITY for sign in (-1.0, 1.0)]
        places += [goal[rows, :3] for goal in self.flight.goals.values()]
        near = np.concatenate(places)
        near = near[np.isfinite(near).all(axis=1)]
        low, high = near.min(axis=0), near.max(axis=0)
        margin = 0.3 * float((high - low).max())
        for shape in self._obstacles:
            corners = np.clip(corners_of(shape), low - margin, high + margin)
            if shape.kind != GROUND and np.ptp(corners, axis=0).all():
                near = np.concatenate([near, corners])
        return near

    def size(self) -> float:
        """Radius of the largest robot [m]."""
        reach = [float(np.linalg.norm(r.position)) + self._radii[r.name] for r in self._rotors]
        half = [float(np.max(s.half)) + float(np.linalg.norm(s.position)) for s in self._bodies]
        return max([*reach, *half, 0.05])

    def add_to(self, shapes: Shapes, time: float) -> None:
        """Adds all shapes at a time since the reset [s]."""
        position, axes = self.flight.at(time)
        if not self.style.ghost:
            shapes.add(GROUND, np.zeros(3), IDENTITY, (0, 0, 0), FLOOR[0], checker=(FLOOR[1], 1.0))
        for shape in self._obstacles:
            add_fixed(shapes, shape, position, axes, None)
        self.add_robots(shapes, time)
        self._add_trails(shapes, time, position)
        self._add_goals(shapes, time)

    def add_robots(self, shapes: Shapes, time: float) -> None:
        """Adds bodies, rotors and couplings alone, at a time since the reset [s]."""
        position, axes = self.flight.at(time)
        for shape in self._bodies:
            add_fixed(shapes, shape, position, axes, self.style.ghost)
        self._add_rotors(shapes, time, position, axes)
        self._add_couplings(shapes, position, axes)

    # --- parts ----------------------------------------------------------------------------------

    def _add_rotors(self, shapes: Shapes, time: float, position: Array, axes: Array) -> None:
        speeds_now = row_at(self.flight, self.flight.rotor_speed, time)
        for k, rotor in enumerate(self._rotors):
            radius = self._radii[rotor.name]
            z = axes[rotor.body] @ np.array(rotor.axis)
            hub = position[rotor.body] + axes[rotor.body] @ np.array(rotor.position)
            frame = towards(z)
            turn = blade_angle(self.flight, k, time) * rotor.direction
            c, s = np.cos(turn), np.sin(turn)
            spun = frame @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            color = self.style.ghost or BLADE
            half = (radius, 0.09 * radius, 0.012 * radius + 1e-4)
            shapes.add(BOX, hub + 0.006 * z, spun, half, color, shadow=False)
            shapes.add(CYLINDER, hub, frame, (0.13 * radius, 0.13 * radius, 0.1 * radius), color)
            if self.style.thrust and k < len(speeds_now):
                force = rotor.thrust_constant * speeds_now[k] ** 2
                tip = hub + z * force * ARROW
                shapes.add_line(hub, tip, 0.05 * radius, THRUST, shadow=False)

    def _add_couplings(self, shapes: Shapes, position: Array, axes: Array) -> None:
        for points in lines_of_couplings(self.flight, position, axes).values():
            for a, b in pairwise(points):
                shapes.add_line(a, b, 0.006, self.style.ghost or ROPE, shadow=True)

    def _add_trails(self, shapes: Shapes, time: float, position: Array) -> None:
        if self.style.trail <= 0.0:
            return
        times = self.flight.time
        first, last = np.searchsorted(times, [time - self.style.trail, time])
        rows = np.unique(np.linspace(first, max(last - 1, first), TRAIL_PARTS).astype(int))
        for k, (body, _) in enumerate(self.robots.values()):
            points = [*self.flight.bodies[rows, body, :3], position[body]]
            for n, (a, b) in enumerate(pairwise(points)):
                color = self.style.ghost or self._trail_color(k, rows[min(n, len(rows) - 1)])
                radius = 0.05 * self.size() * (0.3 + 0.7 * (n + 1) / len(points))
                shapes.add_line(a, b, radius, color, shadow=False)

    def _trail_color(self, robot: int, row: int) -> Color:
        if not self.style.trail_value or robot >= self._marks.shape[1]:
            return self._colors[robot]
        most = max(float(np.nanmax(self._marks)), 1e-9)
        return blend(float(self._marks[row, robot]) / most)

    def _add_goals(self, shapes: Shapes, time: float) -> None:
        for goal in self.flight.goals.values() if self.style.goal else ():
            place = row_at(self.flight, goal, time)[:3]
            if not np.isfinite(place).all():
                continue
            arm = 0.3 * self.size()
            for axis in IDENTITY:
                shapes.add_line(
                    place - arm * axis, place + arm * axis, 0.03 * arm, GOAL, shadow=False
                )


ARROW = 0.03  # length of arrows of thrust [m/N]
TRAIL_PARTS = 60  # of each robot's trail
MOST_ROWS = 400  # of a flight that Scene.points() takes
BLADES_SHOWN = 0.04  # speed of drawn blades over that of the rotors: else they seem to stand


def blend(share: float) -> Color:
    """From blue (0) over green and yellow to red (1)."""
    stops = np.array(
        [[0.13, 0.35, 0.85], [0.12, 0.68, 0.55], [0.95, 0.80, 0.15], [0.90, 0.18, 0.12]]
    )
    at = float(np.clip(share, 0.0, 1.0)) * (len(stops) - 1)
    k = min(int(at), len(stops) - 2)
    red, green, blue = stops[k] + (at - k) * (stops[k + 1] - stops[k])
    return float(red), float(green), float(blue)


def row_at(flight: Flight, values: Array, time: float) -> Array:
    """The values of the last row that is not after a time."""
    row = int(np.searchsorted(flight.time, time, side="right")) - 1
    return np.asarray(values[max(row, 0)])


def blade_angle(flight: Flight, rotor: int, time: float) -> float:
    """Angle of a drawn blade [rad], from the recorded speeds."""
    speed = flight.rotor_speed
    if rotor >= speed.shape[1]:
        return 0.0
    row = int(np.clip(np.searchsorted(flight.time, time) - 1, 0, len(speed) - 1))
    past = float(np.sum(speed[:row, rotor] * np.diff(flight.time[: row + 1])))
    angle = past + float(speed[row, rotor]) * (time - float(flight.time[row]))
    return BLADES_SHOWN * angle + rotor


def blade_radii(rotors: Sequence[Rotor]) -> dict[str, float]:
    """Radius of each rotor's drawn blades [m]: rotors of a robot do not meet."""
    radii = {}
    for rotor in rotors:
        robot = rotor.name.split(".")[0]
        apart = [
            np.linalg.norm(np.array(other.position) - np.array(rotor.position))
            for other in rotors
            if other is not rotor and other.name.split(".")[0] == robot and other.body == rotor.body
        ]
        near = [distance for distance in apart if distance > 0.02]
        radii[rotor.name] = 0.42 * float(min(near)) if near else 0.12
    return radii


def robots_of(flight: Flight) -> dict[str, tuple[int, int]]:
    """First body and number of bodies of each robot with a name."""
    robots: dict[str, tuple[int, int]] = {}
    for k, name in enumerate(flight.body_names):
        robot = name.split(".")[0]
        first, count = robots.get(robot, (k, 0))
        robots[robot] = (first, count + 1)
    return robots


def speeds(flight: Flight) -> Array:
    """Speed of each robot's base [m/s], rows x robots."""
    bases = [first for first, _ in robots_of(flight).values()]
    return np.asarray(np.linalg.norm(flight.bodies[:, bases, 7:10], axis=-1))


def errors(flight: Flight) -> Array:
    """Distance of each robot's base from its goal [m], rows x robots; 0 without a goal."""
    columns = []
    for first, _ in robots_of(flight).values():
        goal = flight.goals.get(flight.body_names[first])
        place = flight.bodies[:, first, :3]
        columns.append(
            np.zeros(len(place)) if goal is None else np.linalg.norm(place - goal[:, :3], axis=1)
        )
    return np.stack(columns, axis=1)


# --- shapes of the scenario ---------------------------------------------------------------------


def half_of(kind: int, size: Sequence[float]) -> tuple[float, float, float]:
    """Half sizes as the renderer takes them, from those of a Shape."""
    if kind == BOX:
        return 0.5 * size[0], 0.5 * size[1], 0.5 * size[2]
    if kind == SPHERE:
        return size[0], size[0], size[0]
    if kind in (CYLINDER, CAPSULE):
        return size[0], size[0], 0.5 * size[1]
    return 0.0, 0.0, 0.0


def fixed_to_body(visual: Visual) -> Fixed:
    """A shape of a body."""
    kind = KINDS[visual.kind]
    scale = np.array(visual.size)
    mesh = Mesh(visual.corners, scale) if kind == MESH else None
    corners = visual.corners * scale if kind == MESH else None
    red, green, blue, _ = visual.color
    axes = rotation_of(np.array(visual.rotation))
    half = half_of(kind, visual.size)
    place = np.array(visual.position)
    return Fixed(kind, visual.body, place, axes, half, (red, green, blue), mesh, corners)


def standing(flight: Flight) -> list[Fixed]:
    """The obstacles as drawn in the flight's episode; of gates the bars."""
    found: list[Fixed] = []
    for shape in flight.compiled.obstacles:
        path = f"obstacles.{shape.name}."
        drawn = flight.drawn
        if not drawn.get(path + "present", 1.0):
            continue
        position = np.array(
            [drawn.get(f"{path}position[{k}]", shape.position[k]) for k in range(3)]
        )
        turn = np.array([drawn.get(f"{path}rotation[{k}]", shape.rotation[k]) for k in range(4)])
        size = [drawn.get(f"{path}size[{k}]", value) for k, value in enumerate(shape.size)]
        found += of_obstacle(flight, shape, position, rotation_of(turn), size)
    return found


def of_obstacle(
    flight: Flight, shape: Shape, position: Array, axes: Array, size: list[float]
) -> list[Fixed]:
    """The shapes of an obstacle in W."""
    color = OBSTACLES.get(shape.kind, STONE)
    if shape.kind == "gate":
        width, height, bar = size
        aside, above = 0.5 * (width + bar), 0.5 * (height + bar)
        posts = [((0.0, s * aside, 0.0), (bar, bar, height + 2 * bar)) for s in (1, -1)]
        beams = [((0.0, 0.0, s * above), (bar, width, bar)) for s in (1, -1)]
        return [
            Fixed(BOX, -1, position + axes @ np.array(at), axes, half_of(BOX, edges), color)
            for at, edges in posts + beams
        ]
    if shape.kind == "height_field":
        corners = flight.compiled.height_field_corners(shape.obstacle)
        mesh = Mesh(corners, np.ones(3))
        return [Fixed(MESH, -1, position, axes, (0.0, 0.0, 0.0), GRASS, mesh, corners)]
    kind = KINDS[shape.kind]
    return [Fixed(kind, -1, position, axes, half_of(kind, size), color)]


def corners_of(shape: Fixed) -> Array:
    """Corners of a box about a shape in its frame: of a body, or W [m]."""
    if shape.corners is not None:
        flat = shape.corners.reshape(-1, 3)
        return np.asarray(shape.position + flat @ shape.axes.T)
    half = np.array(shape.half) + (shape.kind == CAPSULE) * np.array([0.0, 0.0, shape.half[0]])
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    return np.asarray(shape.position + (signs * half) @ shape.axes.T)


def add_fixed(
    shapes: Shapes, shape: Fixed, position: Array, axes: Array, color: Color | None
) -> None:
    """Adds a shape at its body's pose."""
    place, turn = shape.position, shape.axes
    if shape.body >= 0:
        place = position[shape.body] + axes[shape.body] @ place
        turn = axes[shape.body] @ turn
    shapes.add(shape.kind, place, turn, shape.half, color or shape.color, mesh=shape.mesh)


def lines_of_couplings(flight: Flight, position: Array, axes: Array) -> dict[str, list[Array]]:
    """Rods, springs and ropes as lines.

    Args:
        flight: the flight.
        position: of all bodies, (bodies, 3), W [m].
        axes: of all bodies, (bodies, 3, 3), W from B.

    Returns:
        Points of each coupling by its name, W [m]; couplings that are absent are left out.
    """
    found = {}
    for coupling in flight.compiled.couplings:
        path = f"couplings.{coupling.name}."
        if not flight.drawn.get(path + "present", 1.0) or coupling.kind == "point":
            continue
        ends = [
            np.array(point) if body < 0 else position[body] + axes[body] @ np.array(point)
            for body, point in zip(coupling.bodies, coupling.points, strict=True)
        ]
        length = flight.drawn.get(path + "length", 0.0)
        found[coupling.name] = (
            sagging(ends[0], ends[1], length) if coupling.kind == "rope" else ends
        )
    return found


def sagging(a: Array, b: Array, length: float) -> list[Array]:
    """Points of a rope between its ends: straight if taut, else a parabola of its length."""
    if length <= float(np.linalg.norm(b - a)) * (1.0 + 1e-4):
        return [a, b]
    shares = np.linspace(0.0, 1.0, 17)[:, None]
    straight, below = a + shares * (b - a), 4.0 * shares * (1.0 - shares) * np.array([0, 0, -1.0])
    low, high = 0.0, length  # of the sag [m]
    for _ in range(30):
        sag = 0.5 * (low + high)
        drawn = np.linalg.norm(np.diff(straight + sag * below, axis=0), axis=1).sum()
        low, high = (sag, high) if drawn < length else (low, sag)
    return list(straight + low * below)
