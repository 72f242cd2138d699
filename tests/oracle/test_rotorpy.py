"""Accelerations in moving air against RotorPy's, for its Crazyflie and its Hummingbird.

research/control/rotorpy_vehicle.py converts its vehicles into Skybody models. Rotors reach their
command within a step.
"""

from __future__ import annotations

import dataclasses
import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from skybody import Simulation

vehicles = importlib.import_module("research.control.rotorpy_vehicle")
multirotor: Any = importlib.import_module("rotorpy.vehicles.multirotor")

Reals = NDArray[np.float64]
Constants = dict[str, Any]
STATES = 10_000


@dataclasses.dataclass(frozen=True)
class Flight:
    """A state of one vehicle in the air."""

    attitude: Reals  # w x y z
    velocity: Reals
    spin: Reals
    speeds: Reals
    wind: Reals

    @staticmethod
    def draw(random: np.random.Generator, k: Constants) -> Flight:
        attitude = random.normal(size=4)
        return Flight(
            attitude / np.linalg.norm(attitude),
            direction(random) * random.uniform(0.0, 10.0),
            direction(random) * random.uniform(0.0, 10.0),
            random.uniform(k["rotor_speed_min"], k["rotor_speed_max"], 4),
            direction(random) * random.uniform(0.0, 5.0),
        )


def direction(random: np.random.Generator) -> Reals:
    v = random.normal(size=3)
    return np.asarray(v / np.linalg.norm(v))


class Ours:
    """The vehicle in Skybody."""

    def __init__(self, folder: Path, k: Constants) -> None:
        self.sim = Simulation(str(vehicles.write_scenario(folder, k, lag=0.0)))
        self.sim.reset()
        paths = [p for p in self.sim.compiled.param_paths if p.startswith("effects.wind.velocity")]
        assert len(paths) == 3
        self.wind = paths

    def accelerations(self, at: Flight) -> Reals:
        """One step sets rotor speeds and holds the wind; then the base is teleported."""
        for path, value in zip(self.wind, at.wind, strict=True):
            self.sim.set_param(path, value)
        self.sim.command(at.speeds)
        assert self.sim.advance(1)
        assert np.array_equal(self.sim.rotor_speeds, at.speeds)
        self.sim.teleport([0.0, 0.0, 1.0], at.attitude, at.velocity, at.spin)
        found = self.sim.accelerations()
        return np.concatenate([found.linear[0], found.angular[0]])


def by_rotorpy(vehicle: Any, at: Flight) -> Reals:
    state = {
        "x": np.array([0.0, 0.0, 1.0]),
        "q": at.attitude[[1, 2, 3, 0]],
        "v": at.velocity,
        "w": at.spin,
        "wind": at.wind,
        "rotor_speeds": at.speeds,
    }
    found = vehicle.statedot(state, {"cmd_motor_speeds": at.speeds}, 0.0)
    return np.concatenate([found["vdot"], found["wdot"]])


# RotorPy's files omit flapping, and for the Crazyflie also translational lift and parasitic drag.
# The last case has all terms and an inertia that is not diagonal.
EVERYTHING = {
    "k_flap": 2e-5,
    "k_h": 3e-3,
    "c_Dx": 4e-3,
    "c_Dy": 6e-3,
    "c_Dz": 9e-3,
    "Ixy": 2e-4,
    "Ixz": -1e-4,
    "Iyz": 3e-4,
}


@pytest.mark.parametrize(
    ("name", "changes"),
    [("crazyflie", {}), ("hummingbird", {}), ("hummingbird", EVERYTHING)],
    ids=["crazyflie", "hummingbird", "hummingbird_with_every_term"],
)
def test_accelerations_are_rotorpys(tmp_path: Path, name: str, changes: Constants) -> None:
    k = vehicles.constants_of(name) | changes
    ours, vehicle = Ours(tmp_path, k), multirotor.Multirotor(k)
    random = np.random.default_rng(1)
    worst = 0.0
    for _ in range(STATES):
        at = Flight.draw(random, k)
        worst = max(worst, float(np.abs(ours.accelerations(at) - by_rotorpy(vehicle, at)).max()))
    # Both round differently, and accelerations reach 1e3 rad/s^2: the largest difference is
    # 2.5e-12.
    assert worst < 1e-9
