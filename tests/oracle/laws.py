"""Second implementation of the flight control laws: rotation matrices, SciPy's rotations,
differences.

Written from the papers that the controllers' READMEs cite. Attitudes are matrices, rates of the
attitude setpoint are differences in time along the reference, regulator gains are SciPy's. Nothing
is shared with the plugins, which use quaternions and closed forms.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from rigid_body import Reals, Vehicle
from scipy.linalg import solve_continuous_are
from scipy.spatial.transform import Rotation

G = 9.81
UP = np.array([0.0, 0.0, 1.0])
STEP = 1e-3  # of differences in time [s]


@dataclass(frozen=True)
class Motion:
    """Motion of the vehicle. SI units."""

    position: Reals  # W
    rotation: Rotation  # W from B
    velocity: Reals  # W
    rates: Reals  # B


@dataclass(frozen=True)
class Point:
    """Point of a trajectory, W axes."""

    position: Reals
    velocity: Reals
    acceleration: Reals
    jerk: Reals
    snap: Reals
    yaw: float
    yaw_rate: float

    def values(self) -> Reals:
        parts = (self.position, self.velocity, self.acceleration, self.jerk, self.snap)
        return np.concatenate([*parts, [self.yaw, self.yaw_rate]])


def vee(skew: Reals) -> Reals:
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0]])


def pointing(thrust: Reals, yaw: float) -> Rotation:
    """Heading first, then the shortest rotation of z onto the thrust, as an axis and an angle."""
    up = thrust / np.linalg.norm(thrust)
    axis = np.cross(UP, up)
    size = np.linalg.norm(axis)
    turn = axis / size * np.arctan2(size, up[2]) if size > 0.0 else axis
    return Rotation.from_rotvec(turn) * Rotation.from_euler("z", yaw)


@dataclass(frozen=True)
class Wished:
    """Attitude setpoint, with rates and their derivative in its own axes."""

    rotation: Rotation
    rates: Reals
    acceleration: Reals


def wished(thrust: Reals, point: Point) -> Wished:
    def at(t: float) -> Rotation:
        u = thrust + point.jerk * t + 0.5 * point.snap * t * t
        return pointing(u, point.yaw + point.yaw_rate * t)

    def rates(t: float) -> Reals:  # fourth-order differences
        near = (at(t - STEP).inv() * at(t + STEP)).as_rotvec() / (2.0 * STEP)
        far = (at(t - 2.0 * STEP).inv() * at(t + 2.0 * STEP)).as_rotvec() / (4.0 * STEP)
        out: Reals = (4.0 * near - far) / 3.0
        return out

    near = (rates(STEP) - rates(-STEP)) / (2.0 * STEP)
    far = (rates(2.0 * STEP) - rates(-2.0 * STEP)) / (4.0 * STEP)
    return Wished(at(0.0), rates(0.0), (4.0 * near - far) / 3.0)


def lee_error(body: Rotation, wish: Rotation) -> Reals:
    """e_R of Lee et al. 2010, eq. 10."""
    r, d = body.as_matrix(), wish.as_matrix()
    return 0.5 * vee(d.T @ r - r.T @ d)


def turn_error(body: Rotation, wish: Rotation) -> Reals:
    """The same for large angles: twice the sine of half the angle, about its axis."""
    turn = (wish.inv() * body).as_rotvec()
    angle = float(np.linalg.norm(turn))
    out: Reals = turn / angle * 2.0 * np.sin(0.5 * angle) if angle > 0.0 else turn
    return out


def tilt_error(body: Rotation, wish: Rotation) -> Reals:
    """Rotates the body's z axis onto the setpoint's first, then about it."""
    z = body.inv().apply(wish.apply(UP))  # in body axes
    tilt = pointing(z, 0.0)
    about = (tilt.inv() * (body.inv() * wish)).as_rotvec()
    angle = float(np.arccos(np.clip(z[2], -1.0, 1.0)))
    axis = np.cross(UP, z) / np.sin(angle)
    return -(axis * 2.0 * np.sin(0.5 * angle) + UP * 2.0 * np.sin(0.5 * about[2]))


ERRORS: dict[str, Callable[[Rotation, Rotation], Reals]] = {
    "se3": lee_error,
    "quaternion": turn_error,
    "tilt_priority": tilt_error,
}


def hover_drag(vehicle: Vehicle) -> float:
    """Lateral drag of all rotors, per mass and velocity [1/s]."""
    share = vehicle.mass * G / len(vehicle.directions)
    speeds = np.sqrt(share / vehicle.constants["thrust_constant"])
    return float(np.sum(vehicle.constants["drag_constant"] * speeds)) / vehicle.mass


def drag_forward(vehicle: Vehicle, motion: Motion, point: Point) -> Reals:
    z = motion.rotation.apply(UP)
    out: Reals = hover_drag(vehicle) * (np.eye(3) - np.outer(z, z)) @ point.velocity
    return out


def drag_moment(vehicle: Vehicle, motion: Motion, point: Point) -> Reals:
    """Moment that balances the drag at the hubs, which lie above the centre of mass."""
    height = float(np.mean(vehicle.hubs[:, 2])) - float(vehicle.com[2])
    force = -vehicle.mass * hover_drag(vehicle) * motion.rotation.inv().apply(point.velocity)
    out: Reals = -np.cross(height * UP, force)
    return out


def thrust_along(vehicle: Vehicle, motion: Motion, u: Reals) -> float:
    return max(0.0, vehicle.mass * float(u @ motion.rotation.apply(UP)))


def moment(
    vehicle: Vehicle, motion: Motion, wish: Wished, k_r: Reals, k_w: Reals, e_r: Reals
) -> Reals:
    """Eq. 16 of Lee et al. 2010, with gains per inertia."""
    j, w = vehicle.inertia, motion.rates
    back = motion.rotation.as_matrix().T @ wish.rotation.as_matrix()
    e_w = w - back @ wish.rates
    hat = np.cross(w, np.eye(3)).T  # hat @ x is w x x
    forward = hat @ back @ wish.rates - back @ wish.acceleration
    out: Reals = -j @ (k_r * e_r + k_w * e_w) + np.cross(w, j @ w) - j @ forward
    return out


def regulator(steps: list[float], weights: list[float], input_weight: float) -> Reals:
    """The gain of a chain of integrators with one input at its end."""
    n = len(weights)
    a = np.diag(np.array(steps, float), 1) if steps else np.zeros((n, n))
    b = np.zeros((n, 1))
    b[-1] = 1.0
    r = np.array([[input_weight]])
    x = solve_continuous_are(a, b, np.diag(weights), r)
    out: Reals = (b.T @ x / input_weight)[0]
    return out
