"""Textures: pictures of a URDF's materials and of the ground, and files that are none."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skybody
from instruction_sets import hashes_of
from numpy.typing import NDArray
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
SIZE = 96
EYE = np.array([-2.0, 0.0, 5.0])  # looks along x at the body at (0, 0, 5)
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
      {{position: [-2, 0, 0], sees_own_robot: true, width: {size}, height: {size},
        outputs: [{outputs}], sunlight: 0, ambient: 1{more}}}
observe: [{observe}]
{tail}
"""
MODEL = """\
<robot name="model"><material name="skin">{}</material>
<link name="base"><inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry>{}</geometry><material name="skin"/></visual>
<collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>
"""
SKIN = '<texture filename="skin.png"/>'
# Corners of a face of 1 x 1 m at x = -0.5, and its texture points seen from -x.
FACE_OBJ = """\
v -0.5 0.5 -0.5
v -0.5 -0.5 -0.5
v -0.5 -0.5 0.5
v -0.5 0.5 0.5
vt 0 0
vt 1 0
vt 1 1
vt 0 1
f 1/1 2/2 3/3 4/4
"""


def quadrants(size: int = 64) -> NDArray[np.uint8]:
    """Red and green above blue and grey."""
    half = size // 2
    picture = np.empty((size, size, 3), np.uint8)
    picture[:half, :half], picture[:half, half:] = (250, 0, 0), (0, 240, 0)
    picture[half:, :half], picture[half:, half:] = (0, 0, 230), (120, 120, 120)
    return picture


def write(
    folder: Path, geometry: str, more: str = "", outputs: str = "rgb", tail: str = ""
) -> Path:
    folder.mkdir(exist_ok=True)
    Image.fromarray(quadrants()).save(folder / "skin.png")
    (folder / "face.obj").write_text(FACE_OBJ)
    (folder / "model.urdf").write_text(MODEL.format(SKIN, geometry))
    observe = ", ".join(f"eye.{name.strip()}" for name in outputs.split(","))
    text = SCENARIO.format(size=SIZE, outputs=outputs, observe=observe, more=more, tail=tail)
    (folder / "scenario.yaml").write_text(text)
    return folder / "scenario.yaml"


def image(scenario: Path, name: str = "eye_rgb", num_envs: int = 1) -> NDArray[Any]:
    observation, _ = skybody.make_vec(str(scenario), num_envs, seed=1).reset()
    return np.array(observation[name])


def check_quadrants(picture: NDArray[Any], half: int) -> None:
    """The picture fills a square of 2 `half` pixels in the middle of the image."""
    middle, quarter = SIZE // 2, half // 2
    for row, column, color in (
        (-quarter, -quarter, (250, 0, 0)),
        (-quarter, quarter, (0, 240, 0)),
        (quarter, -quarter, (0, 0, 230)),
        (quarter, quarter, (120, 120, 120)),
    ):
        np.testing.assert_allclose(picture[middle + row, middle + column], color, atol=1)


@pytest.mark.parametrize(
    "geometry", ['<box size="1 1 1"/>', '<mesh filename="face.obj"/>', '<sphere radius="0.5"/>']
)
def test_a_body_shows_the_picture_of_its_material(tmp_path: Path, geometry: str) -> None:
    picture = image(write(tmp_path / "a", geometry))[0]
    if "sphere" not in geometry:
        return check_quadrants(picture, 16)  # at 1.5 m
    # From behind, the picture's sides meet: its right half is on the left.
    middle = SIZE // 2
    np.testing.assert_allclose(picture[middle - 8, middle - 8], (0, 240, 0), atol=1)
    np.testing.assert_allclose(picture[middle + 8, middle + 8], (0, 0, 230), atol=1)
    return None


def test_a_jpeg_is_a_picture(tmp_path: Path) -> None:
    scenario = write(tmp_path / "a", '<box size="1 1 1"/>')
    Image.fromarray(quadrants()).save(tmp_path / "a/skin.jpg", quality=98)
    text = (tmp_path / "a/model.urdf").read_text().replace("skin.png", "skin.jpg")
    (tmp_path / "a/model.urdf").write_text(text)
    picture = image(scenario)[0].astype(int)
    exact = image(write(tmp_path / "b", '<box size="1 1 1"/>'))[0]
    assert np.mean(np.abs(picture - exact)) < 3


GROUND = ", orientation: [0, 1.5707963267948966, 0], ground_textures: [{}], ground_texture_size: 4"


def test_the_ground_repeats_a_picture(tmp_path: Path) -> None:
    # Looks down from 5 m: image up is +x, right is -y.
    seen = image(write(tmp_path / "a", '<sphere radius="0.01"/>', GROUND.format("skin.png")))[0]
    across = (np.arange(SIZE) + 0.5) / SIZE * 10 - 5
    x, y = np.meshgrid(EYE[0] - across, -across, indexing="ij")
    column, row = x / 4 % 1, -y / 4 % 1
    expected = quadrants()[(row * 64).astype(int), (column * 64).astype(int)]
    inside = (np.abs(column % 0.5 - 0.25) < 0.16) & (np.abs(row % 0.5 - 0.25) < 0.16)
    inside &= np.hypot(x, y) > 0.1
    assert np.mean(inside) > 0.3
    np.testing.assert_allclose(seen[inside].astype(int), expected[inside], atol=1)


def draws_of(what: str, low: float, high: float) -> str:
    return (
        "randomization: [{plugin: draw, parameters: "
        f"{{what: [sensors.eye.{what}], range: [{low}, {high}]}}}}]"
    )


def test_the_ground_has_a_drawn_picture_of_a_list(tmp_path: Path) -> None:
    more = GROUND.format("red.png, blue.png, green.png") + ", ground_texture: 0"
    scenario = write(
        tmp_path / "a", '<sphere radius="0.01"/>', more, tail=draws_of("ground_texture", 0, 3)
    )
    for name, color in {"red": (200, 0, 0), "green": (0, 200, 0), "blue": (0, 0, 200)}.items():
        Image.new("RGB", (8, 8), color).save(tmp_path / "a" / f"{name}.png")
    colors = image(scenario, num_envs=40)[:, 5, 5]
    assert {tuple(color) for color in colors.tolist()} == {(200, 0, 0), (0, 200, 0), (0, 0, 200)}


def test_pictures_leave_depths_alone(tmp_path: Path) -> None:
    outputs = "rgb, depth, instance, normal"
    with_pictures = write(tmp_path / "a", '<box size="1 1 1"/>', GROUND.format("skin.png"), outputs)
    bare = write(
        tmp_path / "b", '<box size="1 1 1"/>', ", orientation: [0, 1.5707963267948966, 0]", outputs
    )
    for name in ("eye_depth", "eye_instance", "eye_normal"):
        np.testing.assert_array_equal(image(with_pictures, name), image(bare, name))
    assert np.any(image(with_pictures) != image(bare))


def test_pictures_are_not_read_without_colours(tmp_path: Path) -> None:
    scenario = write(tmp_path / "a", '<box size="1 1 1"/>', GROUND.format("no.png"), "depth")
    (tmp_path / "a/skin.png").write_text("no picture")
    image(scenario, "eye_depth")


def test_lidars_see_the_brightness_of_pictures(tmp_path: Path) -> None:
    scenario = write(tmp_path / "a", '<box size="1 1 1"/>')
    text = scenario.read_text().replace("plugin: camera", "plugin: lidar")
    text = text.replace("[rgb], sunlight: 0, ambient: 1", "[intensity], elevations: [-0.08, 0.08]")
    text = text.replace(f" width: {SIZE}, height: {SIZE},", " columns: 9, field_of_view: 0.2,")
    scenario.write_text(text.replace("eye.rgb", "eye.intensity"))
    seen = image(scenario, "eye_intensity")[0]
    # Columns go from the right to the left, rings from below.
    below, above = seen[0, [1, 7]], seen[1, [1, 7]]
    np.testing.assert_allclose(below, [120 / 255, 230 / 765], rtol=0.05)
    np.testing.assert_allclose(above, [240 / 765, 250 / 765], rtol=0.05)


def frames_hash(folder: str) -> int:
    more = GROUND.format("skin.png").replace("1.5707963267948966", "0.4")
    scenario = write(Path(folder), '<sphere radius="0.5"/>', more + ", shot_noise: 0.05")
    envs = skybody.make_vec(str(scenario), 6, seed=1, keep_hash=True)
    envs.reset()
    for _ in range(5):
        envs.step(np.zeros((6, *envs.single_action_space.shape), np.float32))
    return envs.hash()


def test_instruction_sets_leave_textures_alone(tmp_path: Path) -> None:
    hashes = hashes_of("test_camera_textures", "frames_hash", str(tmp_path / "a"))
    assert len(set(hashes.values())) == 1, hashes


def check(scenario: Path) -> tuple[int, str]:
    done = subprocess.run(
        [PROGRAM, "check", scenario.name],
        cwd=scenario.parent,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    return done.returncode, done.stderr


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"no picture", "is neither PNG nor JPEG"),
        (b"\x89PNG\r\n\x1a\n", "is a broken PNG: "),
        (b"\xff\xd8\xff\xe0", "is a broken JPEG: "),
        (None, "does not exist"),
        ("wide", "is 5000 x 2 pixels; allowed: at most 4096 x 4096"),
    ],
)
@pytest.mark.parametrize("is_ground", [True, False])
def test_files_that_are_no_pictures_are_named(
    tmp_path: Path, content: bytes | str | None, problem: str, is_ground: bool
) -> None:
    more = GROUND.format("pic.png") if is_ground else ""
    scenario = write(tmp_path / "a", '<box size="1 1 1"/>', more)
    file = tmp_path / "a" / ("pic.png" if is_ground else "skin.png")
    file.unlink(missing_ok=True)
    if isinstance(content, str):
        Image.new("RGB", (5000, 2)).save(file)
    elif content is not None:
        file.write_bytes(content)
    code, message = check(scenario)
    if content is None and not is_ground:
        assert code == 0, message
        assert "warning: the texture `skin.png` of the link `base` does not exist; its colour" in (
            message
        )
        return
    assert code == 2
    assert message.count("error:") == 1
    assert f"`{file.name if is_ground else file.resolve()}` {problem}" in message.replace(
        f"{tmp_path}/a/pic.png", "pic.png"
    )
    assert message.startswith("scenario.yaml:")
    assert "name a whole PNG or JPEG file, or leave the texture out" in message


def test_a_number_beyond_the_list_is_named(tmp_path: Path) -> None:
    more = GROUND.format("skin.png") + ", ground_texture: 2"
    code, message = check(write(tmp_path / "a", '<box size="1 1 1"/>', more))
    assert code == 2
    assert "`ground_texture` is 2; allowed: 0 to 0" in message
