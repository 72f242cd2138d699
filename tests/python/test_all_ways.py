"""Vehicles with rotors that do not all push upwards: in all directions, reversed, on a servo."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from skybody import InputError, Simulation

PROGRAM = Path(__file__).resolve().parents[2] / "build/release/bin/skybody"
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
    np.testing.assert_allclose(sim.rotor_speeds, np.where(lifting, speed, 0.0), rtol=1e-12)


def test_full_pose_flies_reversible_rotors_to_any_attitude(tmp_path: Path) -> None:
    chain = "[{plugin: full_pose}, {plugin: mixer, parameters: {signal: wrench}}]"
    sim = Simulation(str(cube(tmp_path, -1200, chain)))
    sim.reset()
    roll = np.deg2rad(70.0)
    sim.command([0.5, -0.4, 2.2, np.cos(roll / 2), np.sin(roll / 2), 0, 0])
    assert sim.advance(10_000)
    base = sim.base("cube")
    # There is no disturbance: only the residual after 20 time constants remains.
    np.testing.assert_allclose(base.position, [0.5, -0.4, 2.2], atol=1e-4)
    np.testing.assert_allclose(
        np.abs(base.rotation), [np.cos(roll / 2), np.sin(roll / 2), 0, 0], atol=1e-4
    )
    assert np.min(sim.rotor_speeds) < -100.0  # some turn in reverse


def test_rotors_that_turn_one_way_are_refused_where_they_would_have_to_pull(
    tmp_path: Path,
) -> None:
    chain = "[{plugin: full_pose}, {plugin: mixer, parameters: {signal: wrench}}]"
    with pytest.raises(InputError, match=r"N to hover, and can push 0 to .* `min_speed` below 0"):
        Simulation(str(cube(tmp_path, 0, chain)))


def test_rotors_that_push_downwards_fly_by_least_squares(tmp_path: Path) -> None:
    chain = "[{{plugin: geometric, parameters: {{output: ctbt}}}}, {{plugin: ctbt{}}}]"
    with pytest.raises(InputError, match=r"of rotors that push downwards `allocation: qp` makes"):
        Simulation(str(cube(tmp_path, 0, chain.format(""))))
    file = cube(tmp_path, 0, chain.format(", parameters: {allocation: qp}"))
    sim = Simulation(str(file))
    sim.reset()
    point = [0.3, 0.2, 2.2] + [0.0] * 14
    sim.command(point)
    assert sim.advance(10_000)
    np.testing.assert_allclose(sim.base("cube").position, point[:3], atol=1e-4)


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


def hinged(folder: Path, chain: str) -> Path:
    """Four rotors, each on a hinge rolled by 60 degrees; the rotor axes are upright anyway."""
    roll = np.pi / 3
    links, rotors = "", []
    for i, (x, y) in enumerate([(0.2, 0.2), (0.2, -0.2), (-0.2, 0.2), (-0.2, -0.2)]):
        links += (
            f'<link name="l{i}"><inertial><mass value="0.01"/><inertia ixx="1e-6" ixy="0" '
            'ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/></inertial></link>'
            f'<joint name="j{i}" type="continuous"><parent link="base_link"/><child link="l{i}"/>'
            f'<origin xyz="{x} {y} 0" rpy="{roll} 0 0"/><axis xyz="1 0 0"/></joint>'
        )
        rotors.append(
            f"  - {{name: r{i}, link: l{i}, position: [0, 0, 0], "
            f"axis: [0, {np.sin(roll)}, {np.cos(roll)}], "
            f"direction: {'ccw' if x * y > 0 else 'cw'}}}"
        )
    text = URDF.replace('"1.5"', '"1.0"').replace("</robot>", links + "</robot>")
    (folder / "hinged.urdf").write_text(text)
    (folder / "rotors.yaml").write_text(
        "defaults: {thrust_constant: 1e-5, moment_constant: 1.6e-7, max_speed: 1000}\nrotors:\n"
        + "\n".join(rotors)
        + "\n"
    )
    scenario = folder / "hinged.yaml"
    scenario.write_text(
        "stepping: {dt: 0.001, action_repeat: 10}\n"
        "robots:\n  - name: h\n    model: hinged.urdf\n    pose: {position: [0, 0, 2]}\n"
        f"    rotor_speed: hover\n    controllers: {chain}\n"
        "task: {plugin: hover, parameters: {robot: h, target: [0, 0, 2, 0]}}\n"
    )
    return scenario


def test_hover_takes_the_axes_of_rotors_behind_joints_in_the_frame_of_the_base(
    tmp_path: Path,
) -> None:
    sim = Simulation(str(hinged(tmp_path, "[{plugin: rotor_speed}]")))
    sim.reset()
    np.testing.assert_allclose(sim.rotor_speeds, (1.04 * 9.81 / 4e-5) ** 0.5, rtol=1e-9)


def test_ranges_of_thrust_and_torque_take_hubs_behind_joints_in_the_frame_of_the_base(
    tmp_path: Path,
) -> None:
    sim = Simulation(str(hinged(tmp_path, "[{plugin: ctbt, parameters: {apply: body}}]")))
    high = sim.compiled.action_channels[0].high
    # Four times 10 N; two of them on arms of 0.2 m, and their drag torques of 0.16 N m.
    np.testing.assert_allclose(high, [40.0, 4.0, 4.0, 0.32], rtol=1e-9)


def test_hold_says_that_a_joint_turns_the_thrust_away(tmp_path: Path) -> None:
    file = hinged(tmp_path, "[{plugin: srt}]")
    done = subprocess.run(
        [PROGRAM, "run", file, "--policy", "hold", "--no-picture", "--out", tmp_path / "out"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "rotor `r0` sits behind the joint `j0`, which turns the thrust away" in done.stderr
