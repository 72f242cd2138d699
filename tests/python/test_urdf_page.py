"""The warnings that docs/urdf.md promises, against `skybody check`."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
PAGE = ROOT / "docs/urdf.md"
MASS = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
)
LONE_INERTIA = (
    '<inertial><mass value="0"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)
SPHERE = "<geometry><sphere radius='1'/></geometry>"
SCENARIO = """\
robots:
  - name: quad
    model: model.urdf
    pose: {position: [0, 0, 5]}
    controllers: [{plugin: wrench, parameters: {max_moment: [1, 1, 1]}}]
task: {plugin: hover}
"""

# Spans a box of 0.1 x 0.2 x 0.05 m.
TETRAHEDRON = """solid there
facet normal 0 0 -1
outer loop
vertex 0 0 0
vertex 0 0.2 0
vertex 0.1 0 0
endloop
endfacet
facet normal -1 0 0
outer loop
vertex 0 0 0
vertex 0 0 0.05
vertex 0 0.2 0
endloop
endfacet
endsolid there
"""


def model(
    kind: str = "continuous",
    base: str = "base",
    of_base: str = MASS,
    of_arm: str = MASS,
    of_joint: str = "",
    of_robot: str = "",
) -> str:
    """A base, an arm, and the joint `elbow` between them."""
    return (
        f'<robot name="model"><link name="{base}">{of_base}</link>'
        f'<link name="arm">{of_arm}</link>'
        f'<joint name="elbow" type="{kind}"><parent link="{base}"/><child link="arm"/>{of_joint}'
        f"</joint>{of_robot}</robot>"
    )


def mesh(kind: str, file: str) -> str:
    return f'<{kind}><geometry><mesh filename="{file}"/></geometry></{kind}>'


MODELS = {
    "gazebo": model(of_robot="<gazebo/><gazebo/>"),
    "element_of_robot": model(of_robot="<gripper/>"),
    "element_of_link": model(of_arm=MASS + "<self_collide/>"),
    "element_of_joint": model(of_joint="<spring/>"),
    "element_of_shape": model(of_arm=MASS + f"<visual>{SPHERE}<texture_map/></visual>"),
    "attribute": model(of_joint='<origin xyx="1 0 0"/>'),
    "left_out": model(of_robot="<transmission/>"),
    "effort": model(of_joint='<limit effort="1" velocity="2"/>'),
    "travel": model(of_joint='<limit lower="-1" upper="1" effort="0" velocity="0"/>'),
    "axis": model("fixed", of_joint='<axis xyz="0 0 1"/>'),
    "damping": model("fixed", of_joint='<dynamics damping="1"/>'),
    "mimic": model(of_joint='<mimic joint="other"/>'),
    "friction": model(of_joint='<dynamics friction="1"/>'),
    "origin_of_floating": model("floating", "world", "", of_joint='<origin xyz="0 0 1"/>'),
    "shapes_of_world": model("fixed", "world", f"<visual>{SPHERE}</visual>"),
    "no_mass": model("fixed", of_arm=""),
    "moves_no_mass": model(of_arm=""),
    "no_travel": model("revolute", of_joint='<limit lower="0" upper="0"/>'),
    "inertia_without_mass": model("fixed", of_arm=LONE_INERTIA),
    "missing_mesh": model(of_arm=MASS + mesh("visual", "arm.stl")),
    "collision_mesh": model(of_arm=MASS + mesh("collision", "there.stl")),
}


def promised() -> list[str]:
    """The warnings in the page's table, as the program writes them."""
    section = PAGE.read_text().split("## What is ignored with a warning")[1].split("\n## ")[0]
    rows = [line for line in section.splitlines() if line.startswith("| ")][2:]
    cells = [re.findall(r"`([^`]*)`", row.split(" | ")[-1])[0] for row in rows]
    return [re.sub(r"'([\w.]+)'", r"`\1`", cell) for cell in cells]


def warnings(folder: Path, urdf: str) -> list[str]:
    """Warnings of `skybody check` for a robot of this model."""
    (folder / "model.urdf").write_text(urdf)
    (folder / "scenario.yaml").write_text(SCENARIO)
    (folder / "there.stl").write_text(TETRAHEDRON)
    done = subprocess.run(
        [PROGRAM, "check", folder / "scenario.yaml"], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return re.findall(r"model\.urdf:\d+:\d+: warning: (.*)", done.stderr)


@pytest.mark.parametrize("name", MODELS)
def test_what_is_ignored_has_the_warning_that_the_page_promises(name: str, tmp_path: Path) -> None:
    found = warnings(tmp_path, MODELS[name])
    assert found
    assert set(found) <= set(promised())


def test_every_warning_of_the_page_has_a_model_that_causes_it(tmp_path: Path) -> None:
    caused = {text for urdf in MODELS.values() for text in warnings(tmp_path, urdf)}
    assert caused == set(promised())
