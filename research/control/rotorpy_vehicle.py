"""Vehicles of RotorPy as Skybody scenarios, for comparisons.

S. Folk, J. Paulos, V. Kumar, "RotorPy: A Python-based Multirotor Simulator with Aerodynamics for
Education and Research", 2023. A model is written from its numbers: one link, rotors without
inertia (RotorPy has no gyroscopic term). Its induced drag k_z, flapping k_flap and translational
lift k_h are the effect blade_flapping, its parasitic drag c_D is the effect body_drag, its rotor
drag k_d is `drag_constant` of the rotors file. Its rotor directions are those of the reaction on
the vehicle, so the opposite of ours.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import yaml

Constants = dict[str, Any]

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

# The moment of inertia of RotorPy's Crazyflie about z exceeds the sum of the others, which is not
# physical and is an error in Skybody: both sides get a smaller one.
CORRECTIONS: dict[str, Constants] = {"crazyflie": {"Izz": 2.85e-5}}


def constants_of(vehicle: str) -> Constants:
    """RotorPy's parameter file of a vehicle, with a physical inertia."""
    module: Any = importlib.import_module(f"rotorpy.vehicles.{vehicle}_params")
    return dict(module.quad_params) | CORRECTIONS.get(vehicle, {})


def rotors_file(k: Constants, lag: float) -> dict[str, Any]:
    """Converts numbers to text that reads back with the same bits. @param lag of rotors [s]"""
    defaults = {
        "thrust_constant": float(k["k_eta"]),
        "moment_constant": float(k["k_m"]),
        "drag_constant": float(k["k_d"]),
        "inertia": 0.0,
        "max_speed": float(k["rotor_speed_max"]),
        "tau_up": lag,
        "tau_down": lag,
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


def write_scenario(folder: Path, k: Constants, lag: float) -> Path:
    """Writes model, rotors and scenario. @returns the scenario's file"""
    (folder / "vehicle.urdf").write_text(URDF.format(**k))
    (folder / "rotors.yaml").write_text(yaml.safe_dump(rotors_file(k, lag)))
    (folder / "flight.yaml").write_text(yaml.safe_dump(scenario(k)))
    return folder / "flight.yaml"
