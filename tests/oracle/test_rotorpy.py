"""Accelerations in moving air against RotorPy's own, with its Crazyflie and its Hummingbird.

S. Folk, J. Paulos, V. Kumar, "RotorPy: A Python-based Multirotor Simulator with Aerodynamics for
Education and Research", 2023. A model is written from its numbers: one link, rotors without
inertia (RotorPy has no gyroscopic term) that reach their command within a step. Its induced drag
k_z, flapping k_flap and translational lift k_h are the effect blade_flapping, its parasitic drag
c_D is the effect body_drag, its rotor drag k_d is `drag_constant` of the rotors file. Its rotor
directions are those of the reaction on the vehicle, so the opposite of ours.
"""

from __future__ import annotations

import dataclasses
import importlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from skybody import Simulation

multirotor: Any = importlib.import_module("rotorpy.vehicles.multirotor")

Reals = NDArray[np.float64]
Constants = dict[str, Any]

STATES = 10_000
URDF = """<?xml version="1.0"?>
<robot name="vehicle">
  <link name="base">
    <inertial>
      <mass value="{mass!r}"/>
      <inertia ixx="{Ixx!r}" iyy="{Iyy!r}" izz="{Izz!r}" ixy="{Ixy!r}" ixz="{Ixz!r}" iyz="{Iyz!r}"/>
    </inertial>
  </link>
</robot>
"""


def constants_of(vehicle: str) -> Constants:
    """RotorPy's parameter file of a vehicle."""
    module: Any = importlib.import_module(f"rotorpy.vehicles.{vehicle}_params")
    return dict(module.quad_params)


def rotors_file(k: Constants) -> dict[str, Any]:
    """Numbers become text and numbers again with the same bits."""
    defaults = {
        "thrust_constant": float(k["k_eta"]),
        "moment_constant": float(k["k_m"]),
        "drag_constant": float(k["k_d"]),
        "inertia": 0.0,
        "max_speed": float(k["rotor_speed_max"]),
        "tau_up": 0.0,
        "tau_down": 0.0,
    }
    rotors = [
        {
            "name": name,
            "link": "base",
            "position": [float(x) for x in place],
            "direction": "cw" if turn > 0 else "ccw",
        }
        for (name, place), turn in zip(k["rotor_pos"].items(), k["rotor_directions"], strict=True)
    ]
    return {"defaults": defaults, "rotors": rotors}


def scenario(k: Constants) -> dict[str, Any]:
    drag = [float(k[f"c_D{axis}"]) for axis in "xyz"]
    air = {
        "axial_drag": float(k["k_z"]),
        "flapping": float(k["k_flap"]),
        "translational_lift": float(k["k_h"]),
    }
    return {
        "stepping": {"dt": 0.001, "action_repeat": 1},
        "contact": {"ground": False},
        "robots": [
            {
                "name": "vehicle",
                "model": "vehicle.urdf",
                "rotors": "rotors.yaml",
                "controllers": [{"plugin": "rotor_speed"}],
            }
        ],
        "effects": [
            {"plugin": "wind"},
            {"plugin": "body_drag", "parameters": {"quadratic": drag}},
            {"plugin": "blade_flapping", "parameters": air},
        ],
        "task": {"plugin": "watch", "parameters": {"link": "base"}},
    }


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
    """The vehicle here."""

    def __init__(self, folder: Path, k: Constants) -> None:
        (folder / "vehicle.urdf").write_text(URDF.format(**k))
        (folder / "rotors.yaml").write_text(yaml.safe_dump(rotors_file(k)))
        (folder / "flight.yaml").write_text(yaml.safe_dump(scenario(k)))
        self.sim = Simulation(str(folder / "flight.yaml"))
        self.sim.reset()
        paths = [p for p in self.sim.compiled.param_paths if p.startswith("effects.wind.velocity")]
        assert len(paths) == 3
        self.wind = paths

    def accelerations(self, at: Flight) -> Reals:
        """One step brings rotors to their speeds and holds the wind; then the base is put there."""
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


# The moment of inertia of RotorPy's Crazyflie about z is above the sum of the others, which no body
# has and Skybody refuses: both sides get a smaller one.
CRAZYFLIE = {"Izz": 2.85e-5}
# RotorPy's files leave flapping out, and of the Crazyflie translational lift and parasitic drag:
# the last case has all terms and an inertia that is not diagonal.
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
    [("crazyflie", CRAZYFLIE), ("hummingbird", {}), ("hummingbird", EVERYTHING)],
    ids=["crazyflie", "hummingbird", "hummingbird_with_every_term"],
)
def test_accelerations_are_rotorpys(tmp_path: Path, name: str, changes: Constants) -> None:
    k = constants_of(name) | changes
    ours, vehicle = Ours(tmp_path, k), multirotor.Multirotor(k)
    random = np.random.default_rng(1)
    worst = 0.0
    for _ in range(STATES):
        at = Flight.draw(random, k)
        worst = max(worst, float(np.abs(ours.accelerations(at) - by_rotorpy(vehicle, at)).max()))
    # Both round differently, and accelerations are up to 1e3 rad/s^2: the worst is 2.5e-12.
    assert worst < 1e-9
