"""Boxes without rotors as Skybody models, and the frictionless contact law of docs/contact.md
between their points and a plane, by SciPy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import skybody
from rigid_body import Reals, axes_of, quaternion_rates
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

MASS, SIZE = 1.5, np.array([0.3, 0.35, 0.2])
INERTIA = MASS / 12.0 * np.diag(np.sum(SIZE**2) - SIZE**2)
CORNERS = 0.5 * SIZE * [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
PENETRATION, DISSIPATION, FRICTION, GRAVITY = 0.001, 3.0, 0.6, 9.81  # the defaults
# Upright it stands on four corners, which sink in by PENETRATION.
STIFFNESS = MASS * GRAVITY / (4 * PENETRATION**1.5)
URDF = f"""<robot name="crate"><link name="base"><inertial><mass value="{MASS}"/>
<inertia ixx="{INERTIA[0, 0]}" ixy="0" ixz="0" iyy="{INERTIA[1, 1]}" iyz="0"
izz="{INERTIA[2, 2]}"/></inertial><collision><geometry>
<box size="{SIZE[0]} {SIZE[1]} {SIZE[2]}"/></geometry></collision></link></robot>"""


@dataclass(frozen=True)
class State:
    """State of one crate: position and velocity in W, quaternion w x y z, spin in its own axes."""

    position: Reals
    rotation: Rotation
    velocity: Reals
    spin: Reals

    def words(self) -> Reals:
        quaternion = self.rotation.as_quat()[[3, 0, 1, 2]]
        return np.concatenate([self.position, quaternion, self.velocity, self.spin])


def of_words(y: Reals) -> State:
    return State(y[:3], Rotation.from_quat(y[[4, 5, 6, 3]]), y[7:10], y[10:13])


def of_body(body: skybody.BodyState) -> State:
    words = [body.position, body.rotation, body.velocity, body.angular_velocity]
    return of_words(np.concatenate(words))


def simulation(folder: Path, names: Sequence[str], extra: str = "") -> skybody.Simulation:
    """A scenario of crates, with the YAML text `extra` appended."""
    (folder / "crate.urdf").write_text(URDF)
    robots = "".join(f"  - {{name: {name}, model: crate.urdf}}\n" for name in names)
    task = f"task: {{plugin: watch, parameters: {{robot: {names[0]}, link: base}}}}\n"
    (folder / "crates.yaml").write_text(f"name: crates\nrobots:\n{robots}{task}{extra}")
    sim = skybody.Simulation(str(folder / "crates.yaml"))
    sim.reset()
    return sim


def place(sim: skybody.Simulation, name: str, state: State) -> None:
    y = state.words()
    sim.teleport(
        position=y[:3], rotation=y[3:7], velocity=y[7:10], angular_velocity=y[10:], robot=name
    )


def push(stiffness: float, depths: Reals, deeper: Reals, dissipation: float) -> Reals:
    """Hunt and Crossley's forces [N]; `deeper`: the rates at which the depths grow."""
    damping = np.maximum(0.0, 1.0 + 1.5 * dissipation * deeper)
    return stiffness * np.maximum(depths, 0.0) ** 1.5 * damping


class Moving:
    """One crate at an instant of its flight."""

    def __init__(self, y: Reals) -> None:
        self.y, self.axes, self.spin = y, axes_of(y[3:7]), y[10:13]
        self.turning = self.axes @ self.spin  # W

    def velocities(self, arms: Reals) -> Reals:
        """Velocities of points at `arms` (W, by rows) from the centre."""
        return self.y[7:10] + np.cross(self.turning, arms)

    def rates(self, arms: Reals, forces: Reals, gravity: float) -> Reals:
        """dy/dt with forces (W, by rows) at the ends of arms."""
        moment = self.axes.T @ np.cross(arms, forces).sum(axis=0)
        own = moment - np.cross(self.spin, INERTIA @ self.spin)
        linear = forces.sum(axis=0) / MASS - [0.0, 0.0, gravity]
        turning = quaternion_rates(self.y[3:7], self.spin)
        return np.concatenate([self.y[7:10], turning, linear, own / np.diag(INERTIA)])


def fall(state: State, level: float, seconds: float) -> State:
    """The state after a fall onto a level plane."""
    up = np.array([0.0, 0.0, 1.0])

    def slope(_: float, y: Reals) -> Reals:
        crate = Moving(y)
        arms = CORNERS @ crate.axes.T
        depths = level - y[2] - arms[:, 2]
        forces = push(STIFFNESS, depths, -crate.velocities(arms)[:, 2], DISSIPATION)
        return crate.rates(arms, np.outer(forces, up), GRAVITY)

    return of_words(solve(slope, state.words(), seconds))


def collide(
    first: State, second: State, side: Reals, seconds: float, dissipation: float
) -> tuple[State, State]:
    """Corners of the first crate against one face of the second with normal `side` in its axes.

    The two contact springs act in series: two equal ones are softer by a factor of 2^1.5.
    """
    stiffness = STIFFNESS / 2.0**1.5
    reach = 0.5 * float(np.abs(side) @ SIZE)

    def slope(_: float, y: Reals) -> Reals:
        a, b = Moving(y[:13]), Moving(y[13:])
        normal = b.axes @ side
        arms = CORNERS @ a.axes.T
        others = arms + (y[:3] - y[13:16])
        closing = (b.velocities(others) - a.velocities(arms)) @ normal
        pushes = push(stiffness, reach - others @ normal, closing, dissipation)
        forces = np.outer(pushes, normal)
        return np.concatenate([a.rates(arms, forces, 0.0), b.rates(others, -forces, 0.0)])

    y = solve(slope, np.concatenate([first.words(), second.words()]), seconds)
    return of_words(y[:13]), of_words(y[13:])


def solve(slope, y: Reals, seconds: float) -> Reals:  # type: ignore[no-untyped-def]
    """DOP853 with steps small enough to resolve every contact."""
    solved = solve_ivp(
        slope, (0.0, seconds), y, method="DOP853", rtol=1e-9, atol=1e-10, max_step=2e-3
    )
    return solved.y[:, -1]


def apart(a: State, b: State) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two states."""
    angle = (a.rotation.inv() * b.rotation).magnitude()
    return float(np.linalg.norm(a.position - b.position)), float(angle)
