"""Effects, arms beside live rotors and tilted rotors, from files as a user writes them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import skybody
from skybody import CompiledScenario, InputError, Simulation

ROOT = Path(__file__).resolve().parents[2]
MODELS = ROOT / "scenarios/models"

WINDY = """
include: hover
randomization: []
effects:
  - plugin: wind
    parameters: {{velocity: [{speed}, 0, 0]}}
"""

ARM = """
  <link name="arm">
    <inertial>
      <origin xyz="0 0 -0.1"/>
      <mass value="0.1"/>
      <inertia ixx="0.0004" ixy="0" ixz="0" iyy="0.0004" iyz="0" izz="0.00004"/>
    </inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="base_link"/>
    <child link="arm"/>
    <origin xyz="0 0 -0.05"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" effort="1" velocity="10"/>
  </joint>
</robot>
"""

ARMED = """
stepping: {dt: 0.001, action_repeat: 1}
robots:
  - name: quad
    model: quad_arm.urdf
    rotors: ROTORS
    pose: {position: [0, 0, 2]}
    rotor_speed: hover
    joints: {shoulder: {position: 0.3}}
    controllers:
      - {plugin: ctbr}
      - {plugin: joint, parameters: {joints: [shoulder], mode: MODE, effort_limit: 0.5, SERVO}}
task: {plugin: hover}
"""


def windy(folder: Path, speed: float) -> Simulation:
    file = folder / f"windy_{speed}.yaml"
    file.write_text(WINDY.format(speed=speed))
    return Simulation(str(file), control="ctbr")


def armed(folder: Path, mode: str = "effort", servo: str = "tau: 0") -> str:
    urdf = (MODELS / "qdrone2/qdrone2.urdf").read_text().replace("</robot>", ARM)
    (folder / "quad_arm.urdf").write_text(urdf)
    text = ARMED.replace("ROTORS", str(MODELS / "qdrone2/rotors.yaml"))
    file = folder / f"armed_{mode}.yaml"
    file.write_text(text.replace("MODE", mode).replace("SERVO", servo))
    return str(file)


def shoulder(sim: Simulation) -> float:
    """Angle of the arm about the base's y axis [rad]."""
    base, arm = (np.asarray(sim.body(name).rotation) for name in ("base_link", "arm"))
    w = base @ arm
    v = base[0] * arm[1:] - arm[0] * base[1:] - np.cross(base[1:], arm[1:])
    return 2.0 * math.atan2(v[1], w)


def test_wind_carries_a_vehicle_along(tmp_path: Path) -> None:
    ways = []
    for speed in (0.0, 5.0):
        sim = windy(tmp_path, speed)
        sim.reset()
        weight = sum(sim.param(p) for p in sim.compiled.param_paths if p.endswith(".mass"))
        sim.command([weight * 9.81, 0.0, 0.0, 0.0])
        sim.advance(1000)
        ways.append(sim.body("base_link").position[0])
    assert abs(ways[0]) < 1e-9
    assert ways[1] > 0.05  # rotor drag, 5 m/s, 1.54 kg, one second


def test_wind_is_in_state_and_hash(tmp_path: Path) -> None:
    hashes = []
    for speed in (0.0, 5.0):
        sim = windy(tmp_path, speed)
        sim.reset()
        sim.advance(10)
        sim.evaluate()
        hashes.append(sim.hash())
    assert hashes[0] != hashes[1]


def test_a_table_of_wind_lies_beside_the_scenario_that_names_it(tmp_path: Path) -> None:
    (tmp_path / "gusts.csv").write_text("t,x,y,z\n0,5,0,0\n10,5,0,0\n")
    ways = []
    for effect in ("{velocity: [5, 0, 0]}", "{file: gusts.csv}"):
        plugin = "wind_table" if "file" in effect else "wind"
        file = tmp_path / f"{plugin}.yaml"
        file.write_text(
            "include: hover\n"
            f"randomization: []\n"
            f"effects: [{{plugin: {plugin}, parameters: {effect}}}]\n"
        )
        sim = Simulation(str(file), control="ctbr")
        sim.reset()
        sim.advance(100)
        ways.append(list(sim.body("base_link").position))
    assert ways[0] == ways[1]
    assert ways[0][0] > 0.0
    with pytest.raises(InputError, match=r"gusts2\.csv: there is no such file"):
        CompiledScenario(str(file), overrides=["effects[0].parameters.file=gusts2.csv"])


def test_states_have_the_wind_and_the_gains_of_all_effects(tmp_path: Path) -> None:
    file = tmp_path / "windy.yaml"
    file.write_text(
        "include: hover\n"
        "effects:\n"
        "  - {plugin: wind, parameters: {velocity: [2, 0, 0]}}\n"
        "  - {plugin: wind, name: other, parameters: {velocity: [0, 0, -1]}}\n"
        "  - {plugin: thrust_curve, parameters: {thrust: [0, 0, 4.0e-6]}}\n"
    )
    sim = Simulation(str(file), control="ctbr")
    sim.reset()
    sim.advance(1)
    assert list(sim.state("robots.quad.links.base_link.wind")) == [2.0, 0.0, -1.0]
    gain = sim.state("robots.quad.rotors[0].thrust_gain")
    assert gain == pytest.approx(4.0e-6 / sim.param("robots.quad.rotors[0].thrust_constant"))
    assert sim.state("robots.quad.rotors.front_left.thrust_gain") == gain
    assert "robots.quad.links.base_link.wind" not in Simulation("hover").state_paths()


def test_turbulence_is_reported_for_every_robot(tmp_path: Path) -> None:
    file = tmp_path / "turbulent.yaml"
    file.write_text("include: formation_2\neffects: [{plugin: dryden}]\n")
    envs = skybody.make_vec(str(file), 3, seed=1)
    envs.reset()
    infos = envs.step(np.zeros(envs.action_space.shape, np.float32))[4]
    velocity = infos["dryden.velocity"]
    assert velocity.shape == (3, 6)
    assert len(np.unique(velocity)) == 18
    assert np.all(np.abs(velocity) < 10.0)
    envs.close()


def test_an_arm_is_driven_beside_live_rotors(tmp_path: Path) -> None:
    sim = Simulation(armed(tmp_path))
    assert [c.name for c in sim.compiled.action_channels] == ["ctbr", "joint"]
    assert sim.compiled.action_size == 5
    assert sim.compiled.action_channels[1].low == [-0.5]
    sim.reset()
    assert shoulder(sim) == pytest.approx(0.3, abs=1e-12)
    before = np.asarray(sim.rotor_speeds)
    sim.command([16.0, 0.0, 0.0, 0.0, -0.5])
    sim.advance(50)
    assert shoulder(sim) < 0.25
    assert np.all(np.asarray(sim.rotor_speeds) > 0.5 * before)


def test_a_position_drive_holds_the_arm(tmp_path: Path) -> None:
    servo = "stiffness: 2, damping: 0.1, tau: 0.02"
    sim = Simulation(armed(tmp_path, "position", servo))
    assert sim.compiled.action_channels[1].low == [-1.5]  # the joint's own limits
    sim.reset()
    sim.command([16.0, 0.0, 0.0, 0.0, -0.4])
    sim.advance(1500)
    assert shoulder(sim) == pytest.approx(-0.4, abs=0.05)  # minus the sag by gravity


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("robots[0].joints.shoulder.position=2", "its limits are -1.5 to 1.5"),
        ("robots[0].controllers[1].parameters.joints=[elbow]", "has no joint `elbow`"),
        ("robots[0].controllers[1].parameters.mode=position", "`stiffness` is 0"),
        ("robots[0].controllers[1].plugin=srt", "whose actuators a chain before it commands"),
    ],
)
def test_what_an_arm_cannot_be_is_said(tmp_path: Path, change: str, message: str) -> None:
    overrides = [change]
    if "plugin" in change:
        overrides.append("robots[0].controllers[1].parameters={}")
    with pytest.raises(InputError, match=message.replace("[", r"\[")):
        CompiledScenario(armed(tmp_path), overrides=overrides)


def test_a_hexacopter_with_tilted_rotors_hovers(tmp_path: Path) -> None:
    rotors = (MODELS / "firefly/rotors.yaml").read_text().splitlines()
    count = 0
    for i, line in enumerate(rotors):
        if "direction:" not in line:
            continue
        tilt = 0.17 if count % 2 == 0 else -0.17  # 10 degrees, alternating
        angle = math.pi / 6 + count * math.pi / 3
        axis = f"axis: [{-tilt * math.sin(angle)}, {tilt * math.cos(angle)}, 1], "
        rotors[i] = line.replace("direction:", axis + "direction:")
        count += 1
    assert count == 6
    (tmp_path / "tilted.yaml").write_text("\n".join(rotors))
    scenario = tmp_path / "hexa.yaml"
    scenario.write_text(
        f"""
stepping: {{dt: 0.001, action_repeat: 1}}
robots:
  - name: hexa
    model: {MODELS / "firefly/firefly.urdf"}
    rotors: tilted.yaml
    pose: {{position: [0, 0, 2]}}
    rotor_speed: hover
    controllers: [{{plugin: position}}, {{plugin: attitude}}, {{plugin: ctbr}}]
task: {{plugin: hover}}
"""
    )
    sim = Simulation(str(scenario))
    sim.reset()
    sim.command([0.0, 0.0, 2.0, 0.0])
    sim.advance(4000)
    assert not sim.fault
    assert np.linalg.norm(np.asarray(sim.bodies[0].position) - [0, 0, 2]) < 0.1
