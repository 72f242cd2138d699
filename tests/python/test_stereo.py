"""Stereo cameras: disparities in closed form, hidden points, noise; the same images as cameras'."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import skybody
from instruction_sets import hashes_of
from numpy.typing import NDArray
from reference import actions
from skybody.camera import Camera
from skybody.vector import SkybodyVectorEnv

WIDTH, HEIGHT = 128, 32
FOCAL = WIDTH / 2  # of 90 degrees
BASELINE = 0.3
PLACE = np.array([0.1, 0.15, 0.05])  # of the left eye, in the base
RIGHT = PLACE - [0.0, BASELINE, 0.0]
WALL, FRONT = 6.0, 2.0  # x of the wall's and of the box's faces
HALF = 0.5  # of the box
FARTHEST = 50.0
SCENE = (
    f"{{name: wall, box: [1, 60, 60], position: [{WALL + 0.5}, 0, 0]}}",
    f"{{name: near, box: [0.5, {2 * HALF}, 40], position: [{FRONT + 0.25}, 0.15, 0]}}",
)
BALLS = (
    "{name: ball, sphere: 0.6, position: [4, 0.5, 1.5]}",
    "{name: tree, capsule: [0.2, 3], position: [3, -0.6, 1.5]}",
    "{name: post, cylinder: [0.3, 3], position: [5, 1.8, 1.5], rpy: [0.3, 0, 0]}",
)


def sensor(plugin: str, name: str, outputs: str, **parameters: Any) -> str:
    given = {
        "width": WIDTH,
        "height": HEIGHT,
        "position": PLACE.tolist(),
        "max_range": FARTHEST,
        **parameters,
    }
    words = ", ".join(f"{key}: {value}" for key, value in given.items())
    return f"{{plugin: {plugin}, name: {name}, parameters: {{outputs: [{outputs}], {words}}}}}"


def stereo(outputs: str = "disparity, depth", **parameters: Any) -> str:
    return sensor("stereo", "eyes", outputs, **{"baseline": BASELINE, **parameters})


def envs_of(
    sensors: list[str],
    observe: str = "eyes.disparity, eyes.depth",
    obstacles: tuple[str, ...] = SCENE[:1],
    num_envs: int = 2,
    is_level: bool = True,
    **options: Any,
) -> SkybodyVectorEnv:
    overrides = [
        "stepping={dt: 0.001, action_repeat: 10, horizon: 12}",
        f"sensors=[{', '.join(sensors)}]",
        f"observe=[{observe}]",
        f"obstacles=[{', '.join(obstacles)}]",
    ]
    if is_level:
        overrides.append("randomization=[]")
    return skybody.make_vec("hover", num_envs, seed=3, overrides=overrides, **options)


def first_of(envs: SkybodyVectorEnv) -> dict[str, NDArray[Any]]:
    return envs.reset()[0]


def disparity_of(x: float, envs: SkybodyVectorEnv) -> float:
    """Of a surface across the optical axis."""
    eye = envs.state("robots.quad.base.position")[0] + PLACE
    return FOCAL * BASELINE / (x - float(eye[0]))


def test_a_walls_disparity_is_focal_length_times_baseline_by_depth() -> None:
    envs = envs_of([stereo(ground="false")])
    seen = first_of(envs)
    expected = disparity_of(WALL, envs)
    columns = np.arange(WIDTH) + 0.5
    is_matched = columns >= expected  # else outside of the right image
    np.testing.assert_allclose(seen["eyes_disparity"][..., is_matched], expected, rtol=2e-6)
    assert np.all(seen["eyes_disparity"][..., ~is_matched] == 0)
    depth = FOCAL * BASELINE / expected
    np.testing.assert_allclose(seen["eyes_depth"][..., is_matched], depth, rtol=2e-6)
    assert np.all(seen["eyes_depth"][..., ~is_matched] == FARTHEST)


def test_beside_a_near_box_a_strip_is_hidden_from_the_right_eye() -> None:
    envs = envs_of([stereo(ground="false")], obstacles=SCENE)
    row = first_of(envs)["eyes_disparity"][0, HEIGHT // 2]
    near, far = disparity_of(FRONT, envs), disparity_of(WALL, envs)
    depth = FOCAL * BASELINE / near
    edge = WIDTH / 2 - FOCAL * HALF / depth  # the box is in the middle of the left image
    columns = np.arange(WIDTH) + 0.5
    is_hidden = (columns < edge) & (columns > edge - (near - far))
    is_box = (columns > edge) & (columns < WIDTH - edge)
    is_outside = columns < far
    assert abs(np.count_nonzero(row[columns < edge] == 0) - (near - far) - far) <= 1.5
    np.testing.assert_allclose(row[is_box], near, rtol=2e-6)
    # All but a column at each border of the strip.
    wrong = (row == 0) != (is_hidden | is_outside)
    assert np.count_nonzero(wrong) <= 2
    np.testing.assert_allclose(row[(row > 0) & ~is_box], far, rtol=2e-6)


@pytest.mark.parametrize("obstacles", [SCENE, BALLS])
def test_images_are_those_of_two_cameras(obstacles: tuple[str, ...]) -> None:
    sensors = [
        stereo("left, right, disparity, depth"),
        sensor("camera", "one", "rgb, depth"),
        sensor("camera", "other", "rgb", position=RIGHT.tolist()),
    ]
    observe = "eyes.left, eyes.right, eyes.disparity, eyes.depth, one.rgb, one.depth, other.rgb"
    envs = envs_of(sensors, observe, obstacles, is_level=False)
    envs.reset()
    for step in range(5):
        seen = envs.step(actions(step, 2))[0]
        np.testing.assert_array_equal(seen["eyes_left"], seen["one_rgb"])
        np.testing.assert_array_equal(seen["eyes_right"], seen["other_rgb"])
        is_matched = seen["eyes_disparity"] > 0
        assert np.mean(is_matched) > 0.3
        depth = seen["eyes_depth"]
        np.testing.assert_allclose(depth[is_matched], seen["one_depth"][is_matched], rtol=2e-7)
        product = depth[is_matched] * seen["eyes_disparity"][is_matched]
        np.testing.assert_allclose(product, FOCAL * BASELINE, rtol=1e-6)
        assert np.all(depth[~is_matched] == FARTHEST)


def test_matched_points_are_seen_by_the_right_eye() -> None:
    """At their places in the right image, to a pixel at edges."""
    sensors = [stereo(), sensor("camera", "other", "depth", position=RIGHT.tolist())]
    observe = "eyes.disparity, eyes.depth, other.depth"
    envs = envs_of(sensors, observe, BALLS, is_level=False)
    seen = first_of(envs)
    shown = FOCAL * BASELINE / seen["other_depth"]
    disparity = seen["eyes_disparity"]
    env, row, column = np.nonzero(disparity)
    d = disparity[env, row, column]
    place = np.floor(column - d).astype(int)
    sides = [shown[env, row, np.clip(place + k, 0, WIDTH - 1)] for k in (0, 1)]
    assert np.all(np.minimum(*sides) <= d + 0.5 + 1e-3)
    is_between = (np.minimum(*sides) - 0.1 <= d) & (d <= np.maximum(*sides) + 0.1)
    assert np.mean(is_between) > 0.995
    # And most points that are not matched, though inside of the image, are hidden.
    assert 0 < np.mean((disparity == 0) & (seen["eyes_depth"] == FARTHEST)) < 0.6


def test_disparities_have_the_noise_and_the_steps_of_the_scenario() -> None:
    noisy = envs_of([stereo(ground="false", disparity_noise=0.2)], num_envs=8)
    seen = first_of(noisy)
    exact = disparity_of(WALL, noisy)
    errors = seen["eyes_disparity"][..., 4:] - exact
    assert np.std(errors) == pytest.approx(0.2, rel=0.02)
    assert np.mean(errors) == pytest.approx(0.0, abs=5e-3)
    depth = FOCAL * BASELINE / seen["eyes_disparity"][..., 4:]
    np.testing.assert_allclose(seen["eyes_depth"][..., 4:], depth, rtol=1e-6)

    stepped = envs_of([stereo(ground="false", disparity_resolution=0.0625)])
    steps = first_of(stepped)["eyes_disparity"][..., 4:] * 16
    np.testing.assert_array_equal(steps, round(16 * exact))


def test_noise_is_drawn_per_episode_if_the_scenario_sets_it() -> None:
    draw = (
        "randomization=[{plugin: draw, parameters: "
        "{what: [sensors.eyes.disparity_noise], range: [0.05, 0.5]}}]"
    )
    envs = skybody.make_vec(
        "hover",
        8,
        seed=3,
        overrides=[
            f"sensors=[{stereo(ground='false', disparity_noise=0.1)}]",
            "observe=[eyes.disparity]",
            f"obstacles=[{SCENE[0]}]",
            draw,
        ],
    )
    seen = first_of(envs)["eyes_disparity"][..., 4:]
    drawn = envs.state("sensors.eyes.disparity_noise")
    assert np.ptp(drawn) > 0.1
    np.testing.assert_allclose(np.std(seen, axis=(1, 2)), drawn.ravel(), rtol=0.06)


def test_the_left_eye_is_a_camera_in_python() -> None:
    envs = envs_of([stereo()], obstacles=BALLS)
    seen = first_of(envs)
    camera = Camera(envs.compiled, "eyes")
    position, axes = camera.pose(envs)
    pixels, depth = camera.project([[4.0, 0.5, 1.5]], position[0], axes[0])
    column, row = np.floor(pixels[0]).astype(int)
    assert seen["eyes_depth"][0, row, column] == pytest.approx(depth[0] - 0.6, abs=0.05)


ALL = (
    "left, right, disparity, depth",
    "eyes.left, eyes.right, eyes.disparity, eyes.depth",
)


def images_hash(num_envs: int = 40, **options: Any) -> int:
    errors = {"disparity_noise": 0.1, "rgb_noise": 0.01, "shot_noise": 0.05, "exposure": 1.3}
    late = stereo(ALL[0], period=3, latency=8, **errors)
    envs = envs_of([late], ALL[1], BALLS, num_envs, is_level=False, keep_hash=True, **options)
    envs.reset()
    for step in range(15):
        envs.step(actions(step, num_envs))
    return envs.hash()


@pytest.mark.parametrize("threads", [2, 4])
def test_threads_leave_images_alone(threads: int) -> None:
    assert images_hash(num_threads=threads) == images_hash(num_threads=1)


def test_instruction_sets_leave_images_alone() -> None:
    hashes = hashes_of("test_stereo", "images_hash")
    assert len(set(hashes.values())) == 1, hashes


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"baseline": 0}, r"`baseline` is 0; allowed: a number from 0\.001 to 1000 m"),
        ({"baseline": -0.1}, r"`baseline` is -0\.1; allowed"),
        ({"field_of_view": 3.2}, r"`field_of_view` is 3\.2; allowed: a number from 0\.01 to 3 rad"),
        ({"disparity_noise": -1}, r"`disparity_noise` is -1; allowed"),
        ({"projection": "fisheye"}, r"projection"),
        ({"phase": 5, "period": 5}, r"`phase` is 5; allowed: 0 to 4, less than `period`"),
    ],
)
def test_wrong_parameters_are_named(parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(skybody.InputError, match=message):
        envs_of([stereo(**parameters)])


@pytest.mark.parametrize(
    ("images", "message"),
    [
        ("", r"`outputs` is empty: name one or more of left, right, disparity, depth"),
        ("rgb", r"`outputs` has an unknown image rgb: choose from left, right, disparity, depth"),
        ("depth, depth", r"`outputs` names depth twice"),
    ],
)
def test_wrong_images_are_named(images: str, message: str) -> None:
    with pytest.raises(skybody.InputError, match=message):
        envs_of([stereo(images)])
