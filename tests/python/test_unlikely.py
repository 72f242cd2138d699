"""Warnings about possible but unlikely values.

`skybody check` and loading warn of them and suggest the intended value. One table in
core/io/yaml/plausibility_limits.cpp has the ranges.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
import skybody
from skybody.env import SkybodyEnv

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
  - {{name: a, direction: ccw, position: [{arm}, {arm}, 0]}}
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
    "arm": 0.177,
    "gravity": "[0, 0, -9.81]",
    "rpy": "[0, 0, 0]",
    "yaw": 0.0,
    "heights": "[0, 0, 1, 1]",
}


def warnings(folder: Path, **changes: object) -> list[str]:
    """Warnings of `skybody check` for the quadrotor with some values changed."""
    values = USUAL | changes
    (folder / "quad.urdf").write_text(URDF.format(**values))
    (folder / "rotors.yaml").write_text(ROTORS.format(**values))
    (folder / "scenario.yaml").write_text(SCENARIO.format(**values))
    done = subprocess.run(
        [PROGRAM, "check", "scenario.yaml"], cwd=folder, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return [line.split("warning: ")[1] for line in done.stderr.splitlines()]


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


# ---- joints of rotors

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


# ---- actions and requests


def test_values_beyond_the_range_of_actions_are_counted() -> None:
    envs = skybody.make_vec("hover", 4, num_threads=1)
    envs.reset(seed=1)
    actions = np.zeros((4, 4), np.float32)
    assert "clipped" not in envs.step(actions)[4]
    actions[2] = [1500, -1.5, 1, -1]  # rad/s where -1 to 1 is required
    infos = envs.step(actions)[4]
    assert infos["clipped"].tolist() == [0, 0, 2, 0]
    assert infos["_clipped"].all()
    assert envs.clipped == 2
    assert "clipped" not in envs.step(np.zeros((4, 4), np.float32))[4]

    env = SkybodyEnv("hover")
    env.reset(seed=1)
    assert env.step(np.full(4, 1500, np.float32))[4]["clipped"] == 4

    with skybody.make_pool("hover", 4, batch_size=2, num_threads=1) as pool:
        pool.reset()
        pool.recv()
        pool.send(actions[1:3], [1, 2])
        *_, info = pool.recv()
        assert dict(zip(info["env_id"].tolist(), info["clipped"].tolist(), strict=True)) == {
            1: 0,
            2: 2,
        }


def test_one_number_for_a_vector_is_refused() -> None:
    envs = skybody.make_vec("hover", 2, num_threads=1)
    envs.reset(seed=1)
    with pytest.raises(ValueError, match=r"`gravity` has 3 values, and one number is given: give "):
        envs.request(None, {"gravity": -9.81})
    with pytest.raises(ValueError, match=r"or name one of them, such as `.*\.com\[0\]`"):
        envs.request(None, {"robots.quad.links.base_link.com": 0.0})
    envs.request(None, {"gravity[2]": -9.0, "robots.quad.links.base_link.mass": 1.5})
    envs.request(None, {"robots.quad.rotors[*].thrust_constant": 2e-6})


LISTS = {  # a word of each, and the list
    "infos": ("gravity", "[gravity]"),
    "sensors": ("imu", "[{plugin: imu, parameters: {link: base_link}}]"),
    "effects": ("wind", "[{plugin: wind}]"),
    "obstacles": ("ball", "[{name: ball, sphere: 0.1, position: [50, 0, 50]}]"),
    "couplings": ("tether", "[{name: tether, kind: rope, ends: [{robot: quad}, {}]}]"),
}


@pytest.mark.parametrize("empty", ["[]", "~", ""])
@pytest.mark.parametrize("key", LISTS)
def test_lists_can_be_emptied(key: str, empty: str) -> None:
    word, full = LISTS[key]
    overrides = [f"{key}={full}"]
    assert word in skybody.CompiledScenario("hover", overrides).scenario_text
    assert (
        word not in skybody.CompiledScenario("hover", [*overrides, f"{key}={empty}"]).scenario_text
    )


# ---- skybody new vehicle

LONGER = ["--set", "stepping.horizon=20000"]
VEHICLES = {
    "racer": ["--mass", "0.45", "--arm", "0.11", "--thrust-to-weight", "6"],
    "hexa": ["--mass", "3", "--arm", "0.35", "--thrust-to-weight", "2.2", "--rotors", "6"],
    "plus": ["--mass", "0.03", "--arm", "0.05", "--thrust-to-weight", "1.9", "--layout", "plus"],
    "octo": ["--mass", "15", "--arm", "0.6", "--thrust-to-weight", "2", "--rotors", "8"],
}


@pytest.mark.parametrize("name", VEHICLES)
def test_a_new_vehicle_passes_check_and_hovers(name: str, tmp_path: Path) -> None:
    made = subprocess.run(
        [PROGRAM, "new", "vehicle", name, *VEHICLES[name], "--dir", tmp_path],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert made.returncode == 0, made.stderr
    folder = tmp_path / name
    files = sorted(f.name for f in folder.iterdir())
    assert files == sorted(["README.md", f"{name}.urdf", "rotors.yaml", "scenario.yaml"])
    assert "@" not in "".join(f.read_text() for f in folder.iterdir())
    checked = subprocess.run(
        [PROGRAM, "check", folder / "scenario.yaml"], capture_output=True, text=True, timeout=60
    )
    assert (checked.returncode, checked.stderr) == (0, "")
    flown = subprocess.run(
        [
            PROGRAM,
            "run",
            "scenario.yaml",
            "--policy",
            "hold",
            "--no-picture",
            "--out",
            "flight",
            *LONGER,
        ],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert flown.returncode == 0, flown.stderr
    row = next(line for line in flown.stdout.splitlines() if re.match(r"\s*1 ", line))
    assert "truncated" in row
    # Mean error [mm] over the last second. `hold` moves the largest vehicle slowly: 6 mm remain.
    assert float(row.split()[-3]) < 10.0, flown.stdout


def test_a_new_vehicle_needs_its_numbers(tmp_path: Path) -> None:
    command = [PROGRAM, "new", "vehicle", "--dir", tmp_path]
    missing = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert missing.returncode == 2
    assert "--mass is missing" in missing.stderr
    odd = subprocess.run(
        [*command, *VEHICLES["racer"], "--rotors", "5"], capture_output=True, text=True, timeout=60
    )
    assert "5 rotors cannot turn half one way and half the other" in odd.stderr


def test_an_impossible_vehicle_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    command = [PROGRAM, "new", "vehicle", "--dir", tmp_path, "--thrust-to-weight", "6"]
    for numbers, expected in (
        (
            ["--mass", "450", "--arm", "0.11"],
            "error: a vehicle of 450 kg on arms of 0.11 m would need rotors with a `max_speed` of "
            "103790 rad/s; allowed: 0.001 to 100000; give --mass and --arm that fit one another\n",
        ),
        (
            ["--mass", "1", "--arm", "10"],
            "on arms of 10 m would need rotors with a `thrust_constant`",
        ),
    ):
        done = subprocess.run([*command, *numbers], capture_output=True, text=True, timeout=60)
        assert done.returncode == 2
        assert expected in done.stderr
    assert list(tmp_path.iterdir()) == []
