"""Reaction of a vehicle to its moving arm: conservation of momentum, and the equations by SciPy.

Maximal coordinates: Newton and Euler equations for each body, with the hinges' forces and moments
as unknowns and constraints on the accelerations of both ends of a hinge. The engine uses joint
coordinates of a tree.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import skybody
from rigid_body import GRAVITY, Reals, angle_between, axes_of, numbers, quaternion_rates
from scipy.integrate import solve_ivp

MODEL = Path(__file__).resolve().parents[2] / "scenarios/models/firefly_arm/firefly_arm.urdf"
LINKS = (
    "base_link",
    "upper_arm",
    "forearm",
)  # each link but the first begins at its hinge, about y
HINGES = ("shoulder", "elbow")
SIZE = 13  # of a body's state: position and velocity (W) of its origin, quaternion, spin (body)
STIFFNESS, DAMPING, EFFORT = 20.0, 0.8, 1.0
START = (-0.5, 1.0)  # of the hinges [rad]
HOLD = 0.05  # duration of a command [s]
COMMANDS = np.array([[-1.2, 2.0], [0.9, 0.4], [0.2, 2.2], [-0.8, 0.6], [1.1, 1.5], [-0.3, 0.9]])
AXIS = np.array([0.0, 1.0, 0.0])
ACROSS = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # axes about which a hinge does not rotate


@dataclass(frozen=True)
class Part:
    """One rigid body: the vehicle or a link of the arm, with the parts fixed to it. SI units."""

    mass: float
    com: Reals
    inertia: Reals  # (3, 3) about the centre of mass
    hinge: Reals  # in the frame of the preceding body


def read_parts() -> list[Part]:
    """No fixed joint of the model has a rotation."""
    robot = ElementTree.parse(MODEL).getroot()
    owner = {LINKS[0]: (0, np.zeros(3))}
    hinges = [np.zeros(3)]
    for joint in robot.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        assert parent is not None and child is not None
        place = numbers(joint.find("origin"), "xyz", "0 0 0")
        body, at = owner[parent.get("link", "")]
        if joint.get("type") == "fixed":
            owner[child.get("link", "")] = (body, at + place)
        else:
            owner[child.get("link", "")] = (len(hinges), np.zeros(3))
            hinges.append(at + place)
    pieces: list[list[tuple[float, Reals, Reals]]] = [[] for _ in hinges]
    for link in robot.findall("link"):
        inertial = link.find("inertial")
        assert inertial is not None
        mass, own = inertial.find("mass"), inertial.find("inertia")
        assert mass is not None and own is not None
        body, at = owner[link.get("name", "")]
        centre = at + numbers(inertial.find("origin"), "xyz", "0 0 0")
        moments = np.diag([float(own.get(name, "0")) for name in ("ixx", "iyy", "izz")])
        pieces[body].append((float(mass.get("value", "0")), centre, moments))
    return [together(own, hinge) for own, hinge in zip(pieces, hinges, strict=True)]


def together(pieces: list[tuple[float, Reals, Reals]], hinge: Reals) -> Part:
    mass = sum(m for m, _, _ in pieces)
    com = sum((m * c for m, c, _ in pieces), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for m, c, own in pieces:
        arm = c - com  # parallel axis theorem
        inertia += own + m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Part(mass, com, inertia, hinge)


PARTS = read_parts()


def simulation(*overrides: str, dt: float = 1e-3) -> skybody.Simulation:
    """The vehicle off the ground with stopped rotors; commands are joint positions."""
    servos = (
        f"[{{plugin: joint, parameters: {{joints: [{', '.join(HINGES)}], mode: position, "
        f"stiffness: {STIFFNESS}, damping: {DAMPING}, effort_limit: {EFFORT}}}}}]"
    )
    sim = skybody.Simulation(
        "arm",
        control=servos,
        overrides=[
            "randomization=[]",
            "contact.ground=false",
            "robots.hexa.rotor_speed=0",
            f"stepping.dt={dt}",
            *overrides,
        ],
    )
    sim.reset()
    return sim


def states(sim: skybody.Simulation) -> Reals:
    """(bodies, 13)"""
    bodies = [sim.body(link=name) for name in LINKS]
    return np.array(
        [np.concatenate([b.position, b.rotation, b.velocity, b.angular_velocity]) for b in bodies]
    )


# --- momentum -----------------------------------------------------------------------------------


def momentum(now: Reals) -> tuple[Reals, Reals, Reals]:
    """Centre of mass (W), momentum, and angular momentum about the centre of mass (W)."""
    centres, velocities, spins = [], [], []
    for part, s in zip(PARTS, now, strict=True):
        axes = axes_of(s[3:7])
        centres.append(s[:3] + axes @ part.com)
        velocities.append(s[7:10] + axes @ np.cross(s[10:], part.com))
        spins.append(axes @ part.inertia @ s[10:])
    masses = np.array([part.mass for part in PARTS])
    centre = masses @ np.array(centres) / masses.sum()
    angular = sum(spins, np.zeros(3))
    for mass, place, velocity in zip(masses, centres, velocities, strict=True):
        angular = angular + mass * np.cross(place - centre, velocity)
    return centre, masses @ np.array(velocities), angular


def momentum_error(dynamics: str, dt: float) -> tuple[float, float]:
    """Largest momentum [N s] of a swing that begins at rest, and the largest rotation [rad]."""
    sim = simulation(
        "gravity=[0,0,0]", f"stepping.dynamics={dynamics}", "stepping.integrator=rk4", dt=dt
    )
    begin, _, _ = momentum(states(sim))
    error, turned = 0.0, 0.0
    for command in COMMANDS:
        sim.command(command)
        assert sim.advance(round(HOLD / dt))
        now = states(sim)
        centre, linear, angular = momentum(now)
        # Of similar magnitude in their units: N s, N m s, and m of displacement of the centre of
        # mass.
        error = max(error, *(float(np.linalg.norm(x)) for x in (linear, angular, centre - begin)))
        turned = max(turned, angle_between(now[0, 3:7], np.array([1.0, 0.0, 0.0, 0.0])))
    return error, turned


@pytest.mark.parametrize("dynamics", ["tree", "simbody"])
def test_without_gravity_a_swinging_arm_changes_no_momentum(dynamics: str) -> None:
    coarse, _ = momentum_error(dynamics, 1e-3)
    fine, turned = momentum_error(dynamics, 2.5e-4)
    # The arm transfers 0.21 N s to the vehicle and takes it back. The integrator is of fourth
    # order: a quarter of the step divides its error by 256, or by more when a drive leaves its
    # limit.
    assert fine < 1e-8
    assert coarse / fine > 128.0
    assert turned > math.radians(5.0)  # the vehicle has rotated against the arm


# --- the equations ------------------------------------------------------------------------------


def skew(v: Reals) -> Reals:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def efforts(now: Reals, command: Reals) -> Reals:
    """Torques of both drives [N m], from the angles about y between neighbours."""
    out = []
    for k, wanted in enumerate(command):
        turn = axes_of(now[k, 3:7]).T @ axes_of(now[k + 1, 3:7])
        angle = math.atan2(turn[0, 2], turn[0, 0])
        rate = now[k + 1, 11] - now[k, 11]
        out.append(np.clip(STIFFNESS * (wanted - angle) - DAMPING * rate, -EFFORT, EFFORT))
    return np.array(out)


def rates(y: Reals, command: Reals) -> Reals:
    """dy/dt. Unknowns: each body's accelerations, and five forces and moments of each hinge."""
    now = y.reshape(-1, SIZE)
    axes = [axes_of(s[3:7]) for s in now]
    driven = efforts(now, command)
    count = len(PARTS)
    size = 6 * count + 5 * len(HINGES)
    matrix, right = np.zeros((size, size)), np.zeros(size)
    for i, (part, s) in enumerate(zip(PARTS, now, strict=True)):
        at = 6 * i  # acceleration of the centre of mass (W), angular acceleration (body axes)
        matrix[at : at + 3, at : at + 3] = part.mass * np.eye(3)
        matrix[at + 3 : at + 6, at + 3 : at + 6] = part.inertia
        right[at : at + 3] = part.mass * GRAVITY
        right[at + 3 : at + 6] = -np.cross(s[10:], part.inertia @ s[10:])
    for k, effort in enumerate(driven):
        column = 6 * count + 5 * k
        ends = ((k, 1.0, PARTS[k + 1].hinge - PARTS[k].com), (k + 1, -1.0, -PARTS[k + 1].com))
        turning = ACROSS @ axes[k].T  # rows: directions across the hinge, in W
        for i, sign, arm in ends:
            at, spin = 6 * i, now[i, 10:]
            matrix[at : at + 3, column : column + 3] += sign * np.eye(3)
            matrix[at + 3 : at + 6, column : column + 3] += sign * skew(arm) @ axes[i].T
            matrix[at + 3 : at + 6, column + 3 : column + 5] += sign * (turning @ axes[i]).T
            right[at + 3 : at + 6] -= sign * effort * AXIS
            matrix[column : column + 3, at : at + 3] += sign * np.eye(3)
            matrix[column : column + 3, at + 3 : at + 6] -= sign * axes[i] @ skew(arm)
            right[column : column + 3] -= sign * axes[i] @ np.cross(spin, np.cross(spin, arm))
            # Spins differ by a rotation about the common axis, which turns with the preceding body.
            matrix[column + 3 : column + 5, at + 3 : at + 6] += sign * turning @ axes[i]
        relative = axes[k] @ (AXIS * (now[k + 1, 11] - now[k, 11]))
        right[column + 3 : column + 5] -= turning @ np.cross(axes[k] @ now[k, 10:], relative)
    solved = np.linalg.solve(matrix, right)
    out = np.empty_like(now)
    for i, (part, s) in enumerate(zip(PARTS, now, strict=True)):
        angular, spin = solved[6 * i + 3 : 6 * i + 6], s[10:]
        of_origin = np.cross(angular, part.com) + np.cross(spin, np.cross(spin, part.com))
        out[i, :3], out[i, 3:7] = s[7:10], quaternion_rates(s[3:7], spin)
        out[i, 7:10] = solved[6 * i : 6 * i + 3] - axes[i] @ of_origin
        out[i, 10:] = angular
    return out.ravel()


def fly(begin: Reals) -> Reals:
    y = begin.ravel()
    for command in COMMANDS:
        y = solve_ivp(
            lambda _, at, command=command: rates(at, command),
            (0.0, HOLD),
            y,
            method="DOP853",
            rtol=1e-10,
            atol=1e-11,
            max_step=1e-3,  # the clamps of drives have corners
        ).y[:, -1]
    return y.reshape(-1, SIZE)


def flown(integrator: str, dt: float) -> tuple[Reals, Reals]:
    """Start and end of a wild swing while the vehicle tumbles and falls."""
    sim = simulation(f"stepping.integrator={integrator}", dt=dt)
    sim.teleport(velocity=[0.5, -1.0, 2.0], angular_velocity=[1.0, -0.7, 1.5])
    begin = states(sim)
    for command in COMMANDS:
        sim.command(command)
        assert sim.advance(round(HOLD / dt))
    return begin, states(sim)


def largest_error(end: Reals, expected: Reals) -> tuple[float, float]:
    position = np.linalg.norm(end[:, :3] - expected[:, :3], axis=1).max()
    angle = max(angle_between(a[3:7], b[3:7]) for a, b in zip(end, expected, strict=True))
    return float(position), angle


@pytest.fixture(scope="module")
def expected() -> Reals:
    return fly(flown("rk4", 1e-3)[0])


def test_rk4_agrees_with_the_oracle_to_micrometres(expected: Reals) -> None:
    position, angle = largest_error(flown("rk4", 1e-3)[1], expected)
    # Some steps cross the corner of a drive's limit, which reduces the order below four: the error
    # is 0.9 um and 10 urad in this swing, and 0.14 um and 2 urad with a quarter of the step.
    assert position < 5e-6
    assert angle < 5e-5


def test_midpoint_is_of_second_order(expected: Reals) -> None:
    coarse, fine = (largest_error(flown("midpoint", dt)[1], expected) for dt in (1e-3, 5e-4))
    # 0.07 mm and 0.4 mrad with half a millisecond. Half the step divides the error by 4, except for
    # terms of higher order.
    assert fine[0] < 1e-4
    assert coarse[0] / fine[0] == pytest.approx(4.0, rel=0.3)
    assert coarse[1] / fine[1] == pytest.approx(4.0, rel=0.3)
