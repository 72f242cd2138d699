"""Hard cases of motion and contact: each simulates one and returns its error.

hard_physics.py makes their page.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import skybody
from numpy.typing import NDArray

Array = NDArray[np.float64]
GRAVITY = 9.81  # [m/s^2]
DAMPING = 4.5  # 1.5 times the default dissipation: d of the contact law [s/m]
FLOATING = "gravity: [0, 0, 0]\ncontact: {ground: false}\n"


@dataclass(frozen=True)
class Solid:
    """A free body of one shape, with its inertia about its axes."""

    mass: float  # [kg]
    inertia: tuple[float, float, float]  # [kg m^2]
    shape: str  # of URDF's <geometry>

    def urdf(self) -> str:
        """The body as a robot with one link."""
        xx, yy, zz = self.inertia
        return (
            f'<robot name="solid"><link name="base_link"><inertial><mass value="{self.mass}"/>'
            f'<inertia ixx="{xx}" ixy="0" ixz="0" iyy="{yy}" iyz="0" izz="{zz}"/></inertial>'
            f"<collision><geometry>{self.shape}</geometry></collision></link></robot>"
        )


def box(mass: float, x: float, y: float, z: float) -> Solid:
    """A homogeneous box; lengths of its sides [m]."""
    square = mass / 12.0 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    return Solid(mass, tuple(square), f'<box size="{x} {y} {z}"/>')


PLATE = Solid(1.5, (0.014, 0.0165, 0.0288), '<box size="0.3 0.3 0.05"/>')
STICK = Solid(0.05, (3.75e-4, 3.75e-4, 8.3e-7), '<capsule radius="0.005" length="0.29"/>')
CUBE = box(1.0, 0.2, 0.2, 0.2)
BRICK = box(1.0, 0.3, 0.2, 0.1)


class World:
    """One or more bodies, in a separate folder."""

    def __init__(self, folder: Path, solids: list[Solid], dt: float, more: str = "") -> None:
        self.solids = solids
        text = f"name: hard\nstepping: {{dt: {dt}}}\n{more}robots:\n"
        for i, solid in enumerate(solids):
            model = folder / f"solid_{i}.urdf"
            model.write_text(solid.urdf())
            text += f"  - {{name: r{i}, model: {model}, rotors: none, controllers: [],"
            text += f" pose: {{position: [0, 0, {5 + i}]}}}}\n"
        text += "task: {plugin: watch, parameters: {robot: r0, link: base_link}}\n"
        scenario = folder / "hard.yaml"
        scenario.write_text(text)
        self.sim = skybody.Simulation(str(scenario))
        self.sim.reset()

    def put(
        self, position: Array, rotation: Array, velocity: Array, spin: Array, robot: str = "r0"
    ) -> None:
        """Sets pose and motion of a body: W; quaternion w x y z; angular velocity in body axes."""
        unit = rotation / np.linalg.norm(rotation)
        parts = (position, unit, velocity, spin)
        self.sim.teleport(*(np.asarray(part, float).tolist() for part in parts), robot=robot)

    def energy(self, gravity: float = GRAVITY) -> float:
        """Energy of all bodies [J]."""
        total = 0.0
        for i, solid in enumerate(self.solids):
            base = self.sim.base(f"r{i}")
            spin, velocity = np.array(base.angular_velocity), np.array(base.velocity)
            total += 0.5 * solid.mass * float(velocity @ velocity)
            total += 0.5 * float(spin * np.array(solid.inertia) @ spin)
            total += solid.mass * gravity * base.position[2]
        return total

    def fly(self, seconds: float, dt: float, every: float = 0.0) -> Iterator[bool]:
        """Advances; yields after each step, or at times `every` apart [s]; False: a fault."""
        steps = max(1, round(every / dt))
        for _ in range(round(seconds / dt / steps)):
            went = self.sim.advance(steps)
            yield went
            if not went:
                return


NONE = np.zeros(3)
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


def free_spin(folder: Path, dt: float, spin: float, seconds: float) -> float:
    """The largest change of energy, relative to its initial value."""
    world = World(folder, [PLATE], dt, FLOATING)
    way = np.array([0.3, 1.0, 0.2])
    world.put(np.array([0, 0, 50.0]), UPRIGHT, NONE, spin * way / np.linalg.norm(way))
    start = world.energy(0.0)
    worst = 0.0
    for went in world.fly(seconds, dt, 0.1):
        worst = max(worst, abs(world.energy(0.0) / start - 1.0)) if went else math.inf
    return worst


def thrown_stick(folder: Path, dt: float) -> float:
    """The largest energy of a stick that the ground spins up, relative to its initial value."""
    world = World(folder, [STICK], dt)
    rotation = np.array([0.7071, 0.01, 0.7271, 0.01])
    world.put(np.array([0, 0, 0.02]), rotation, np.array([0, 10.0, -2.0]), NONE)
    start = world.energy()
    worst = 0.0
    for went in world.fly(0.6, dt):
        worst = max(worst, world.energy() / start) if went else math.inf
    return worst


WALL = FLOATING + "obstacles: [{name: wall, box: [0.02, 4, 4], position: [0, 0, 0]}]\n"


def sticks_at_a_wall(folder: Path, dt: float, throws: int) -> float:
    """Number of sticks at 20 to 40 m/s that gain energy, pass a wall of 20 mm, or fault."""
    world = World(folder, [STICK], dt, WALL)
    random = np.random.default_rng(1)
    bad = 0
    for _ in range(throws):
        world.sim.reset()
        rotation, speed = random.normal(size=4), random.uniform(20.0, 40.0)
        spin = random.normal(size=3) * random.uniform(0.0, 20.0)
        way = np.array([1.0, 0.3 * random.normal(), 0.3 * random.normal()])
        velocity = speed * way / np.linalg.norm(way)
        world.put(np.array([-0.4, 0, 0]), rotation, velocity, spin)
        start = world.energy(0.0)
        gains = any(not went or world.energy(0.0) > 1.001 * start for went in world.fly(0.15, dt))
        bad += gains or world.sim.base("r0").position[0] > 0.3
    return bad


def law_rebound(speed: float) -> float:
    """Rebound speed by the contact law: m v dv = -f dx, integrated numerically [m/s]."""

    def lost(v: float) -> float:
        return v / DAMPING - math.log1p(DAMPING * v) / DAMPING**2

    low, high = 0.0, (1.0 - 1e-15) / DAMPING
    for _ in range(200):
        mid = 0.5 * (low + high)
        low, high = (mid, high) if lost(-mid) < lost(speed) else (low, mid)
    return low


def rebounds(folder: Path, dt: float, drops: int) -> float:
    """The largest relative error of a cube's rebound at 1 to 11 m/s against the law."""
    world = World(folder, [CUBE], dt, "gravity: [0, 0, 0]\n")
    worst = 0.0
    for k in range(drops):
        speed = 1.0 + 10.0 * k / drops
        world.sim.reset()
        world.put(
            np.array([0, 0, 0.1 + 0.37 * speed * dt * k]), UPRIGHT, np.array([0, 0, -speed]), NONE
        )
        went = world.sim.advance(round(0.5 / dt) + 16 * drops)
        up = world.sim.base("r0").velocity[2] if went else math.inf
        worst = max(worst, abs(up / law_rebound(speed) - 1.0))
    return worst


def deep_cube(folder: Path, dt: float, depth: float) -> float:
    """Speed at which a cube leaves the ground; by the law at most 0.22 m/s [m/s]."""
    world = World(folder, [CUBE], dt)
    world.put(np.array([0, 0, 0.1 - depth]), UPRIGHT, NONE, NONE)
    most = 0.0
    for went in world.fly(8.0, dt):
        most = max(most, world.sim.base("r0").velocity[2]) if went else math.inf
    return most


def overlapping(folder: Path, dt: float) -> float:
    """The larger speed of two cubes that overlap at the start [m/s]."""
    world = World(folder, [CUBE, CUBE], dt, "gravity: [0, 0, 0]\ncontact: {redraws: 0}\n")
    world.put(np.array([0, 0, 5.0]), UPRIGHT, NONE, NONE)
    world.put(np.array([0.05, 0.01, 5.02]), UPRIGHT, NONE, NONE, "r1")
    most = 0.0
    for went in world.fly(2.0, dt):
        speeds = [float(np.linalg.norm(world.sim.base(r).velocity)) for r in ("r0", "r1")]
        most = max(most, *speeds) if went else math.inf
    return most


def throw(world: World, random: np.random.Generator) -> None:
    """Throws a tumbling body from above the ground."""
    world.sim.reset()
    rotation = random.normal(size=4)
    height = np.array([0, 0, random.uniform(0.3, 1.0)])
    world.put(height, rotation, random.uniform(-2, 2, 3), random.uniform(-5, 5, 3))


def thrown_boxes(folder: Path, dt: float, throws: int) -> float:
    """Number of thrown boxes that still move at 1 mm/s or more after 8 s."""
    world = World(folder, [BRICK], dt)
    random = np.random.default_rng(5)
    restless = 0
    for _ in range(throws):
        throw(world, random)
        most = 0.0 if world.sim.advance(round(8.0 / dt)) else math.inf
        for went in world.fly(1.0, dt, 0.02):
            base = world.sim.base("r0")
            spin = 0.1 * float(np.linalg.norm(base.angular_velocity))
            most = max(most, float(np.linalg.norm(base.velocity)), spin) if went else math.inf
        restless += most > 1e-3
    return restless


def lossless_boxes(folder: Path, dt: float, throws: int) -> float:
    """The largest gain of energy of tumbling boxes without dissipation and friction, in 4 s."""
    world = World(folder, [BRICK], dt, "contact: {dissipation: 0, friction: 0}\n")
    random = np.random.default_rng(5)
    worst = 0.0
    for _ in range(throws):
        throw(world, random)
        start = world.energy()
        for went in world.fly(4.0, dt, 0.01):
            if not went:
                worst = math.inf
            elif not world.sim.contacts():
                worst = max(worst, world.energy() / start - 1.0)
    return worst


MODELS = Path(__file__).resolve().parents[2] / "scenarios/models"


def on_its_side(folder: Path, dt: float, model: str) -> float:
    """Distance that a vehicle lying on its side creeps in a minute [mm]."""
    scenario = folder / "side.yaml"
    scenario.write_text(
        f"name: side\nstepping: {{dt: {dt}}}\nrobots:\n"
        f"  - {{name: r0, model: {MODELS}/{model}/{model}.urdf,"
        " controllers: [{plugin: rotor_speed}]}\n"
        "task: {plugin: watch, parameters: {link: base_link}}\n"
    )
    sim = skybody.Simulation(str(scenario))
    sim.reset()
    roll = math.pi / 2
    sim.teleport([0, 0, 0.3], [math.cos(roll / 2), math.sin(roll / 2), 0, 0], [0] * 3, [0] * 3)
    if not sim.advance(round(5.0 / dt)):
        return math.inf
    start = np.array(sim.base("r0").position)
    if not sim.advance(round(60.0 / dt)):
        return math.inf
    return 1e3 * float(np.linalg.norm(np.array(sim.base("r0").position) - start))


ELBOW = (0.0, 2.5)  # its limits in firefly_arm.urdf [rad]


def elbow_stop(folder: Path, dt: float) -> float:
    """Distance by which firefly_arm's elbow, at 15 rad/s, passes its stop [rad]."""
    scenario = folder / "arm.yaml"
    scenario.write_text(
        f"name: arm\nstepping: {{dt: {dt}}}\ngravity: [0, 0, -9.81]\nrobots:\n"
        f"  - {{name: r0, model: {MODELS}/firefly_arm/firefly_arm.urdf,"
        " pose: {position: [0, 0, 30]}, controllers: [{plugin: rotor_speed}]}\n"
        "task: {plugin: watch, parameters: {robot: r0, link: base_link}}\n"
    )
    sim = skybody.Simulation(str(scenario))
    sim.set_param("robots.r0.start.joints.elbow.velocity", 15.0)
    sim.reset()
    low, high = ELBOW
    for _ in range(round(2.0 / dt)):
        if not sim.advance(1):
            return math.inf
        angle = float(np.ravel(sim.state("robots.r0.joints.elbow.position"))[0])
        low, high = min(low, angle), max(high, angle)
    return max(ELBOW[0] - low, high - ELBOW[1])


@dataclass(frozen=True)
class Case:
    """One row of the table."""

    name: str
    form: str  # format of its figures
    wanted: str
    run: Callable[[Path, float], float]


def steps(quick: bool) -> tuple[float, ...]:
    """The time steps [s]."""
    return (0.001, 0.004) if quick else (0.00025, 0.001, 0.002, 0.004)


def measured(quick: bool) -> dict[str, list[float]]:
    """The figure of each case at each time step."""
    found: dict[str, list[float]] = {}
    for case in cases(quick):
        found[case.name] = []
        for dt in steps(quick):
            with tempfile.TemporaryDirectory() as folder:
                found[case.name].append(float(case.run(Path(folder), dt)))
        print(case.name, found[case.name], file=sys.stderr, flush=True)
    return found


def cases(quick: bool) -> list[Case]:
    """All cases; `quick`: with few throws, and short spins."""
    tries, seconds = (2, 1.0) if quick else (128, 60.0)

    def spin(rate: float) -> Callable[[Path, float], float]:
        return lambda folder, dt: free_spin(folder, dt, rate, seconds)

    def deep(depth: float) -> Callable[[Path, float], float]:
        return lambda folder, dt: deep_cube(folder, dt, depth)

    def of(run: Callable[[Path, float, int], float]) -> Callable[[Path, float], float]:
        return lambda folder, dt: run(folder, dt, tries)

    def side(model: str) -> Callable[[Path, float], float]:
        return lambda folder, dt: on_its_side(folder, dt, model)

    return [
        Case(f"free spin of 100 rad/s, {seconds:g} s: change of energy", ".1e", "0", spin(100.0)),
        Case(f"free spin of 500 rad/s, {seconds:g} s: change of energy", ".1e", "0", spin(500.0)),
        Case("stick that the ground spins up: energy, of the start's", ".3g", "<= 1", thrown_stick),
        Case(
            f"sticks at a wall of 20 mm: faults, gains, passes of {tries}",
            ".0f",
            "0",
            of(sticks_at_a_wall),
        ),
        Case("rebound of a cube at 1 to 11 m/s: error", ".1%", "<= 5 %", of(rebounds)),
        *(
            Case(
                f"cube {1e3 * depth:g} mm in the ground: leaves at [m/s]",
                ".3f",
                "<= 0.222",
                deep(depth),
            )
            for depth in (0.009, 0.05, 1.0)
        ),
        Case("cubes that overlap: fly apart at [m/s]", ".3f", "<= 0.222", overlapping),
        Case(f"thrown boxes: not at rest after 8 s, of {tries}", ".0f", "0", of(thrown_boxes)),
        *(
            Case(f"{model} on its side: walks in a minute [mm]", ".2f", "0", side(model))
            for model in ("qdrone2", "firefly")
        ),
        Case("firefly_arm's elbow at 15 rad/s: past its stop [rad]", ".3f", "0", elbow_stop),
        Case(
            "boxes without dissipation and friction, 4 s: gain of energy",
            ".2%",
            "<= 0",
            of(lossless_boxes),
        ),
    ]
