"""RAPTOR's policy and ours, as functions of a motion and a moving target."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from skybody.train.policy_file import Policy

from research.transfer.raptor_vehicles import (
    RAPTOR,
    VEHICLE,
    Fleet,
    Motion,
    Reals,
    axes_for,
)
from research.transfer.raptor_worlds import Peer, quaternions

CLIP = (1.0, 2.0)  # of RAPTOR's position error [m] and velocity error [m/s]


@dataclass(frozen=True)
class Target:
    """A moving place; its heading is 0."""

    position: Reals  # (3) W [m]
    velocity: Reals  # (3) W [m/s]


class Pilot(Protocol):
    """A policy in flight."""

    def __call__(self, motion: Motion, target: Target) -> Reals:
        """Throttles (n, 4) in [0, 1], in the order of the vehicle's rotors."""


class Raptor:
    """RAPTOR's policy.

    Args:
        clip: limits of both errors, as in CLIP.
        as_thrust: its actions are shares of the largest thrust, not of the largest speed.
    """

    def __init__(
        self,
        peer: Peer,
        fleet: Fleet,
        clip: tuple[float, float] = CLIP,
        as_thrust: bool = False,
    ) -> None:
        self.peer, self.clip, self.power = peer, clip, 0.5 if as_thrust else 1.0
        self.axes = axes_for(fleet.hubs[0], fleet.directions, RAPTOR)
        hover = fleet.hover[:, None] ** (1.0 / self.power)
        self.last = np.repeat(2.0 * hover - 1.0, 4, axis=1)
        peer.ask({"do": "forget"})

    def __call__(self, motion: Motion, target: Target) -> Reals:
        """As Pilot."""
        rows = raptor_observation(self.axes.seen(relative(motion, target)), self.last, self.clip)
        self.last = np.clip(self.peer.ask({"do": "act"}, rows), -1.0, 1.0).astype(np.float64)
        return self.axes.to_vehicle((0.5 * self.last + 0.5) ** self.power)


class OurPolicy:
    """A policy of scenario `vehicles`, for which a target that moves is at rest at any time."""

    def __init__(self, policy: Policy, fleet: Fleet) -> None:
        self.policy = policy
        self.axes = axes_for(fleet.hubs[0], fleet.directions, VEHICLE)
        self.states = policy.states(len(fleet.mass))
        self.past = np.full((len(fleet.mass), 8), -1.0)

    def __call__(self, motion: Motion, target: Target) -> Reals:
        """As Pilot."""
        rows = hover_observation(self.axes.seen(relative(motion, target)), self.past)
        actions = self.policy(rows.astype(np.float32), self.states)
        self.past = np.column_stack([actions, self.past[:, :4]])
        return self.axes.to_vehicle(0.5 * actions + 0.5)


def relative(motion: Motion, target: Target) -> Motion:
    """The motion as seen from the target, which is then at rest in the origin."""
    return Motion(
        motion.position - target.position,
        motion.rotation,
        motion.velocity - target.velocity,
        motion.rates,
    )


def raptor_observation(motion: Motion, last: Reals, clip: tuple[float, float]) -> Reals:
    """RAPTOR's 22 inputs: position, rotation matrix by rows, velocity, rates, last action."""
    return np.column_stack(
        [
            np.clip(motion.position, -clip[0], clip[0]),
            motion.rotation.reshape(-1, 9),
            np.clip(motion.velocity, -clip[1], clip[1]),
            motion.rates,
            last,
        ]
    )


def hover_observation(motion: Motion, past: Reals) -> Reals:
    """The 22 observations of task `hover` with its target in the origin, heading 0."""
    heading = np.arctan2(motion.rotation[:, 1, 0], motion.rotation[:, 0, 0])
    return np.column_stack(
        [
            -motion.position,
            -heading,
            motion.velocity,
            quaternions(motion.rotation),
            motion.rates,
            past,
        ]
    )
