"""Vehicles whose rotors do not all push upwards: in all directions, backwards, on a servo."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from skybody import Simulation, SkybodyError

URDF = """<robot name="cube">
  <link name="base_link"><inertial><mass value="1.5"/>
    <inertia ixx="0.012" ixy="0" ixz="0" iyy="0.012" iyz="0" izz="0.012"/></inertial></link>
</robot>
"""
A, B, C = 0.5 + 12**-0.5, 0.5 - 12**-0.5, 3**-0.5
AXES = [(-A, B, C), (B, A, -C), (-B, -A, -C), (A, -B, C)]
K_F = 1e-5


def cube(folder: Path, min_speed: float, chain: str) -> Path:
    """Eight rotors on the corners of a cube; half of them push downwards."""
    rotors = []
    for i in range(8):
        at = [0.2 if i & bit else -0.2 for bit in (1, 2, 4)]
        axis = AXES[i if i < 4 else 7 - i]
        rotors.append(
            f"  - {{name: r{i}, position: {at}, axis: {list(axis)}, "
            f"direction: {'ccw' if i % 2 else 'cw'}}}"
        )
    (folder / "cube.urdf").write_text(URDF)
    (folder / "rotors.yaml").write_text(
        f"defaults: {{thrust_constant: {K_F}, moment_constant: 1.6e-7, max_speed: 1200, "
        f"min_speed: {min_speed}, tau_up: 0.0125, tau_down: 0.025}}\nrotors:\n"
        + "\n".join(rotors)
        + "\n"
    )
    scenario = folder / "cube.yaml"
    scenario.write_text(
        "stepping: {dt: 0.001, action_repeat: 10}\n"
        "robots:\n  - name: cube\n    model: cube.urdf\n    pose: {position: [0, 0, 2]}\n"
        f"    rotor_speed: hover\n    controllers: {chain}\n"
        "task: {plugin: hover, parameters: {robot: cube, target: [0, 0, 2, 0]}}\n"
    )
    return scenario


def test_hover_is_the_speed_of_the_rotors_that_lift(tmp_path: Path) -> None:
    sim = Simulation(str(cube(tmp_path, 0, "[{plugin: rotor_speed}]")))
    sim.reset()
    speed = (1.5 * 9.81 / (4 * C * K_F)) ** 0.5
    lifting = np.array([AXES[i if i < 4 else 7 - i][2] > 0 for i in range(8)])
    np.testing.assert_allclose(sim.rotor_speeds(), np.where(lifting, speed, 0.0), rtol=1e-12)


def test_full_pose_flies_reversible_rotors_to_any_attitude(tmp_path: Path) -> None:
    chain = "[{plugin: full_pose}, {plugin: mixer, parameters: {signal: wrench}}]"
    sim = Simulation(str(cube(tmp_path, -1200, chain)))
    sim.reset()
    roll = np.deg2rad(70.0)
    sim.command([0.5, -0.4, 2.2, np.cos(roll / 2), np.sin(roll / 2), 0, 0])
    assert sim.advance(10_000)
    base = sim.base("cube")
    # Nothing disturbs it: what is left of the step after 20 time constants.
    np.testing.assert_allclose(base.position, [0.5, -0.4, 2.2], atol=1e-4)
    np.testing.assert_allclose(
        np.abs(base.rotation), [np.cos(roll / 2), np.sin(roll / 2), 0, 0], atol=1e-4
    )
    assert np.min(sim.rotor_speeds()) < -100.0  # some turn backwards


def test_rotors_that_turn_one_way_are_refused_where_they_would_have_to_pull(
    tmp_path: Path,
) -> None:
    chain = "[{plugin: full_pose}, {plugin: mixer, parameters: {signal: wrench}}]"
    with pytest.raises(SkybodyError, match=r"N to hover, and can push 0 to .* `min_speed` below 0"):
        Simulation(str(cube(tmp_path, 0, chain)))


def test_a_tricopter_hovers_and_turns() -> None:
    sim = Simulation("tricopter", overrides=["randomization=[]"])
    sim.reset()
    point = [0.0] * 17
    point[:3] = [0.2, 0.3, 2.1]
    point[15] = 0.8
    sim.command(point)
    assert sim.advance(15_000)
    base = sim.base("tricopter")
    np.testing.assert_allclose(base.position, point[:3], atol=0.01)
    w, _, _, z = base.rotation
    assert abs(2 * np.arctan2(z, w) - 0.8) < 0.01
