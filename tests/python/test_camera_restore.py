"""Snapshots of cameras: poses, never pixels. Images are drawn again, with the same bits."""

from __future__ import annotations

import numpy as np
import pytest
from camera_scene import BALL_OBSTACLE, Frames, N, camera, copied, envs_of, sensor
from reference import actions
from skybody.vector import SkybodyVectorEnv

# Actions of 10 steps; the slow camera's image is up to 3 actions old, the late one's 3 steps or
# more. All errors are on, so that a picture depends on its random numbers, too.
SCENE = ("stepping={dt: 0.002, action_repeat: 10, horizon: 30}", BALL_OBSTACLE)
ERRORS = {"depth_noise": [0.01, 0.01, 0.0], "edge_holes": 0.3, "rgb_noise": 0.02, "exposure": 0.9}
IMAGES = ("depth", "range", "instance", "class", "normal", "rgb", "flow")
SLOW = {"period": 37, "phase": 4}
LATE = {"period": 7, "phase": 3, "latency": 18}


def eyes(size: int = 24) -> list[str]:
    shape = {"width": size, "height": size}
    return [
        camera("slow", ", ".join(IMAGES), **SLOW, **ERRORS, **shape),
        camera("late", ", ".join(IMAGES), **LATE, **ERRORS, **shape),
        sensor("lidar", "scan", columns=24, outputs="[range, points, intensity]", noise=0.02,
               ray_dropout=0.1, **SLOW),
        sensor("stereo", "pair", outputs="[left, right, depth]", disparity_noise=0.2, **LATE,
               **shape),
    ]  # fmt: skip


OBSERVED = ", ".join(
    [f"{eye}.{image}" for eye in ("slow", "late") for image in IMAGES]
    + ["scan.range", "scan.points", "scan.intensity", "pair.left", "pair.right", "pair.depth"]
)


def all_eyes(**options: object) -> SkybodyVectorEnv:
    return envs_of(eyes(), OBSERVED, scene=SCENE, **options)


def same(one: Frames, two: Frames) -> None:
    for key, values in one.items():
        np.testing.assert_array_equal(values, two[key], key)


def edit(envs: SkybodyVectorEnv) -> None:
    """Changes all that pictures depend on, behind the exposures of the present ones."""
    for env in range(N):
        envs.set_param(env, "obstacles.ball.position[1]", 2.0)
        envs.set_param(env, "sensors.slow.sunlight", 0.1)
        envs.set_param(env, "sensors.late.edge_holes", 0.9)
        envs.set_param(env, "sensors.scan.ray_dropout", 0.8)
        envs.set_param(env, "sensors.pair.disparity_noise", 3.0)


@pytest.mark.parametrize("steps", [0, 1, 2, 5, 9])
def test_restored_images_are_those_that_were_saved(steps: int) -> None:
    envs, other = all_eyes(keep_hash=True), all_eyes(keep_hash=True)
    before = copied(envs.reset()[0])
    for step in range(steps):
        before = copied(envs.step(actions(step, N))[0])
    edit(envs)
    other.reset(seed=77)
    same(before, other.restore(envs.save()))
    for step in range(steps, steps + 12):
        same(envs.step(actions(step, N))[0], other.step(actions(step, N))[0])
    assert envs.hash() == other.hash()


def test_images_of_a_fork_with_a_key_of_its_own_can_be_saved_too() -> None:
    envs, other = all_eyes(), all_eyes()
    envs.reset()
    for step in range(4):
        envs.step(actions(step, N))
    envs.fork(1, [2, 3], rekey=True)
    forked = copied(envs.observations())
    for values in forked.values():
        np.testing.assert_array_equal(values[2], values[1])
    same(forked, other.restore(envs.save()))


def test_the_size_of_a_snapshot_does_not_depend_on_that_of_images() -> None:
    sizes = []
    for size in (8, 64):
        envs = envs_of(eyes(size), OBSERVED, scene=SCENE)
        envs.reset()
        sizes.append(len(envs.save()))
    assert sizes[0] == sizes[1]
    pixels = N * 64 * 64 * 4  # bytes of one image of depths
    assert sizes[1] < pixels


def test_an_environment_that_has_not_begun_can_be_restored() -> None:
    envs, other = all_eyes(), all_eyes()
    other.reset()
    other.restore(envs.save())
    same(envs.reset()[0], other.reset()[0])
