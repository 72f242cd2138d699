"""Cameras and meshes: visuals from mesh files, height fields, and files that cannot be drawn."""

from __future__ import annotations

import struct
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skybody
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
SIZE = 96
SCENARIO = """\
robots:
  - name: quad
    model: model.urdf
    pose: {{position: [0, 0, 5]}}
    controllers: [{{plugin: wrench, parameters: {{max_moment: [1, 1, 1]}}}}]
task: {{plugin: hover}}
sensors:
  - plugin: camera
    name: eye
    parameters:
      {{position: [-2, 0.3, 0.4], orientation: [0, 0.2, -0.15], sees_own_robot: true,
       width: {size}, height: {size}, outputs: [depth, instance, normal]}}
observe: [eye.depth, eye.instance, eye.normal]
{more}
"""
MODEL = """\
<robot name="model"><link name="base">
<inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><origin xyz="0.1 0 0" rpy="0.1 0.2 0.3"/><geometry>{}</geometry></visual>
<collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>
"""
HALF = np.array([0.3, 0.2, 0.25])


def box_stl(half: NDArray[np.float64]) -> bytes:
    """A binary STL of a box about the origin."""
    triangles = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            square = np.array([[side, -1, -1], [side, 1, -1], [side, 1, 1], [side, -1, 1]])
            square = np.roll(square, axis, axis=1) * half
            triangles += [square[[0, 1, 2]], square[[0, 2, 3]]]
    body = b"".join(
        struct.pack("<12f", 0, 0, 0, *corners.ravel()) + b"\0\0" for corners in triangles
    )
    return b"\0" * 80 + struct.pack("<I", len(triangles)) + body


def write(folder: Path, geometry: str, more: str = "") -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "model.urdf").write_text(MODEL.format(geometry))
    (folder / "scenario.yaml").write_text(SCENARIO.format(size=SIZE, more=more))
    return folder / "scenario.yaml"


def image(scenario: Path) -> dict[str, NDArray[Any]]:
    observation, _ = skybody.make_vec(str(scenario), 2, seed=1).reset()
    return {key: values[0].copy() for key, values in observation.items() if key.startswith("eye")}


def test_a_mesh_of_a_box_looks_like_the_box(tmp_path: Path) -> None:
    solid = image(write(tmp_path / "solid", '<box size="0.6 0.4 0.5"/>'))
    scenario = write(tmp_path / "mesh", '<mesh filename="box.stl" scale="2 2 2"/>')
    (tmp_path / "mesh/box.stl").write_bytes(box_stl(HALF / 2))
    mesh = image(scenario)
    assert np.sum(solid["eye_instance"] == 2) > 100
    differ = solid["eye_instance"] != mesh["eye_instance"]
    assert np.sum(differ) <= 6, "all but pixels at the silhouette"
    same = ~differ
    np.testing.assert_allclose(solid["eye_depth"][same], mesh["eye_depth"][same], rtol=2e-5)
    close = np.isclose(solid["eye_normal"][same], mesh["eye_normal"][same], atol=1e-5)
    assert np.mean(close) > 0.999


def check(scenario: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([PROGRAM, "check", scenario], capture_output=True, text=True, check=False)


MILLIONS = b"\0" * 80 + struct.pack("<I", 10_000_000) + b"\0" * 5000


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("cut.stl", box_stl(HALF)[:-7], "cannot be drawn: "),
        ("empty.stl", b"", "has no faces: "),
        ("millions.stl", MILLIONS, "cannot be drawn: its header says 10000000 triangles"),
        ("nan.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a number that is not finite"),
        ("none.obj", b"v 0 0 0\nf 1 2 3\n", "cannot be drawn: "),
        ("text.dae", b"no XML", "cannot be drawn: "),
    ],
)
def test_a_mesh_that_cannot_be_drawn_is_refused_with_its_file(
    tmp_path: Path, name: str, content: bytes, problem: str
) -> None:
    scenario = write(tmp_path, f'<mesh filename="{name}"/>')
    (tmp_path / name).write_bytes(content)
    done = check(scenario)
    assert done.returncode == 2
    assert f"scenario.yaml:8:13: error: the mesh `{name}` of the body `base` " in done.stderr
    assert problem in done.stderr


def test_a_visual_mesh_that_is_not_there_is_left_out_with_a_warning(tmp_path: Path) -> None:
    scenario = write(tmp_path, '<mesh filename="none.stl"/>')
    done = check(scenario)
    assert done.returncode == 0
    assert "model.urdf:4:60: warning: the mesh `none.stl` of the link `base` does not exist" in (
        done.stderr
    )
    assert np.sum(image(scenario)["eye_instance"] == 2) > 0, "the collision shape is drawn"


def test_a_material_that_is_not_declared_is_refused(tmp_path: Path) -> None:
    scenario = write(tmp_path, '<sphere radius="0.1"/>')
    model = tmp_path / "model.urdf"
    model.write_text(model.read_text().replace("</visual>", '<material name="rust"/></visual>'))
    done = check(scenario)
    assert done.returncode == 2
    assert "the material `rust` of the link `base` has no <color> and is not declared" in (
        done.stderr
    )


def test_a_mesh_is_not_read_without_a_camera(tmp_path: Path) -> None:
    scenario = write(tmp_path, '<mesh filename="box.stl"/>')
    (tmp_path / "box.stl").write_bytes(b"none")
    text = scenario.read_text().split("sensors:")[0]
    scenario.write_text(text)
    assert check(scenario).returncode == 0


def test_a_height_field_is_seen_at_its_heights(tmp_path: Path) -> None:
    x, y = np.meshgrid(np.linspace(-10, 10, 21), np.linspace(-10, 10, 21))
    heights = 1.0 + 0.1 * x - 0.05 * y  # a slope, of which triangles are exact
    values = ", ".join(f"{h:.17g}" for h in heights.ravel())
    field = f"{{size: [20, 20], columns: 21, heights: [{values}]}}"
    more = f"obstacles:\n  - {{name: hill, height_field: {field}}}\n"
    scenario = write(tmp_path, '<sphere radius="0.01"/>', more)
    text = scenario.read_text().replace(
        "position: [-2, 0.3, 0.4], orientation: [0, 0.2, -0.15]",
        "position: [0, 0, 0], orientation: [0, 1.5707963267948966, 0]",
    )
    scenario.write_text(text.replace("sees_own_robot: true", "sees_own_robot: false"))
    seen = image(scenario)
    across = (np.arange(SIZE) + 0.5 - SIZE / 2) / (SIZE / 2)
    right, down = np.meshgrid(across, across)
    # The camera looks down: its right is -y of W, its down -x.
    # z = 5 - t = 1 + 0.1 (-down t) - 0.05 (-right t)
    depth = 4.0 / (1.0 - 0.1 * down + 0.05 * right)
    np.testing.assert_allclose(seen["eye_depth"], depth, rtol=2e-5)


def test_a_mesh_behind_a_link_without_an_extension_is_read(tmp_path: Path) -> None:
    scenario = write(tmp_path, '<mesh filename="box.stl"/>')
    (tmp_path / "stored").write_bytes(box_stl(HALF))
    (tmp_path / "box.stl").symlink_to("stored")
    assert np.sum(image(scenario)["eye_instance"] == 2) > 100


def test_too_many_triangles_are_refused(tmp_path: Path) -> None:
    scenario = write(tmp_path, '<mesh filename="many.obj"/>')
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n" * 60001
    (tmp_path / "many.obj").write_text(text)
    done = check(scenario)
    assert done.returncode == 2
    assert "has more than 60000 triangles, which is the most that is drawn" in done.stderr
