"""The equations of bodies coupled by rods, ropes and points, by SciPy.

Maximal coordinates: Newton and Euler equations for each body, with the coupling forces as unknowns
and constraints on the accelerations of the couplings' ends (docs/couplings.md, "Equations"). The
engine computes the same forces from unit forces on trees, so the two share neither equations nor
code.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from rigid_body import (
    GRAVITY,
    Reals,
    Vehicle,
    axes_of,
    quaternion_rates,
    rotor_accelerations,
    rotor_load,
    rotor_speeds,
)
from scipy.integrate import solve_ivp

SIZE = 13  # position and velocity (W) of the origin, quaternion, spin (body axes)


@dataclass(frozen=True)
class Member:
    """A free body, with or without rotors. SI units, body axes."""

    mass: float
    com: Reals  # from the origin
    inertia: Reals  # (3, 3) about the centre of mass
    vehicle: Vehicle | None = None


@dataclass(frozen=True)
class Rod:
    """Holds two points at constant distance; `None` is the world."""

    bodies: tuple[int | None, int | None]
    points: tuple[Reals, Reals]  # body axes, or W


@dataclass(frozen=True)
class Team:
    """Bodies and the rods between them."""

    members: list[Member]
    rods: list[Rod]

    def rates(self, y: Reals, speeds: list[Reals], accelerations: list[Reals]) -> Reals:
        """dy/dt of all bodies, concatenated; rotor values are given per body."""
        states = y.reshape(-1, SIZE)
        axes = [axes_of(s[3:7]) for s in states]
        count = len(self.members)
        matrix = np.zeros((6 * count + len(self.rods),) * 2)
        right = np.zeros(len(matrix))
        for i, member in enumerate(self.members):
            w, at = states[i, 10:], 6 * i
            matrix[at : at + 3, at : at + 3] = member.mass * np.eye(3)
            matrix[at + 3 : at + 6, at + 3 : at + 6] = member.inertia
            right[at : at + 3] = member.mass * GRAVITY
            right[at + 3 : at + 6] = -np.cross(w, member.inertia @ w)
            if member.vehicle is None:
                continue
            velocity = axes[i].T @ states[i, 7:10]
            force, moment = rotor_load(member.vehicle, velocity, w, speeds[i], accelerations[i])
            right[at : at + 3] += axes[i] @ force
            right[at + 3 : at + 6] += moment - np.cross(member.com, force)
        for k, rod in enumerate(self.rods):
            self._add(rod, 6 * count + k, states, axes, matrix, right)
        solved = np.linalg.solve(matrix, right)
        out = np.empty_like(states)
        for i, member in enumerate(self.members):
            out[i, :3] = states[i, 7:10]
            out[i, 3:7] = quaternion_rates(states[i, 3:7], states[i, 10:])
            com, w, angular = member.com, states[i, 10:], solved[6 * i + 3 : 6 * i + 6]
            of_origin = np.cross(angular, com) + np.cross(w, np.cross(w, com))
            out[i, 7:10] = solved[6 * i : 6 * i + 3] - axes[i] @ of_origin
            out[i, 10:] = angular
        return out.ravel()

    def _add(
        self,
        rod: Rod,
        row: int,
        states: Reals,
        axes: list[Reals],
        matrix: Reals,
        right: Reals,
    ) -> None:
        """Adds the rod's force and its equation: the distance of the ends is constant."""
        places, velocities = [], []
        for body, point in zip(rod.bodies, rod.points, strict=True):
            if body is None:
                places.append(point)
                velocities.append(np.zeros(3))
                continue
            arm = axes[body] @ point
            places.append(states[body, :3] + arm)
            velocities.append(states[body, 7:10] + axes[body] @ np.cross(states[body, 10:], point))
        apart, parting = places[0] - places[1], velocities[0] - velocities[1]
        distance = np.linalg.norm(apart)
        along = apart / distance
        bend = (parting @ parting - (along @ parting) ** 2) / distance
        for sign, body, point in zip((1.0, -1.0), rod.bodies, rod.points, strict=True):
            if body is None:
                continue
            # Unknowns: acceleration of the centre of mass (W), angular acceleration (body axes).
            at, w, arm = 6 * body, states[body, 10:], point - self.members[body].com
            turn = np.cross(arm, axes[body].T @ along)
            matrix[at : at + 3, row] -= sign * along
            matrix[at + 3 : at + 6, row] -= sign * turn
            matrix[row, at : at + 3] += sign * along
            matrix[row, at + 3 : at + 6] += sign * turn
            bend += sign * along @ (axes[body] @ np.cross(w, np.cross(w, arm)))
        right[row] = -bend

    def fly(self, y: Reals, speeds: list[Reals], commands: Reals, hold: float) -> Reals:
        """The states after all commands (times, members with rotors, rotors), each held."""
        flying = [i for i, member in enumerate(self.members) if member.vehicle is not None]
        for wanted in commands:
            given = {
                i: np.clip(wanted[n], 0.0, self.members[i].vehicle.constants["max_speed"])  # type: ignore[union-attr]
                for n, i in enumerate(flying)
            }

            def rotors(time: float, f, given=given, begin=speeds):  # type: ignore[no-untyped-def]
                return [
                    f(member.vehicle, begin[i], given[i], time) if i in given else np.zeros(0)
                    for i, member in enumerate(self.members)
                ]

            def slope(time: float, at: Reals, rotors=rotors) -> Reals:  # type: ignore[no-untyped-def]
                return self.rates(at, rotors(time, rotor_speeds), rotors(time, rotor_accelerations))

            y = solve_ivp(slope, (0.0, hold), y, method="DOP853", rtol=1e-10, atol=1e-11).y[:, -1]
            speeds = rotors(hold, rotor_speeds)
        return y
