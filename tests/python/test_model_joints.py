"""Joints about rotors' axes are read as fixed; springs and limits of universal joints."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
import skybody

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"

SPINNING = """\
<robot name="quad"><link name="base_link">
  <inertial><mass value="2"/>
    <inertia ixx="0.0217" ixy="0" ixz="0" iyy="0.0217" iyz="0" izz="0.02168"/></inertial>
</link>
{links}</robot>
"""
# A propeller of negligible weight, so that the whole turns with the base's inertia.
PROPELLER = """\
<link name="rotor_{k}"><inertial><mass value="1e-9"/>
  <inertia ixx="1e-12" ixy="0" ixz="0" iyy="1e-12" iyz="0" izz="1e-12"/></inertial></link>
<joint name="spin_{k}" type="{joint}"><parent link="base_link"/><child link="rotor_{k}"/>
  <origin xyz="{x} {y} 0"/><axis xyz="0 0 1"/>{limit}</joint>
"""
PLACES = [(0.17, -0.17, "ccw"), (-0.17, 0.17, "ccw"), (0.17, 0.17, "cw"), (-0.17, -0.17, "cw")]


@pytest.mark.parametrize(
    ("joint", "limit"),
    [
        ("continuous", ""),
        ("revolute", '<limit lower="-1e16" upper="1e16" effort="0" velocity="0"/>'),
        ("revolute", '<limit lower="0" upper="1000" effort="0" velocity="0"/>'),
    ],
)
def test_rotors_on_free_joints_turn_the_vehicle(joint: str, limit: str, tmp_path: Path) -> None:
    """Joints about a rotor's own axis are read as fixed, including those with limits of many turns.

    After 0.5 s at 800 and 600 rad/s the yaw rate is 2 k_m (600^2 - 800^2) / Izz * 0.5 s = -1.653
    rad/s.
    """
    links = "".join(
        PROPELLER.format(k=k, x=x, y=y, joint=joint, limit=limit)
        for k, (x, y, _) in enumerate(PLACES)
    )
    (tmp_path / "quad.urdf").write_text(SPINNING.format(links=links))
    rotors = "".join(
        f"  - {{name: r{k}, link: rotor_{k}, position: [0, 0, 0], direction: {turn}}}\n"
        for k, (_, _, turn) in enumerate(PLACES)
    )
    constants = "{thrust_constant: 8.5e-6, moment_constant: 1.28e-7, max_speed: 2000}"
    (tmp_path / "rotors.yaml").write_text(f"defaults: {constants}\nrotors:\n{rotors}")
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(
        "robots:\n"
        "  - name: quad\n"
        "    model: quad.urdf\n"
        "    pose: {position: [0, 0, 4]}\n"
        "    controllers: [{plugin: rotor_speed, parameters: {max_speed: 2000}}]\n"
        "task: {plugin: hover}\n"
    )
    done = subprocess.run([PROGRAM, "check", scenario], capture_output=True, text=True, timeout=60)
    told = [line for line in done.stderr.splitlines() if "read as fixed" in line]
    assert len(told) == 1, done.stderr
    assert (
        "the joint `spin_0` is read as fixed: it turns freely about the axis of a rotor" in told[0]
    )
    assert "(and 3 more of this kind, in lines " in told[0]
    assert ", 1 body, " in done.stdout

    envs = skybody.make_vec(str(scenario), 1, overrides=["stepping.action_repeat=500"])
    envs.reset(seed=1)
    speeds = np.array([[800, 800, 600, 600]], np.float32)
    envs.step(speeds / 1000 - 1)
    rate = envs.state("robots.quad.base.angular_velocity")[0]
    assert rate == pytest.approx([0, 0, -1.653], abs=1e-3)


def test_springs_and_limits_act_on_universal_joints(tmp_path: Path) -> None:
    """A pendulum on two crossed pins, each with a rest angle, a spring and limits."""
    (tmp_path / "arm.urdf").write_text(
        '<robot name="arm"><link name="base"><inertial><mass value="1"/>'
        '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>'
        '<link name="cross"/><link name="rod"><inertial><origin xyz="0 0 -0.2"/><mass value="0.1"/>'
        '<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-5"/></inertial></link>'
        '<joint name="x" type="revolute"><parent link="base"/><child link="cross"/>'
        '<axis xyz="1 0 0"/><limit lower="-0.2" upper="0.2"/></joint>'
        '<joint name="y" type="continuous"><parent link="cross"/><child link="rod"/>'
        '<axis xyz="0 1 0"/></joint></robot>'
    )
    (tmp_path / "scenario.yaml").write_text(
        "robots:\n"
        "  - name: arm\n"
        "    model: arm.urdf\n"
        "    fixed_base: true\n"
        "    pose: {position: [0, 0, 2]}\n"
        "    joints:\n"
        "      x: {position: 0.19, damping: 0.005, stiffness: 5, rest: 1}\n"
        "      y: {damping: 0.02, stiffness: 2, rest: 0.5}\n"
        "task: {plugin: watch, parameters: {link: rod}}\n"
    )
    sim = skybody.Simulation(str(tmp_path / "scenario.yaml"))
    sim.reset()
    sim.advance(4000)
    x = float(sim.state("robots.arm.joints.x.position"))
    y = float(sim.state("robots.arm.joints.y.position"))
    weight = 0.1 * 9.81 * 0.2
    assert 0.2 < x < 0.3  # the spring pulls it into its limit, a stop of 1e4 J
    # Equilibrium about y: 2 (0.5 - y) = m g l cos(x) sin(y). A stop acts at a step's end, so that
    # the spring moves x within the step: the error is 1.8e-3 N m at 1 ms, and a quarter of that at
    # half the step.
    assert 2 * (0.5 - y) == pytest.approx(weight * np.cos(x) * np.sin(y), abs=3e-3)
