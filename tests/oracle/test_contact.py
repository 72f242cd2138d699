"""Drops of a QDrone2 onto the ground and frictionless flights into a wall, against SciPy.

The contact law and the contact points are those of docs/contact.md; no code is shared. Drops onto a
table are in test_crates.py, because feet of 1 cm that fall on an obstacle are stopped plastically.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import skybody
from rigid_body import (
    GRAVITY,
    Reals,
    Vehicle,
    angle_between,
    axes_of,
    quaternion_rates,
    read_vehicle,
)
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parents[2]
PENETRATION, DISSIPATION = 0.001, 3.0  # defaults
FOOT = 0.01  # radius [m]
# Of scenarios/models/qdrone2/qdrone2.urdf, body axes.
CORNERS = np.array(
    [
        [sx * 0.15, sy * 0.175, 0.005 + sz * 0.025]
        for sx in (-1, 1)
        for sy in (-1, 1)
        for sz in (-1, 1)
    ]
)
FEET = np.array([[sx * 0.1016, sy * 0.127, -0.05] for sx in (-1, 1) for sy in (-1, 1)])
POINTS = np.concatenate([CORNERS, FEET])
RADII = np.array([0.0] * len(CORNERS) + [FOOT] * len(FEET))
FALL = 0.5  # [s]


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return read_vehicle(ROOT / "scenarios/models/qdrone2")


def begin(turn: Reals) -> Reals:
    """Rotated, its lowest point 0.3 m above the ground, at rest."""
    rotation = Rotation.from_rotvec(turn)
    heights = np.concatenate([rotation.apply(CORNERS)[:, 2], rotation.apply(FEET)[:, 2] - FOOT])
    y = np.zeros(13)
    y[2] = 0.3 - heights.min()
    y[3:7] = rotation.as_quat()[[3, 0, 1, 2]]
    return y


def fall(vehicle: Vehicle, y: Reals, direction: Reals, level: float) -> Reals:
    """End state of FALL. `direction`: normal of the plane; `level`: its position on the normal."""
    stiffness = vehicle.mass * 9.81 / (len(FEET) * PENETRATION**1.5)

    def rates(_: float, y: Reals) -> Reals:
        q, v, w = y[3:7], y[7:10], y[10:13]
        axes = axes_of(q)
        arms = POINTS @ axes.T - np.outer(RADII, direction)
        depths = level - (y[:3] + arms) @ direction
        deeper = -(v + np.cross(axes @ w, arms)) @ direction
        damping = np.maximum(0.0, 1.0 + 1.5 * DISSIPATION * deeper)
        pushes = stiffness * np.maximum(depths, 0.0) ** 1.5 * damping
        forces = np.outer(pushes, direction)
        force, moment = forces.sum(axis=0), np.cross(arms, forces).sum(axis=0)
        com = vehicle.com
        about_com = axes.T @ moment - np.cross(com, axes.T @ force)
        angular = np.linalg.solve(vehicle.inertia, about_com - np.cross(w, vehicle.inertia @ w))
        of_com = force / vehicle.mass + GRAVITY
        linear = of_com - axes @ (np.cross(angular, com) + np.cross(w, np.cross(w, com)))
        return np.concatenate([v, quaternion_rates(q, w), linear, angular])

    return solve_ivp(
        rates, (0.0, FALL), y, method="DOP853", rtol=1e-9, atol=1e-10, max_step=5e-4
    ).y[:, -1]


def by_skybody(y: Reals, dt: float, overrides: tuple[str, ...] = ()) -> Reals:
    given = [
        "contact.friction=0",
        "randomization=[]",
        f"stepping.dt={dt}",
        "robots.quad.rotor_speed=0",
        *overrides,
    ]
    sim = skybody.Simulation("hover", control="rotor_speed", overrides=given)
    sim.reset()
    sim.teleport(position=y[:3], rotation=y[3:7], velocity=y[7:10], angular_velocity=y[10:])
    assert sim.advance(round(FALL / dt))
    body = sim.base()
    return np.concatenate([body.position, body.rotation])


def error(flown: Reals, end: Reals) -> tuple[float, float]:
    return float(np.linalg.norm(flown[:3] - end[:3])), angle_between(flown[3:], end[3:7])


@pytest.mark.parametrize("degrees", [0, 20, 45, 70, 90, 120, 150, 180])
def test_a_drop_onto_the_ground_ends_where_the_oracle_does(
    vehicle: Vehicle, degrees: float
) -> None:
    y = begin(math.radians(degrees) * np.array([0.8, 0.6, 0.0]))
    up = np.array([0.0, 0.0, 1.0])
    end = fall(vehicle, y, up, 0.0)
    found = {dt: error(by_skybody(y, dt), end) for dt in (1e-3, 2.5e-4)}
    assert found[1e-3][0] < 0.01 and found[1e-3][1] < math.radians(3.0)
    assert found[2.5e-4][0] < max(0.5 * found[1e-3][0], 2e-4)


@pytest.mark.parametrize("speed", [0.5, 1.0])
def test_a_bounce_off_a_wall_is_the_laws(vehicle: Vehicle, speed: float) -> None:
    """The face of a very wide wall, at speeds below the limit for plastic stops."""
    y = begin(np.array([0.0, 0.0, 0.4]))
    y[0], y[2], y[7] = -0.5, 3.0, speed
    wall = "obstacles=[{name: wall, box: [10, 100, 100], position: [5, 0, 0]}]"
    end = fall(vehicle, y, np.array([-1.0, 0.0, 0.0]), 0.0)
    for dt in (2e-3, 1e-3, 5e-4, 1e-4):
        position, angle = error(by_skybody(y, dt, (wall,)), end)
        assert position < 0.01 and angle < math.radians(3.0), dt
