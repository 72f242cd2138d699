"""Pairs of shapes in shallow overlap: contacts by MuJoCo and by Skybody.

MuJoCo gives the signed distance of two geoms and their nearest points (mj_geomDistance: GJK and EPA
on convex shapes). Skybody gives contacts by the rules of docs/contact.md. The two share only sizes
and poses.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import skybody
from rigid_body import Reals
from scipy.spatial.transform import Rotation

KINDS = ("box", "cylinder", "capsule", "sphere")
# Number of sizes: edges; radius and length (of a capsule without its caps); radius.
SIZES = {"box": 3, "cylinder": 2, "capsule": 2, "sphere": 1}
GEOMS = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
}
SMALL = 1e-3  # components of a unit normal below this count as zero


@dataclass(frozen=True)
class Solid:
    """A shape with a pose in the world."""

    kind: str
    size: Reals
    position: Reals
    rotation: Rotation

    def moved(self, way: Reals) -> Solid:
        return Solid(self.kind, self.size, self.position + way, self.rotation)

    def feature(self, normal: Reals) -> str:
        """The feature that touches a neighbour along `normal` (W, unit, either sign)."""
        n = np.abs(self.rotation.inv().apply(normal))
        if self.kind == "sphere":
            return "ball"
        if self.kind == "capsule":
            return "side" if n[2] < SMALL else "ball"
        if self.kind == "cylinder":
            return "end" if n[2] > 1.0 - SMALL**2 else "side" if n[2] < SMALL else "rim"
        return ("face", "edge", "corner")[min(int((n > SMALL).sum()), 3) - 1]


@dataclass(frozen=True)
class Touch:
    """The deepest contact of the first shape in the second."""

    depth: float  # [m]; negative: apart
    normal: Reals  # direction that separates the first shape, unit, W
    point: Reals  # in the middle of the overlap, W


class Mujoco:
    """Two geoms whose shapes and poses are set before each query."""

    def __init__(self) -> None:
        geoms = '<geom type="sphere" size="1"/><body><geom type="sphere" size="1"/></body>'
        self._model = mujoco.MjModel.from_xml_string(
            f"<mujoco><worldbody>{geoms}</worldbody></mujoco>"
        )
        self._data = mujoco.MjData(self._model)
        mujoco.mj_kinematics(self._model, self._data)

    def _set(self, index: int, solid: Solid) -> None:
        size = np.zeros(3)
        size[: len(solid.size)] = solid.size
        if solid.kind == "box":
            size *= 0.5
        if solid.kind in ("cylinder", "capsule"):
            size[1] *= 0.5
        self._model.geom_type[index] = GEOMS[solid.kind]
        self._model.geom_size[index] = size
        self._model.geom_rbound[index] = size.sum()  # an upper bound of its extent
        self._data.geom_xpos[index] = solid.position
        self._data.geom_xmat[index] = solid.rotation.as_matrix().ravel()

    def touch(self, first: Solid, second: Solid) -> Touch:
        self._set(0, first)
        self._set(1, second)
        ends = np.zeros(6)
        distance = mujoco.mj_geomDistance(self._model, self._data, 0, 1, 10.0, ends)
        way = (ends[:3] - ends[3:]) / distance  # separating direction: from the second to the first
        return Touch(-distance, way / np.linalg.norm(way), 0.5 * (ends[:3] + ends[3:]))

    def overlapping(self, first: Solid, second: Solid, way: Reals, depth: float) -> Solid:
        """`first`, moved from afar against `way` until the overlap has this depth."""
        far, near = 3.0, 0.0
        for _ in range(60):
            middle = 0.5 * (far + near)
            if self.touch(first.moved(middle * way), second).depth > depth:
                near = middle
            else:
                far = middle
        return first.moved(far * way)


def draw(random: np.random.Generator, kind: str, size: Reals | None = None) -> Solid:
    """A shape at the origin with a random attitude."""
    if size is None:
        size = random.uniform(0.05, 0.4, SIZES[kind])
        size[0] *= 0.5 if kind != "box" else 1.0
    return Solid(kind, size, np.zeros(3), Rotation.random(rng=random))


URDF = """<robot name="{name}"><link name="base"><inertial><mass value="1"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
<collision><geometry>{shape}</geometry></collision></link></robot>"""
SCENARIO = """name: pair
contact: {{ground: false}}
gravity: [0, 0, 0]
robots:
  - {{name: first, model: first.urdf}}
{second}
task: {{plugin: watch, parameters: {{robot: first, link: base}}}}
"""


def element(kind: str, size: Reals) -> str:
    if kind == "box":
        return f'<box size="{size[0]} {size[1]} {size[2]}"/>'
    if kind in ("cylinder", "capsule"):
        return f'<{kind} radius="{size[0]}" length="{size[1]}"/>'
    return f'<sphere radius="{size[0]}"/>'


class Pair:
    """Two shapes in Skybody: on two robots, or on a robot and an obstacle. Sizes are fixed."""

    def __init__(self, folder: Path, first: Solid, second: Solid, is_obstacle: bool) -> None:
        for name, solid in (("first", first), ("second", second)):
            shape = element(solid.kind, solid.size)
            (folder / f"{name}.urdf").write_text(URDF.format(name=name, shape=shape))
        other = "  - {name: second, model: second.urdf}"
        if is_obstacle:
            size = second.size[0] if second.kind == "sphere" else list(map(float, second.size))
            other = f"obstacles: [{{name: second, {second.kind}: {size}, position: [0, 0, 9]}}]"
        (folder / "pair.yaml").write_text(SCENARIO.format(second=other))
        self._is_obstacle = is_obstacle
        self._sim = skybody.Simulation(str(folder / "pair.yaml"))

    def contacts(self, first: Solid, second: Solid) -> list[Touch]:
        sim = self._sim
        sim.reset()
        for name, solid in (("first", first), ("second", second)):
            rotation = solid.rotation.as_quat()[[3, 0, 1, 2]]
            if name == "second" and self._is_obstacle:
                for k in range(3):
                    sim.set_param(f"obstacles.second.position[{k}]", float(solid.position[k]))
                for k in range(4):
                    sim.set_param(f"obstacles.second.rotation[{k}]", float(rotation[k]))
            else:
                sim.teleport(position=solid.position, rotation=rotation, robot=name)
        found = []
        for c in sim.contacts():
            sign = 1.0 if c.body.startswith("first") else -1.0
            found.append(Touch(c.depth, sign * np.array(c.normal), np.array(c.point)))
        return found
