"""The world of a flight as shapes to draw: vehicles, obstacles, couplings, goals, trails."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from skybody import CompiledScenario
from skybody._native import Mesh, Rotor, Shape, Visual

from .contacts import Contacts
from .couplings import PARTS, Couplings
from .couplings import ROPE as ROPE
from .fixtures import Fixed as Fixed
from .fixtures import Fixtures, corners_of
from .lines import Lines
from .motion import Array, Motion, rotation_of
from .palette import colors
from .rotors import ARROW as ARROW
from .rotors import BLADE as BLADE
from .rotors import BLADES_SHOWN as BLADES_SHOWN
from .rotors import Rotors
from .shapes import BOX, CAPSULE, CYLINDER, GROUND, IDENTITY, MESH, SPHERE, Color, Shapes
from .trails import Paths, Trails, add_goals, breaks, distances

if TYPE_CHECKING:  # it needs h5py
    from .flight import Flight

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
MOST_ROWS = 400  # of a flight that Scene.points() takes
FLOOR_SHAPE = Fixed(
    GROUND, -1, np.zeros(3), IDENTITY, (0.0, 0.0, 0.0), FLOOR[0], checker=(FLOOR[1], 1.0)
)


@dataclass(frozen=True)
class Style:
    """The parts of a flight that are drawn beside its bodies."""

    trail: float = 2.0  # length of trails [s]; 0: none
    trail_value: str = "speed"  # colours trails: `speed`, `error` or empty: one colour a robot
    thrust: bool = False  # lines of the rotors' thrust
    goal: bool = True
    reference: bool = True  # the whole path of goals that move
    contacts: bool = True  # flashes where something touches
    ghost: Color | None = None  # all bodies in this colour, without the world


class Scene:
    """Shapes and lines of a flight at any time."""

    def __init__(self, flight: Motion, style: Style = Style()) -> None:
        """Prepares them.

        Args:
            flight: a log's, or any other motion.
        """
        self.flight, self.style = flight, style
        compiled, ghost = flight.compiled, style.ghost
        self.rotors = compiled.rotors
        self.radii = blade_radii(self.rotors)  # of the drawn blades, by the rotors' names [m]
        self.couplings = Couplings(flight, ghost)
        self.bodies = [fixed_to_body(visual) for visual in compiled.visuals]
        self.obstacles = [] if ghost else standing(compiled, flight.drawn)
        self.robots = robots_of(flight)
        self.triangles = sum(s.mesh.count for s in (*self.bodies, *self.obstacles) if s.mesh)
        self._moving = Fixtures(self.bodies, ghost)
        self._standing = Fixtures([] if ghost else [FLOOR_SHAPE, *self.obstacles]).block
        self._turning = Rotors(self.rotors, self.radii, ghost)
        self._parts = parts_of(self)

    @property
    def most(self) -> int:
        """An upper bound of the number of shapes."""
        moving = len(self.bodies) + 2 * len(self.rotors) + PARTS * len(self.couplings.names)
        return moving + len(self.obstacles) + 1

    def points(self) -> Array:
        """Points about all bodies, near obstacles and goals that do not jump, (n, 3), W [m]."""
        seen = self.flight.overview
        rows = np.unique(np.linspace(0, len(seen.time) - 1, MOST_ROWS).astype(int))
        states = seen.bodies[rows]
        places = [self.places(states[..., :3], states[..., 3:7]).reshape(-1, 3)]
        goals = [goal[:, :3] for goal in seen.goals.values()]
        places += [goal[rows] for goal in goals if not breaks(goal)[1:].any()]
        near = np.concatenate(places)
        near = near[np.isfinite(near).all(axis=1)]
        low, high = near.min(axis=0), near.max(axis=0)
        margin = 0.3 * float((high - low).max())
        for shape in self.obstacles:
            corners = np.clip(corners_of(shape), low - margin, high + margin)
            if shape.kind != GROUND and np.ptp(corners, axis=0).all():
                near = np.concatenate([near, corners])
        return near

    def size(self) -> float:
        """Radius of the largest robot [m]."""
        return float(max(self.extents.max(initial=0.0), 0.05))

    def places(self, position: Array, quaternion: Array) -> Array:
        """Corners of boxes about all bodies, (..., bodies, 8, 3), W [m].

        Args:
            position, quaternion: of all bodies, (..., bodies, 3), W [m], and (..., bodies, 4).
        """
        turned = np.einsum("...bij,bkj->...bki", rotation_of(quaternion), self.outlines)
        return np.asarray(position[..., None, :] + turned)

    @cached_property
    def outlines(self) -> Array:
        """Corners of a box about each body's shapes in its frame, (bodies, 8, 3) [m]."""
        points: list[list[Array]] = [[np.zeros((1, 3))] for _ in self.flight.body_names]
        for rotor in self.rotors:
            tips = self.radii[rotor.name] * np.concatenate([IDENTITY, -IDENTITY])
            level = tips - np.outer(tips @ np.array(rotor.axis), rotor.axis)
            points[rotor.body].append(np.array(rotor.position) + level)
        for shape in self.bodies:
            points[shape.body].append(corners_of(shape))
        boxes = [(np.min(p, axis=0), np.max(p, axis=0)) for p in map(np.concatenate, points)]
        return np.array([np.array(list(product(*zip(*box, strict=True)))) for box in boxes])

    @cached_property
    def extents(self) -> Array:
        """Distance of each body's shapes from its origin [m]."""
        return np.asarray(np.linalg.norm(self.outlines, axis=-1).max(axis=-1))

    def add_to(self, shapes: Shapes, time: float) -> None:
        """Adds all shapes and lines at a time since the reset [s]."""
        shapes.add(self._standing)
        self.add_robots(shapes, time)
        for add in self._parts:
            add(shapes.lines, time)

    def add_robots(self, shapes: Shapes, time: float, names: Collection[str] | None = None) -> None:
        """Adds bodies, rotors and couplings alone.

        Args:
            time: since the reset [s].
            names: robots whose bodies are drawn; None: all.
        """
        position, axes = self.flight.at(time)
        moving = self._moving
        if names is not None:
            of = self.flight.body_names
            named = [s for s in self.bodies if of[s.body].split(".")[0] in names]
            moving = Fixtures(named, self.style.ghost)
        shapes.add(moving.at(position, axes))
        shapes.add(*self._turning.at(position, axes, self.flight.turns(time)))
        shapes.add(*self.couplings.at(position, axes))

    def add_thrusts(self, lines: Lines, time: float) -> None:
        """Adds the rotors' thrusts at a time since the reset [s]."""
        speeds = self.flight.rotor_speed_at(time)
        if len(speeds) == len(self.rotors):
            self._turning.add_thrusts(lines, *self.flight.at(time), speeds)


def parts_of(scene: Scene) -> list[Callable[[Lines, float], None]]:
    """Functions that add the lines that a scene's style wants, at a time [s]."""
    flight, style = scene.flight, scene.style
    found: list[Callable[[Lines, float], None]] = []
    if style.reference:
        found.append(Paths(flight, style.ghost).add)
    if style.trail > 0.0:
        bases = [first for first, _ in scene.robots.values()]
        tints = [style.ghost] * len(bases) if style.ghost else colors(len(bases))
        value = "" if style.ghost else style.trail_value
        found.append(Trails(flight, bases, style.trail, value, tints).add)
    if style.goal:
        size = scene.size()
        found.append(lambda lines, t: add_goals(lines, flight.goals_at(t), size, style.ghost))
    if style.thrust:
        found.append(scene.add_thrusts)
    if style.contacts:
        found.append(Contacts(flight, scene.bodies, scene.obstacles, scene.size()).add)
    return found


def blade_radii(rotors: Sequence[Rotor]) -> dict[str, float]:
    """Radius of each rotor's drawn blades [m]: rotors of a robot do not meet."""
    radii = {}
    for rotor in rotors:
        robot = rotor.name.split(".")[0]
        apart = [
            np.cross(np.subtract(other.position, rotor.position), rotor.axis)
            for other in rotors
            if other is not rotor and other.name.split(".")[0] == robot and other.body == rotor.body
        ]  # besides one on the same shaft
        near = [distance for way in apart if (distance := np.linalg.norm(way)) > 0.02]
        radii[rotor.name] = 0.42 * float(min(near)) if near else 0.12
    return radii


def robots_of(flight: Motion) -> dict[str, tuple[int, int]]:
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
    bases = [first for first, _ in robots_of(flight).values()]
    return distances(flight.body_names, bases, flight.bodies, flight.goals)


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


def standing(compiled: CompiledScenario, drawn: Mapping[str, float]) -> list[Fixed]:
    """The obstacles of an episode; of gates the bars.

    Args:
        drawn: values of the episode's parameters by path.
    """
    found: list[Fixed] = []
    for shape in compiled.obstacles:
        path = f"obstacles.{shape.name}."
        if not drawn.get(path + "present", 1.0):
            continue
        position = np.array(
            [drawn.get(f"{path}position[{k}]", shape.position[k]) for k in range(3)]
        )
        turn = np.array([drawn.get(f"{path}rotation[{k}]", shape.rotation[k]) for k in range(4)])
        size = [drawn.get(f"{path}size[{k}]", value) for k, value in enumerate(shape.size)]
        found += of_obstacle(compiled, shape, position, rotation_of(turn), size)
    return found


def of_obstacle(
    compiled: CompiledScenario, shape: Shape, position: Array, axes: Array, size: list[float]
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
        corners = compiled.height_field_corners(shape.obstacle)
        mesh = Mesh(corners, np.ones(3))
        return [Fixed(MESH, -1, position, axes, (0.0, 0.0, 0.0), GRASS, mesh, corners)]
    kind = KINDS[shape.kind]
    return [Fixed(kind, -1, position, axes, half_of(kind, size), color)]


def lines_of_couplings(flight: Motion, position: Array, axes: Array) -> dict[str, list[Array]]:
    """Rods, springs and ropes as lines.

    Args:
        flight: the flight.
        position: of all bodies, (bodies, 3), W [m].
        axes: of all bodies, (bodies, 3, 3), W from B.

    Returns:
        Points of each coupling by its name, W [m]; couplings that are absent are left out.
    """
    couplings = Couplings(flight)
    lines = couplings.lines(position, axes)
    return {name: list(line) for name, line in zip(couplings.names, lines, strict=True)}
