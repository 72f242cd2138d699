"""`allocation: qp` against SciPy's bounded least squares, at random commands of four vehicles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from scipy.optimize import lsq_linear
from skybody import Simulation

Reals = NDArray[np.float64]
COMMANDS = 1000
THRUST_CONSTANT, MOMENT_CONSTANT, MAX_SPEED = 8.5e-6, 1.4e-7, 900.0
WEIGHTS = np.array([10.0, 100.0, 100.0, 1.0]) / 100.0
TIE_BREAK = 1e-8
URDF = """<?xml version="1.0"?>
<robot name="vehicle">
  <link name="base">
    <inertial>
      <origin xyz="0.01 -0.02 0.005"/>
      <mass value="2"/>
      <inertia ixx="0.03" iyy="0.04" izz="0.06" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
</robot>
"""
COM = np.array([0.01, -0.02, 0.005])


def hubs(arms: int, layers: int) -> tuple[Reals, Reals]:
    """Rotor positions, and alternating directions +1 and -1; the lower layer has opposite ones."""
    angle = 2.0 * np.pi * (np.arange(arms) + 0.5) / arms
    ring = np.column_stack([0.25 * np.cos(angle), 0.25 * np.sin(angle), np.zeros(arms)])
    sense = np.where(np.arange(arms) % 2 == 0, 1.0, -1.0)
    places = [ring - [0.0, 0.0, 0.1 * layer] for layer in range(layers)]
    return np.vstack(places), np.concatenate([sense * (-1.0) ** k for k in range(layers)])


def write_model(folder: Path, places: Reals, senses: Reals, axes: Reals) -> Path:
    (folder / "vehicle.urdf").write_text(URDF)
    rotors = [
        {
            "name": f"rotor{i}",
            "link": "base",
            "position": place.tolist(),
            "axis": axis.tolist(),
            "direction": "ccw" if sense > 0 else "cw",
        }
        for i, (place, sense, axis) in enumerate(zip(places, senses, axes, strict=True))
    ]
    defaults = {
        "thrust_constant": THRUST_CONSTANT,
        "moment_constant": MOMENT_CONSTANT,
        "max_speed": MAX_SPEED,
    }
    text = yaml.safe_dump({"source": "test", "defaults": defaults, "rotors": rotors})
    (folder / "rotors.yaml").write_text(text)
    return folder / "vehicle.urdf"


@pytest.mark.parametrize(
    ("arms", "layers", "tilt"), [(4, 1, 0.0), (6, 1, 0.0), (4, 2, 0.0), (6, 1, 0.35)]
)
def test_thrusts_are_those_of_bounded_least_squares(
    tmp_path: Path, arms: int, layers: int, tilt: float
) -> None:
    places, senses = hubs(arms, layers)
    turn = np.where(np.arange(len(places)) % 2 == 0, tilt, -tilt)
    around = np.column_stack([-places[:, 1], places[:, 0], 0.0 * turn]) / 0.25
    axes = around * np.sin(turn)[:, None] + np.column_stack([0 * turn, 0 * turn, np.cos(turn)])
    reaction = -senses * MOMENT_CONSTANT / THRUST_CONSTANT
    torque = np.cross(places - COM, axes) + axes * reaction[:, None]
    effect = np.vstack([axes[:, 2], torque.T])

    full = THRUST_CONSTANT * MAX_SPEED**2
    up, down = np.maximum(torque, 0.0).sum(axis=0), np.maximum(-torque, 0.0).sum(axis=0)
    scale = np.concatenate([[axes[:, 2].sum() * full], np.minimum(up, down) * full])
    rows = np.vstack(
        [WEIGHTS[:, None] * effect * full / scale[:, None], np.sqrt(TIE_BREAK) * np.eye(len(axes))]
    )
    inverse = np.linalg.pinv(effect)

    sim = Simulation(
        "hover",
        control="[{plugin: ctbt, parameters: {allocation: qp}}]",
        overrides=[f"robots[0].model={write_model(tmp_path, places, senses, axes)}"],
    )
    sim.reset()
    generator = np.random.default_rng(7)
    beyond = 0
    for _ in range(COMMANDS):
        wish = scale * generator.uniform([0.0, -1.2, -1.2, -1.2], [1.0, 1.2, 1.2, 1.2])
        free = inverse @ wish
        right = np.concatenate([WEIGHTS * wish / scale, np.sqrt(TIE_BREAK) * free / full])
        best = lsq_linear(rows, right, (0.0, 1.0), method="bvls", tol=1e-15)
        beyond += bool((free < 0.0).any() or (free > full).any())
        sim.teleport(position=[0, 0, 50], rotation=[1, 0, 0, 0], velocity=[0] * 3)
        sim.command(wish)
        assert sim.advance(1)
        speeds = np.array(sim.state("robots.quad.rotors.command"))
        # Both solve equations with a condition number of at most 1e8.
        np.testing.assert_allclose(THRUST_CONSTANT * speeds**2, best.x * full, atol=1e-6 * full)
    assert beyond > COMMANDS // 2
