"""Second implementation of the flight equations, by SciPy: one rigid body with rotors.

Written from the documents and the sources that they cite, with no code shared with the engine: eq.
1 and 2 of the paper, rotors as in RotorS (`core/physics/forces/rotor_force.h` names the sections),
Newton and Euler about the centre of mass. Readers of XML and YAML read the models from URDF and
rotors.yaml.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

Reals = NDArray[np.float64]
GRAVITY = np.array([0.0, 0.0, -9.81])
CONSTANTS = (
    "thrust_constant",
    "moment_constant",
    "drag_constant",
    "rolling_moment_constant",
    "inertia",
    "tau_up",
    "tau_down",
    "max_speed",
)


@dataclass(frozen=True)
class Vehicle:
    """One rigid body with rotors whose axes are parallel to the body's z. SI units, body axes."""

    mass: float
    com: Reals  # from the origin
    inertia: Reals  # (3, 3) about the centre of mass
    hubs: Reals  # (rotors, 3)
    directions: Reals  # +1 counter-clockwise about z
    constants: dict[str, Reals]  # by their names in rotors.yaml


def numbers(element: ElementTree.Element | None, attribute: str, default: str) -> Reals:
    text = default if element is None else element.get(attribute, default)
    return np.array([float(word) for word in text.split()])


def read_vehicle(folder: Path) -> Vehicle:
    """The links of a URDF on fixed joints without rotation from the first link."""
    robot = ElementTree.parse(next(folder.glob("*.urdf"))).getroot()
    places: dict[str, Reals] = {robot.findall("link")[0].get("name", ""): np.zeros(3)}
    for joint in robot.findall("joint"):
        child = joint.find("child")
        assert child is not None
        if joint.get("type") != "fixed":
            continue
        places[child.get("link", "")] = numbers(joint.find("origin"), "xyz", "0 0 0")
    masses, centres, inertias = [], [], []
    for link in robot.findall("link"):
        inertial = link.find("inertial")
        if inertial is None or link.get("name", "") not in places:
            continue
        own = inertial.find("inertia")
        mass = inertial.find("mass")
        assert own is not None and mass is not None
        masses.append(float(mass.get("value", "0")))
        centres.append(
            places[link.get("name", "")] + numbers(inertial.find("origin"), "xyz", "0 0 0")
        )
        inertias.append(
            np.array(
                [[float(own.get(f"i{min(a, b)}{max(a, b)}", "0")) for b in "xyz"] for a in "xyz"]
            )
        )
    mass = sum(masses)
    com = sum(m * c for m, c in zip(masses, centres, strict=True)) / mass
    inertia = np.zeros((3, 3))
    for m, c, own_inertia in zip(masses, centres, inertias, strict=True):
        arm = c - com  # parallel axis theorem
        inertia += own_inertia + m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Vehicle(mass, com, inertia, *read_rotors(folder / "rotors.yaml", places))


def read_rotors(path: Path, places: dict[str, Reals]) -> tuple[Reals, Reals, dict[str, Reals]]:
    content: dict[str, Any] = yaml.safe_load(path.read_text())
    rotors = [{**content["defaults"], **rotor} for rotor in content["rotors"]]
    hubs = np.array([places[r["link"]] + np.array(r["position"]) for r in rotors])
    directions = np.array([1.0 if r["direction"] == "ccw" else -1.0 for r in rotors])
    constants = {
        name: np.array([float(rotor.get(name, 0.0)) for rotor in rotors]) for name in CONSTANTS
    }
    return hubs, directions, constants


def rotor_speeds(vehicle: Vehicle, start: Reals, command: Reals, time: float) -> Reals:
    """Paper eq. 2, in closed form."""
    tau = np.where(command > start, vehicle.constants["tau_up"], vehicle.constants["tau_down"])
    return command + (start - command) * np.exp(-time / tau)


def rotor_accelerations(vehicle: Vehicle, start: Reals, command: Reals, time: float) -> Reals:
    """Paper eq. 2."""
    tau = np.where(command > start, vehicle.constants["tau_up"], vehicle.constants["tau_down"])
    return (command - rotor_speeds(vehicle, start, command, time)) / tau


def rotor_load(
    vehicle: Vehicle, velocity: Reals, w: Reals, speed: Reals, acceleration: Reals
) -> tuple[Reals, Reals]:
    """Force and moment about the origin, body axes; arguments: velocity of the origin and spin."""
    k, s = vehicle.constants, vehicle.directions
    across = velocity + np.cross(w, vehicle.hubs)
    across[:, 2] = 0.0
    forces = -(k["drag_constant"] * speed)[:, None] * across
    forces[:, 2] += k["thrust_constant"] * speed**2
    moment = np.cross(vehicle.hubs, forces).sum(axis=0)
    moment -= (s * k["rolling_moment_constant"] * speed) @ across
    momentum = np.array([0.0, 0.0, (s * k["inertia"] * speed).sum()])
    moment -= np.cross(w, momentum)
    moment[2] -= s @ (k["moment_constant"] * speed**2 + k["inertia"] * acceleration)
    return forces.sum(axis=0), moment


def quaternion_rates(q: Reals, w: Reals) -> Reals:
    """Paper eq. 1; w x y z."""
    return 0.5 * np.array(
        [
            -q[1] * w[0] - q[2] * w[1] - q[3] * w[2],
            q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
            q[0] * w[1] + q[3] * w[0] - q[1] * w[2],
            q[0] * w[2] + q[1] * w[1] - q[2] * w[0],
        ]
    )


def axes_of(q: Reals) -> Reals:
    """Columns: the axes of a body in W; q (w x y z) may have any norm."""
    w, x, y, z = q / np.sqrt(q @ q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def rates(vehicle: Vehicle, y: Reals, speed: Reals, acceleration: Reals) -> Reals:
    """dy/dt of position, quaternion (w x y z), velocity (W) of the origin, spin (body axes)."""
    q, v, w = y[3:7], y[7:10], y[10:13]
    axes = axes_of(q)
    force, moment = rotor_load(vehicle, axes.T @ v, w, speed, acceleration)
    about_com = moment - np.cross(vehicle.com, force)
    angular = np.linalg.solve(vehicle.inertia, about_com - np.cross(w, vehicle.inertia @ w))
    of_com = axes @ force / vehicle.mass + GRAVITY
    com = vehicle.com
    linear = of_com - axes @ (np.cross(angular, com) + np.cross(w, np.cross(w, com)))
    return np.concatenate([v, quaternion_rates(q, w), linear, angular])


def fly(vehicle: Vehicle, y: Reals, speed: Reals, commands: Reals, hold: float) -> Reals:
    """The state after all commands, each held for `hold` [s]; DOP853 with tolerances near
    round-off.

    (E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", 1993.)
    """
    limit = vehicle.constants["max_speed"]
    for wanted in commands:
        command = np.clip(wanted, 0.0, limit)
        start = speed

        def slope(time: float, at: Reals, start: Reals = start, command: Reals = command) -> Reals:
            now = rotor_speeds(vehicle, start, command, time)
            return rates(vehicle, at, now, rotor_accelerations(vehicle, start, command, time))

        y = solve_ivp(slope, (0.0, hold), y, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
        speed = rotor_speeds(vehicle, start, command, hold)
    return y


def angle_between(a: Reals, b: Reals) -> float:
    """Angle between two attitudes (w x y z) [rad]."""
    one, two = (Rotation.from_quat(q[[1, 2, 3, 0]]) for q in (a, b))
    return float((one.inv() * two).magnitude())
