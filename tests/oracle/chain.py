"""The equations of a vehicle with bodies on ball joints, by SciPy.

Maximal coordinates: Newton and Euler equations for each body, with the joints' forces as unknowns
and constraints on the joints' accelerations. The engine uses joint coordinates of a tree, so the
two share neither equations nor code.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rigid_body import (
    GRAVITY,
    Reals,
    Vehicle,
    axes_of,
    numbers,
    quaternion_rates,
    read_vehicle,
    rotor_accelerations,
    rotor_load,
    rotor_speeds,
)
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

SIZE = (
    13  # of a body's state: position and velocity (W) of its origin, quaternion, spin (body axes)
)


@dataclass(frozen=True)
class Hanging:
    """A body on a ball joint at its own origin. SI units."""

    mass: float
    com: Reals  # body axes
    inertia: Reals  # (3, 3) about the centre of mass
    joint: Reals  # in the frame of the preceding body


@dataclass(frozen=True)
class Chain:
    """A vehicle with a chain of bodies, each suspended from the preceding one."""

    vehicle: Vehicle
    hanging: list[Hanging]


def read_chain(folder: Path, links: dict[str, str]) -> Chain:
    """Links, in order, with the joint that places each link's origin."""
    robot = ElementTree.parse(next(folder.glob("*.urdf"))).getroot()
    bodies = {link.get("name", ""): link for link in robot.findall("link")}
    joints = {joint.get("name", ""): joint for joint in robot.findall("joint")}
    hanging = []
    for link, joint in links.items():
        inertial = bodies[link].find("inertial")
        assert inertial is not None
        mass, own = inertial.find("mass"), inertial.find("inertia")
        assert mass is not None and own is not None
        moments = np.diag([float(own.get(name, "0")) for name in ("ixx", "iyy", "izz")])
        hanging.append(
            Hanging(
                float(mass.get("value", "0")),
                numbers(inertial.find("origin"), "xyz", "0 0 0"),
                moments,
                numbers(joints[joint].find("origin"), "xyz", "0 0 0"),
            )
        )
    return Chain(read_vehicle(folder), hanging)


def cross_matrix(v: Reals) -> Reals:
    """cross_matrix(v) @ x is v x x."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def start(chain: Chain, y: Reals) -> Reals:
    """States of all bodies for the first body's state, with joints at rest and at angle zero."""
    states = [y]
    for body in chain.hanging:
        before = states[-1]
        axes = Rotation.from_quat(before[[4, 5, 6, 3]]).as_matrix()
        arm, spin = axes @ body.joint, axes @ before[10:]
        velocity = before[7:10] + np.cross(spin, arm)
        states.append(np.concatenate([before[:3] + arm, before[3:7], velocity, before[10:]]))
    return np.concatenate(states)


def rates(chain: Chain, y: Reals, speed: Reals, acceleration: Reals) -> Reals:
    """dy/dt of all bodies, concatenated."""
    states = y.reshape(-1, SIZE)
    axes = [axes_of(s[3:7]) for s in states]
    spins = [s[10:] for s in states]
    vehicle = chain.vehicle
    bodies = [(vehicle.mass, vehicle.com, vehicle.inertia)]
    bodies += [(b.mass, b.com, b.inertia) for b in chain.hanging]
    count = len(bodies)
    unknowns = 6 * count + 3 * len(chain.hanging)
    matrix, right = np.zeros((unknowns, unknowns)), np.zeros(unknowns)
    force, moment = rotor_load(vehicle, axes[0].T @ states[0, 7:10], spins[0], speed, acceleration)
    for i, (mass, com, inertia) in enumerate(bodies):
        # Unknowns: acceleration of the centre of mass (W), angular acceleration (body axes).
        at = 6 * i
        matrix[at : at + 3, at : at + 3] = mass * np.eye(3)
        right[at : at + 3] = mass * GRAVITY
        matrix[at + 3 : at + 6, at + 3 : at + 6] = inertia
        right[at + 3 : at + 6] = -np.cross(spins[i], inertia @ spins[i])
        if i == 0:
            right[:3] += axes[0] @ force
            right[3:6] += moment - np.cross(com, force)
    for k, body in enumerate(chain.hanging):
        # The joint's force (W) acts on the suspended body, and its opposite on the preceding one.
        unknown = 6 * count + 3 * k
        ends = ((k, 1.0, body.joint - bodies[k][1]), (k + 1, -1.0, -bodies[k + 1][1]))
        for i, sign, arm in ends:  # arms from the centres of mass, body axes
            at = 6 * i
            matrix[at : at + 3, unknown : unknown + 3] += sign * np.eye(3)
            turn = cross_matrix(arm) @ axes[i].T
            matrix[at + 3 : at + 6, unknown : unknown + 3] += sign * turn
            # Both ends have the same acceleration: a + R (alpha x arm + w x (w x arm)).
            matrix[unknown : unknown + 3, at : at + 3] += sign * np.eye(3)
            matrix[unknown : unknown + 3, at + 3 : at + 6] -= sign * axes[i] @ cross_matrix(arm)
            centripetal = axes[i] @ np.cross(spins[i], np.cross(spins[i], arm))
            right[unknown : unknown + 3] -= sign * centripetal
    solved = np.linalg.solve(matrix, right)
    out = np.empty_like(states)
    for i, (_, com, _) in enumerate(bodies):
        angular = solved[6 * i + 3 : 6 * i + 6]
        of_origin = np.cross(angular, com) + np.cross(spins[i], np.cross(spins[i], com))
        out[i, :3] = states[i, 7:10]
        out[i, 3:7] = quaternion_rates(states[i, 3:7], spins[i])
        out[i, 7:10] = solved[6 * i : 6 * i + 3] - axes[i] @ of_origin
        out[i, 10:] = angular
    return out.ravel()


def fly(chain: Chain, y: Reals, speed: Reals, commands: Reals, hold: float) -> Reals:
    """The states after all commands, each held for `hold` [s]."""
    vehicle = chain.vehicle
    for wanted in commands:
        command = np.clip(wanted, 0.0, vehicle.constants["max_speed"])
        begin = speed

        def slope(time: float, at: Reals, begin: Reals = begin, command: Reals = command) -> Reals:
            now = rotor_speeds(vehicle, begin, command, time)
            return rates(chain, at, now, rotor_accelerations(vehicle, begin, command, time))

        y = solve_ivp(slope, (0.0, hold), y, method="DOP853", rtol=1e-10, atol=1e-11).y[:, -1]
        speed = rotor_speeds(vehicle, begin, command, hold)
    return y
