"""Quadrotors as plain numbers, and the axes in which a policy knows them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skybody import CompiledScenario
from skybody._native import Pool

Reals = NDArray[np.float64]
Rotor = tuple[int, int, int]  # signs of the hub's x and y; +1: turns counterclockwise from above

RAPTOR = ((1, -1, 1), (-1, -1, -1), (-1, 1, 1), (1, 1, -1))  # front right, back right, ...
VEHICLE = ((1, 1, -1), (1, -1, 1), (-1, 1, 1), (-1, -1, -1))  # of scenarios/models/vehicle
INERTIA = (0, 3, 4, 3, 1, 5, 4, 5, 2)  # of xx yy zz xy xz yz, the matrix by rows


@dataclass(frozen=True)
class Axes:
    """The turn that shows a vehicle to a policy which knows another layout of rotors.

    A policy of an X with front right counterclockwise flies a + as an X that is turned by 45
    degrees, and an X of other directions turned by 90. World and body are both turned, so the
    physics are the same.
    """

    matrix: Reals  # S (3, 3), about z: vectors of the vehicle to those that the policy sees
    order: tuple[int, ...]  # the vehicle's rotor for each rotor of the policy

    def seen(self, motion: Motion) -> Motion:
        """The motion in the policy's axes."""
        s = self.matrix
        return Motion(
            motion.position @ s.T,
            s @ motion.rotation @ s.T,
            motion.velocity @ s.T,
            motion.rates @ s.T,
        )

    def to_vehicle(self, values: Reals) -> Reals:
        """Values of the policy's rotors (n, 4) in the vehicle's order."""
        own = np.empty_like(values)
        own[:, list(self.order)] = values
        return own


@dataclass(frozen=True)
class Motion:
    """States of n vehicles: W, and B for `rates`."""

    position: Reals  # (n, 3) [m]
    rotation: Reals  # (n, 3, 3) W from B
    velocity: Reals  # (n, 3) [m/s]
    rates: Reals  # (n, 3), angular velocity in B [rad/s]


def axes_for(hubs: Reals, directions: Reals, layout: tuple[Rotor, ...]) -> Axes:
    """The axes in which hubs (4, 3) with these directions have the policy's layout.

    Raises:
        ValueError: no turn by a multiple of 45 degrees has it.
    """
    for eighths in (0, 1, -1, 2, -2, 3, -3, 4):
        c, s = np.cos(eighths * np.pi / 4.0), np.sin(eighths * np.pi / 4.0)
        matrix = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        order = _order(hubs @ matrix.T, directions, layout)
        if order is not None:
            return Axes(matrix, order)
    raise ValueError("no turn gives these rotors the policy's layout")


def _order(hubs: Reals, directions: Reals, layout: tuple[Rotor, ...]) -> tuple[int, ...] | None:
    smallest = 0.2 * np.abs(hubs[:, :2]).max()
    found = [
        (int(np.sign(x)), int(np.sign(y)), int(turn))
        for (x, y, _), turn in zip(hubs, directions.round(), strict=True)
        if min(abs(x), abs(y)) > smallest
    ]
    if set(found) != set(layout) or len(found) != len(layout):
        return None
    return tuple(found.index(rotor) for rotor in layout)


@dataclass(frozen=True)
class Fleet:
    """n quadrotors, each a rigid body with rotors along z."""

    mass: Reals  # (n) [kg]
    inertia: Reals  # (n, 3, 3) about the centre of mass [kg m^2]
    hubs: Reals  # (n, 4, 3) from the centre of mass [m]
    directions: Reals  # (4) +1: counterclockwise
    full_thrust: Reals  # (n, 4) at the largest speed [N]
    moment_arm: Reals  # (n, 4) drag torque over thrust [m]
    tau_up: Reals  # (n, 4) [s]
    tau_down: Reals  # (n, 4) [s]
    gravity: float  # [m/s^2]

    @property
    def thrust_to_weight(self) -> Reals:
        """(n)"""
        return np.asarray(self.full_thrust.sum(axis=1) / (self.mass * self.gravity))

    @property
    def turn(self) -> Reals:
        """Angular accelerations (n) about x by two rotors at full thrust [rad/s^2]."""
        moment = np.sum(np.maximum(self.hubs[:, :, 1], 0.0) * self.full_thrust, axis=1)
        return np.asarray(moment / self.inertia[:, 0, 0])

    @property
    def hover(self) -> Reals:
        """Throttles (n) that carry the weight: shares of the largest speed."""
        return np.asarray(1.0 / np.sqrt(self.thrust_to_weight))


def fleet_of(pool: Pool, compiled: CompiledScenario) -> Fleet:
    """The vehicles of a pool as they are now: robot `quad`, one body with rotors."""

    def values(path: str) -> Reals:
        return np.array([pool.param(env, f"robots.quad.{path}") for env in range(pool.num_envs)])

    def of_rotors(name: str) -> Reals:
        count = len(compiled.rotors)
        return np.stack([values(f"rotors[{k}].{name}") for k in range(count)], axis=1)

    link = f"links.{compiled.bodies[0].removeprefix('quad.')}"
    center = np.stack([values(f"{link}.com[{axis}]") for axis in range(3)], axis=1)
    hubs = np.stack([of_rotors(f"position[{axis}]") for axis in range(3)], axis=2)
    thrust = of_rotors("thrust_constant")
    return Fleet(
        mass=values(f"{link}.mass"),
        inertia=np.stack([values(f"{link}.inertia[{k}]") for k in INERTIA], axis=1).reshape(
            -1, 3, 3
        ),
        hubs=hubs - center[:, None, :],
        directions=np.array([rotor.direction for rotor in compiled.rotors]),
        full_thrust=thrust * of_rotors("max_speed") ** 2,
        moment_arm=of_rotors("moment_constant") / thrust,
        tau_up=of_rotors("tau_up"),
        tau_down=of_rotors("tau_down"),
        gravity=-compiled.gravity[2],
    )
