"""Samples of a running simulation, row by row."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skybody import FlightPolicy, Simulation
from skybody.look.motion import Array

from .samples import Samples, Series, bases_of, chosen_rows, prefixes

ENDINGS = ("terminated", "truncated", "fault")


class Row(NamedTuple):
    """A simulation at one time."""

    time: float  # since the reset [s]
    poses: Array  # bodies x 7: position (W) [m], quaternion w x y z
    rotor_speed: Array  # [rad/s]
    goals: Array  # goals x 4: position (W) [m], yaw [rad]
    values: Array  # as Sampler.names
    touching: bool  # the ground, an obstacle or another robot


class Sampler:
    """Reads rows of a simulation."""

    def __init__(self, simulation: Simulation) -> None:
        """Looks names up; the simulation has begun an episode."""
        self.simulation = simulation
        self.body_names = list(simulation.body_names)
        self.goal_names = list(simulation.goal_bodies)
        compiled = simulation.compiled
        self.bases = bases_of(self.body_names)
        prefix = prefixes(self.bases)
        self.names = [  # and units, of Row.values
            *((f"{prefix[robot]}height", "m") for robot in self.bases),
            *((f"{prefix[robot]}speed", "m/s") for robot in self.bases),
            ("reward", ""),
            *((name_of(c.name, k, c.count), c.unit) for c in compiled.info_channels
              for k in range(c.count)),
        ]  # fmt: skip

    def row(self) -> Row:
        """The present state."""
        simulation = self.simulation
        bodies = simulation.bodies
        poses = np.array([[*body.position, *body.rotation] for body in bodies])
        bases = list(self.bases.values())
        speeds = [float(np.linalg.norm(bodies[k].velocity)) for k in bases]
        values = [*poses[bases, 2], *speeds, simulation.reward, *simulation.info]
        return Row(
            simulation.time,
            poses,
            simulation.rotor_speeds,
            simulation.goals.reshape(-1, 4),
            np.array(values, np.float64),
            len(simulation.contacts()) > 0,
        )

    def drawn(self) -> dict[str, float]:
        """Values of the episode's parameters by path."""
        return {path: self.simulation.param(path) for path in self.simulation.compiled.param_paths}

    def ending(self) -> str:
        """How the episode has ended: `terminated`, `truncated` or `fault`; empty: it goes on."""
        ended = [name for name in ENDINGS if getattr(self.simulation, name)]
        return ended[-1] if ended else ""


def name_of(name: str, k: int, count: int) -> str:
    """Name of a value of a channel."""
    return name if count == 1 else f"{name}[{k}]"


def fly(simulation: Simulation, policy: FlightPolicy, most_steps: int) -> Samples:
    """Flies an episode to its end, or for some steps.

    Returns:
        Its samples: all rows, or those that chosen_rows() keeps of them.
    """
    simulation.reset()
    sampler = Sampler(simulation)
    flown, drawn = [sampler.row()], sampler.drawn()
    while len(flown) <= most_steps and not sampler.ending():
        simulation.step(policy.act(simulation))
        flown.append(sampler.row())
    width = sum(np.size(value) for value in flown[0])
    kept = chosen_rows(np.array([row.time for row in flown]), width)
    time, poses, rotors, goals, values, touching = (
        np.array(column) for column in zip(*(flown[k] for k in kept), strict=True)
    )
    return Samples(
        compiled=simulation.compiled,
        episode=simulation.episode,
        drawn=drawn,
        body_names=sampler.body_names,
        time=time,
        poses=poses,
        rotor_speed=rotors,
        goals={name: goals[:, k] for k, name in enumerate(sampler.goal_names)},
        series=[Series(name, unit, values[:, k]) for k, (name, unit) in enumerate(sampler.names)],
        touching=touching,
        events=[(0.0, "reset"), (float(time[-1]), sampler.ending() or "stopped")],
    )
