"""Warnings about possible but unlikely values.

`skybody check` and loading warn of them and suggest the intended value. One table in
core/io/yaml/plausibility_limits.cpp has the ranges.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"

# 2 kg on arms of 0.25 m: thrust to weight 4 * 8.5e-6 * 1100^2 / (2 * 9.81) = 2.1.
URDF = """\
<robot name="quad"><link name="base_link">
  <inertial><mass value="{mass}"/>
    <inertia ixx="{ixx}" ixy="0" ixz="0" iyy="{ixx}" iyz="0" izz="{izz}"/></inertial>
  <collision><geometry><box size="{size} 0.2 0.1"/></geometry></collision>
</link></robot>
"""
ROTORS = """\
defaults:
  thrust_constant: {thrust}
  moment_constant: {moment}
  max_speed: {speed}
  tau_up: {tau_up}
  tau_down: {tau_down}{more}
rotors:
  - {{name: a, direction: {turn}, position: [{arm}, {arm}, 0]}}
  - {{name: b, direction: cw, position: [-{arm}, {arm}, 0]}}
  - {{name: c, direction: ccw, position: [-{arm}, -{arm}, 0]}}
  - {{name: d, direction: cw, position: [{arm}, -{arm}, 0]}}
"""
SCENARIO = """\
gravity: {gravity}
robots:
  - name: quad
    model: quad.urdf
    pose: {{position: [0, 0, 3], rpy: {rpy}}}
    controllers: [{{plugin: ctbr}}]
obstacles: [{{name: hill, position: [500, 0, 0], height_field:
  {{size: [2, 2], columns: 2, heights: {heights}}}}}]
task: {{plugin: hover, parameters: {{target: [0, 0, 3, {yaw}]}}}}
"""
USUAL = {
    "mass": 2.0,
    "ixx": 0.0217,
    "izz": 0.04,
    "size": 0.2,
    "thrust": 8.5e-6,
    "moment": 1.36e-7,
    "speed": 1100,
    "tau_up": 0.0125,
    "tau_down": 0.025,
    "more": "",
    "turn": "ccw",
    "arm": 0.177,
    "gravity": "[0, 0, -9.81]",
    "rpy": "[0, 0, 0]",
    "yaw": 0.0,
    "heights": "[0, 0, 1, 1]",
}


def warnings(folder: Path, **changes: object) -> list[str]:
    """Warnings of `skybody check` for the quadrotor with some values changed, without places."""
    return [line.split("warning: ")[1] for line in lines_of_check(folder, **changes)]


def lines_of_check(folder: Path, **changes: object) -> list[str]:
    """Lines of `skybody check` for the quadrotor with some values changed."""
    values = USUAL | changes
    (folder / "quad.urdf").write_text(URDF.format(**values))
    (folder / "rotors.yaml").write_text(ROTORS.format(**values))
    (folder / "scenario.yaml").write_text(SCENARIO.format(**values))
    done = subprocess.run(
        [PROGRAM, "check", "scenario.yaml"], cwd=folder, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return done.stderr.splitlines()


def test_usual_values_cause_no_warning(tmp_path: Path) -> None:
    assert warnings(tmp_path) == []


MISTAKES = {
    "rpm_for_rad_s": (
        {"speed": 10504},
        "thrust to weight of the robot `quad` is 191.2; usual is 1.1 to 20; do you mean "
        "`max_speed: 1100` (rpm written for rad/s)?",
    ),
    "too_weak": (
        {"speed": 700},
        "thrust to weight of the robot `quad` is 0.8491; usual is 1.1 to 20",
    ),
    "too_weak_backwards": (
        {"more": "\n  axis: [0, 0, -1]\n  min_speed: -700"},
        "thrust to weight of the robot `quad` is 0.8491; usual is 1.1 to 20",
    ),
    "wrong_direction": (
        {"turn": "cw"},
        "hover thrust (from `position` and `direction` of all rotors), relative to the largest, "
        "of the rotor `b` of the robot `quad` is 0; usual is 0.05 to 1",
    ),
    "ms_for_s": (
        {"tau_up": 20},
        "`tau_up` of the rotor `a` of the robot `quad` is 20 s; usual is 0 to 0.5 s; do you mean "
        "0.02 (ms written for s)?",
    ),
    "slow_rotors": (
        {"tau_down": 0.8},
        "`tau_down` of the rotor `a` of the robot `quad` is 0.8 s; usual is 0 to 0.5 s; do you "
        "mean 0.0008 (ms written for s)?",
    ),
    "length_for_moment_constant": (
        {"moment": 0.016},
        "`moment_constant` [N m s^2/rad^2] by `thrust_constant` of the rotor `a` of the robot "
        "`quad` is 1882 m; usual is 0.001 to 1 m; do you mean `moment_constant: 1.36e-07` (RotorS "
        "and PX4 write drag torque by thrust, a length)?",
    ),
    "no_drag_torque": (
        {"moment": 1e-10},
        "`moment_constant` [N m s^2/rad^2] by `thrust_constant` of the rotor `a` of the robot "
        "`quad` is 1.176e-05 m; usual is 0.001 to 1 m",
    ),
    "g_cm2_for_kg_m2": (
        {"ixx": 217000, "izz": 400000},
        "radius of gyration (ixx) by the longest arm of the robot `quad` is 1316; usual is 0.1 to "
        "3; do you mean `inertia: 0.0217` (g cm^2 written for kg m^2)?",
    ),
    "mm_for_m_in_rotors": (
        {"arm": 177},
        "the longest arm of a rotor of the robot `quad` is 250.3 m; usual is 0 to 15 m; do you "
        "mean `position: 0.2503` (mm written for m)?",
    ),
    "kg_mm2_for_kg_m2": (
        {"ixx": 21700, "izz": 40000},
        "radius of gyration (ixx) by the longest arm of the robot `quad` is 416.1; usual is 0.1 to "
        "3; do you mean `inertia: 0.0217` (kg mm^2 written for kg m^2)?",
    ),
    "kg_cm2_for_kg_m2": (
        {"ixx": 217, "izz": 400},
        "radius of gyration (ixx) by the longest arm of the robot `quad` is 41.61; usual is 0.1 to "
        "3; do you mean `inertia: 0.0217` (kg cm^2 written for kg m^2)?",
    ),
    "mm_for_m_in_shapes": (
        {"size": 200},
        "the longest collision shape of the robot `quad` is 200 m; usual is 0 to 20 m; do you mean "
        "0.2 (mm written for m)?",
    ),
    "cm_for_m_in_rotors": (
        {"arm": 17.7},
        "the longest arm of a rotor of the robot `quad` is 25.03 m; usual is 0 to 15 m; do you "
        "mean `position: 0.2503` (cm written for m)?",
    ),
    "cm_for_m_in_small_rotors": (
        {"arm": 5},
        "radius of gyration (ixx) by the longest arm of the robot `quad` is 0.01473; usual is 0.1 "
        "to 3; do you mean `position: 0.07071` (cm written for m)?",
    ),
    "cm_for_m_in_shapes": (
        {"size": 30},
        "the longest collision shape of the robot `quad` is 30 m; usual is 0 to 20 m; do you mean "
        "0.3 (cm written for m)?",
    ),
    "gravity_upwards": (
        {"gravity": "[0, 0, 9.81]"},
        "`gravity[2]` is 9.81 m/s^2; usual is -30 to 0 m/s^2; do you mean -9.81 (z of the world "
        "points up)?",
    ),
    "degrees_in_a_pose": (
        {"rpy": "[0, 0, 25]"},
        "`rpy[2]` is 25 rad; usual is -12.6 to 12.6 rad; do you mean 0.4363 (degrees written for "
        "radians)?",
    ),
    "degrees_in_a_target": (
        {"yaw": 45},
        "`target[3]` is 45 rad; usual is -12.6 to 12.6 rad; do you mean 0.7854 (degrees written "
        "for radians)?",
    ),
    "heights_in_mm": (
        {"heights": "[0, 0, 1e6, 0]"},
        "the height farthest from 0 is 1e+06 m; usual is -1.1e+04 to 9000 m; do you mean 1000 (mm "
        "written for m)?",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told_with_value_range_and_what_was_meant(name: str, tmp_path: Path) -> None:
    changes, expected = MISTAKES[name]
    assert expected in warnings(tmp_path, **changes)


PLACES = {
    "rotors.yaml:4:14": {"speed": 10504},
    "rotors.yaml:5:11": {"tau_up": 20},
    "rotors.yaml:3:20": {"moment": 0.016},
    "rotors.yaml:8:41": {"arm": 177},
    "rotors.yaml:8:14": {"more": "\n  axis: [0, 0, -1]\n  min_speed: -700"},
    "quad.urdf:2:13": {"mass": 2000},
    "quad.urdf:3:5": {"ixx": 21700, "izz": 40000},
    "quad.urdf:4:24": {"size": 200},
    "scenario.yaml:1:10": {"gravity": "[0, 0, 9.81]"},
}


@pytest.mark.parametrize("place", PLACES)
def test_a_warning_points_at_the_value_in_its_file(place: str, tmp_path: Path) -> None:
    lines = lines_of_check(tmp_path, **PLACES[place])
    assert any(line.startswith(f"{place}: warning: ") for line in lines), lines


def test_robots_that_are_alike_are_told_of_once(tmp_path: Path) -> None:
    warnings(tmp_path, tau_up=20)
    text = (tmp_path / "scenario.yaml").read_text().replace("obstacles", "#")
    robot = re.search(r"  - name: quad\n(.*\n){3}", text)
    assert robot is not None
    text = text.replace(robot[0], robot[0] + robot[0].replace("quad\n", "other\n", 1))
    (tmp_path / "two.yaml").write_text(
        re.sub(r"#.*\n.*\n", "", text).replace("[0, 0, 3]", "[0, 0, 3]")
    )
    done = subprocess.run(
        [PROGRAM, "check", "two.yaml", "--set", "robots.other.pose.position=[5, 0, 3]"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
    )
    told = [line for line in done.stderr.splitlines() if "tau_up" in line]
    assert len(told) == 1, done.stderr
    assert "(and 1 more of this kind" in told[0]


def test_inertia_repair_is_a_key_of_the_robot(tmp_path: Path) -> None:
    warnings(tmp_path)
    values = USUAL | {"ixx": 0.0217, "izz": 0.05}
    (tmp_path / "quad.urdf").write_text(URDF.format(**values))
    command = [PROGRAM, "check", "scenario.yaml"]
    refused = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert refused.returncode == 2
    assert "izz must not exceed ixx + iyy, 0.0434; `inertia: repair`" in refused.stderr
    mended = subprocess.run(
        [*command, "--set", "robots.quad.inertia=repair"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert mended.returncode == 0, mended.stderr
    assert "`inertia: repair` gives the link `base_link` the principal moments" in mended.stderr
