"""Scenes of contact and couplings in MuJoCo and Bullet, one world per core: prints JSON lines.

Run by research/speed/contact_speed.py with the Python of requirements/contact.txt. Thrusts are
constant forces; MuJoCo's steps are looped over in C, Bullet's in Python (the call costs little
compared with a step).
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pybullet

MODEL = Path(__file__).resolve().parents[2] / "scenarios/models/qdrone2/qdrone2.urdf"
DT = 0.001
WEIGHT = 1.54 * 9.81  # [N]
SHARE = 0.68  # of the weight: carried by a constant action of zero in the formation
FEET = [(sx * 0.1016, sy * 0.127, -0.05) for sx in (-1, 1) for sy in (-1, 1)]


def vehicle_xml(name: str, x: float, y: float, z: float, sites: str = "") -> str:
    feet = "".join(
        f'<geom type="sphere" size="0.01" pos="{fx} {fy} {fz}" mass="0"/>' for fx, fy, fz in FEET
    )
    return f"""<body name="{name}" pos="{x} {y} {z}"><freejoint/>
      <inertial pos="0 0 0" mass="1.54" diaginertia="0.0147 0.0169 0.0294"/>
      <geom type="box" size="0.15 0.175 0.025" pos="0 0 0.005" mass="0"/>{feet}{sites}</body>"""


def world_xml(bodies: str, more: str = "") -> str:
    return f"""<mujoco><option timestep="{DT}" integrator="Euler"/>
      <worldbody><geom type="plane" size="50 50 1" friction="0.6 0.005 0.0001"/>{bodies}
      </worldbody>{more}</mujoco>"""


def formation_xml(robots: int) -> str:
    return world_xml("".join(vehicle_xml(f"q{i}", 0.7 * i, 0.7 * i, 0.5) for i in range(robots)))


def carried_xml() -> str:
    """Three vehicles above a plate, on rods: spatial tendons of fixed length."""
    places = ((0.55, 0.0), (-0.275, 0.476), (-0.275, -0.476))
    ears = ((0.38, 0.0), (-0.19, 0.33), (-0.19, -0.33))
    bodies = "".join(
        vehicle_xml(f"q{i}", x, y, 2.5, f'<site name="s{i}" pos="0 0 -0.05"/>')
        for i, (x, y) in enumerate(places)
    )
    sites = "".join(f'<site name="e{i}" pos="{x} {y} 0.05"/>' for i, (x, y) in enumerate(ears))
    bodies += f"""<body name="plate" pos="0 0 1.4"><freejoint/>
      <inertial pos="0 0 0" mass="1.2" diaginertia="0.065 0.065 0.128"/>
      <geom type="box" size="0.4 0.4 0.05" mass="0"/>{sites}</body>"""
    tendons = "".join(
        f'<spatial name="t{i}"><site site="s{i}"/><site site="e{i}"/></spatial>' for i in range(3)
    )
    equal = "".join(f'<tendon tendon1="t{i}"/>' for i in range(3))
    return world_xml(bodies, f"<tendon>{tendons}</tendon><equality>{equal}</equality>")


def rate(call: Callable[[], None], steps: int, seconds: float) -> float:
    """Steps per second, after a warm-up of the same duration."""
    found = 0.0
    for _ in range(2):
        begun, calls = time.perf_counter(), 0
        while time.perf_counter() - begun < seconds:
            call()
            calls += 1
        found = calls * steps / (time.perf_counter() - begun)
    return found


def by_mujoco(xml: str, lift: float, fall: float, seconds: float) -> float:
    """`lift`: the force on each vehicle [N]; `fall`: simulated time before the measurement [s]."""
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    for i in range(model.nbody):
        if model.body(i).name.startswith("q"):
            data.xfrc_applied[i, 2] = lift
    mujoco.mj_step(model, data, round(fall / DT))
    found = rate(lambda: mujoco.mj_step(model, data, 200), 200, seconds)
    if not np.isfinite(data.qpos).all():
        raise RuntimeError("MuJoCo's world has diverged")
    return found


def by_bullet(robots: int, lift: float, fall: float, seconds: float) -> float:
    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0, 0, -9.81)
    pybullet.setTimeStep(DT)
    plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE)
    pybullet.createMultiBody(0, plane)
    quads = [
        pybullet.loadURDF(
            str(MODEL), [0.7 * i, 0.7 * i, 0.5], flags=pybullet.URDF_MERGE_FIXED_LINKS
        )
        for i in range(robots)
    ]

    def step() -> None:
        for quad in quads:
            if lift > 0.0:
                pybullet.applyExternalForce(quad, -1, [0, 0, lift], [0, 0, 0], pybullet.LINK_FRAME)
        pybullet.stepSimulation()

    for _ in range(round(fall / DT)):
        step()
    found = rate(step, 1, seconds)
    pybullet.disconnect(client)
    return found


def main() -> None:
    seconds = float(sys.argv[1])
    rows = []
    for robots in (1, 2, 5, 10, 20):
        scene, lift = f"on the ground, {robots}", SHARE * WEIGHT
        rows.append(("MuJoCo", scene, by_mujoco(formation_xml(robots), lift, 2.0, seconds)))
        rows.append(("Bullet", scene, by_bullet(robots, lift, 2.0, seconds)))
    carried = by_mujoco(carried_xml(), (1.54 + 0.4) * 9.81, 0.1, seconds)
    rows.append(("MuJoCo", "plate on rods", carried))
    for engine, scene, found in rows:
        print(json.dumps({"engine": engine, "scene": scene, "rate": found}))


if __name__ == "__main__":
    main()
