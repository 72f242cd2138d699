"""Faults that users of other simulators' cameras report most, each excluded by a test.

The expected depths are in closed form, from the poses of the physics.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skybody
from camera_scene import (
    AGREE,
    BALL,
    BODY_FROM_CAMERA,
    EYE,
    SCENE,
    SINGLE_STEPS,
    SIZE,
    N,
    Reals,
    agreement,
    camera,
    check_frame,
    copied,
    envs_of,
    expected_depths,
    matrices,
    overrides,
    pixel_rays,
    pose_of,
    sensor,
)
from reference import actions
from skybody.vector import SkybodyVectorEnv

START = (
    "{plugin: start, parameters: {robot: quad, position_min: [-5, -5, 0.3], "
    "position_max: [5, 5, 3], yaw_max: 0.7, velocity_max: 5, rate_max: 2}}"
)
BALL_DRAW = (
    "{plugin: draw, parameters: {what: [obstacles.ball.position], range: [-1, 1], form: shift}}"
)
DRAWN_SCENE = (*SCENE, f"randomization=[{START}, {BALL_DRAW}]")
# Another scene would agree in less than this share of the pixels: the sky alone does.
OTHER = 0.9


def ball_of(envs: Any) -> Reals:
    """The ball's place (n, 3)."""
    return np.stack([envs.state(f"obstacles.ball.position[{k}]") for k in range(3)], axis=-1)


def drawn_envs(**options: Any) -> SkybodyVectorEnv:
    """Start and ball are drawn in each episode; the camera is late, and out of step with it."""
    cameras = [camera(period=3, latency=25)]
    return envs_of(cameras, scene=DRAWN_SCENE, **options)


# --- the first frame after a reset ----------------------------------------------------------------


@pytest.mark.parametrize("autoreset", ["next_step", "same_step", "disabled"])
def test_the_first_frame_after_a_reset_shows_the_new_episode(autoreset: str) -> None:
    """The complaint: it shows the scene before the reset."""
    envs = drawn_envs(autoreset=autoreset)
    observation, _ = envs.reset()
    check_frame(observation, envs, ball_of(envs))
    began = np.zeros(N, dtype=int)
    for step in range(40):
        episode, before = envs.state("episode"), (*pose_of(envs), ball_of(envs))
        observation, _, terminated, truncated, _ = envs.step(actions(step, N))
        if autoreset == "disabled" and np.any(terminated | truncated):
            observation, _ = envs.reset(options={"reset_mask": terminated | truncated})
        fresh = envs.state("episode") != episode
        began += fresh
        new = agreement(observation, *expected_depths(*pose_of(envs), ball_of(envs)))
        old = agreement(observation, *expected_depths(*before))
        assert np.all(new[fresh] > AGREE)
        assert np.all(old[fresh] < OTHER), "the test could not tell the scenes apart"
    assert np.all(began >= 2)


def test_the_first_frame_of_a_fork_shows_its_source() -> None:
    """The complaint of frames after a reset, for copies of an environment."""
    envs = drawn_envs()
    envs.reset()
    envs.fork(1, [2, 4])
    observation = envs.observations()
    check_frame(observation, envs, ball_of(envs))
    np.testing.assert_array_equal(observation["eye_depth"][4], observation["eye_depth"][1])
    envs.fork(1, [3], rekey=True)
    check_frame(envs.observations(), envs, ball_of(envs))


def test_the_first_frame_after_a_restore_shows_the_restored_scene() -> None:
    """The complaint of frames after a reset, for saved states."""
    envs, other = drawn_envs(), drawn_envs()
    envs.reset()
    other.reset(seed=9)
    other.step(actions(0, N))
    observation = other.restore(envs.save())
    check_frame(observation, envs, ball_of(envs))


def test_the_first_frame_after_a_reset_has_what_was_requested_in_flight() -> None:
    """The complaint of frames after a reset, while transitions run on other threads."""
    sensors = [camera(), sensor("pose", "base", period=1)]
    observe = "eye.depth, eye.instance, base.position, base.rotation"
    pool = skybody.make_pool(
        "hover", N, seed=3, batch_size=2, num_threads=2, overrides=overrides(sensors, observe)
    )
    moved = BALL + np.array([-2.0, 1.0, 0.3])
    pool.async_reset()
    pool.request(None, {"obstacles.ball.position": moved.tolist()}, when="next_reset")
    resets = np.zeros(N, dtype=int)
    while np.min(resets) < 3:
        observation, _, _, _, info = pool.recv()
        ids = info["env_id"].copy()
        resets[ids] += info["was_reset"]
        pose = (observation[f"base_{what}"].astype(float) for what in ("position", "rotation"))
        ball = np.where(resets[ids, None] > 1, moved, BALL)
        share = agreement(observation, *expected_depths(*pose, ball))
        assert np.all(share > AGREE), share
        pool.send(actions(0, N)[ids], ids)
    pool.close()


# --- the camera and its robot ---------------------------------------------------------------------


@pytest.mark.parametrize(("scenario", "link"), [("hover", ""), ("payload", "bob")])
def test_the_camera_moves_with_its_robot(scenario: str, link: str) -> None:
    """The complaint: the camera stays behind, or follows another frame of the robot."""
    body = f"robots.quad.{f'links.{link}' if link else 'base'}"
    envs = envs_of([camera(link=link or "''")], scenario=scenario, scene=SINGLE_STEPS)
    envs.request(None, {"robots.quad.start.velocity": [1.0, 2.0, 3.0]}, when="next_reset")
    observation, _ = envs.reset()
    first = expected_depths(*pose_of(envs, body))
    for step in range(40):
        share = agreement(observation, *expected_depths(*pose_of(envs, body)))
        assert np.all(share > AGREE), share
        observation = envs.step(actions(step, N))[0]
    assert np.all(agreement(observation, *first) < OTHER), "it did not move"


@pytest.mark.parametrize("latency", [0, 1, 7, 40])
def test_picture_and_pose_belong_together(latency: int) -> None:
    """The complaint: a picture was taken tens of milliseconds before or after its pose."""
    scene = (*SINGLE_STEPS, f"randomization=[{START}]")
    envs = envs_of([camera(latency=latency)], scene=scene)
    frames = [copied(envs.reset()[0])]
    poses = [pose_of(envs)]
    for step in range(50):
        frames.append(copied(envs.step(actions(step, N))[0]))
        poses.append(pose_of(envs))
    for n, frame in enumerate(frames):
        exposed = max(n - latency, 0)
        assert np.all(agreement(frame, *expected_depths(*poses[exposed])) > AGREE)
        if 0 < exposed < len(poses) - 1:
            for wrong in (exposed - 1, exposed + 1):
                share = agreement(frame, *expected_depths(*poses[wrong]))
                assert np.mean(share) < OTHER, "the test could not tell steps apart"


# --- without a display ----------------------------------------------------------------------------

HEADLESS = """
import numpy, pathlib, skybody
envs = skybody.make_vec("hover_camera", 2, overrides=["observe=[front.depth, front.rgb]",
    "sensors.front.parameters.outputs=[depth, rgb]"])
observation, _ = envs.reset()
assert numpy.unique(observation["front_depth"]).size > 100
assert numpy.unique(observation["front_rgb"].reshape(-1, 3), axis=0).shape[0] > 100
print(pathlib.Path("/proc/self/maps").read_text())
"""


def test_images_need_no_display_and_no_driver(tmp_path: Path) -> None:
    """The complaint: rendering without a display fails, or needs a driver of a GPU."""
    done = subprocess.run(
        [sys.executable, "-c", HEADLESS],
        env={},  # no DISPLAY, no WAYLAND_DISPLAY, no PATH, no HOME
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    libraries = {Path(line.split()[-1]).name for line in done.stdout.splitlines() if "/" in line}
    assert any(name.startswith("_native") for name in libraries), libraries
    graphics = ("libGL", "libEGL", "libX11", "libwayland", "libvulkan", "libcuda", "libOSMesa")
    assert not [name for name in libraries if name.startswith(graphics)]


# --- things that move -----------------------------------------------------------------------------


def test_obstacles_that_are_moved_or_drawn_are_seen_where_they_are() -> None:
    """The complaint: the picture shows obstacles where they were when the scene was built."""
    envs = envs_of(scene=DRAWN_SCENE)
    observation, _ = envs.reset()
    assert len(np.unique(ball_of(envs), axis=0)) == N
    check_frame(observation, envs, ball_of(envs))
    moved = BALL + np.array([-2.0, 1.0, 0.3])
    envs.request([0, 3], {"obstacles.ball.position": moved.tolist()})
    observation = envs.step(actions(0, N))[0]
    np.testing.assert_array_equal(ball_of(envs)[[0, 3]], [moved, moved])
    check_frame(observation, envs, ball_of(envs))
    envs.set_param(1, "obstacles.ball.position[2]", 0.2)
    observation = envs.step(actions(1, N))[0]
    assert ball_of(envs)[1, 2] == 0.2
    check_frame(observation, envs, ball_of(envs))


BALL_ROBOT = """\
<robot name="ball"><link name="base">
<inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><geometry><sphere radius="0.5"/></geometry></visual></link></robot>
"""
FLY_BY = """\
gravity: [0, 0, 0]
stepping: {{dt: 0.005, action_repeat: 1, horizon: 1000}}
robots:
  - {{name: quad, model: ball.urdf, pose: {{position: [0, 0, 2]}}, controllers: [{wrench}]}}
  - {{name: other, model: ball.urdf, pose: {{position: [5, -8, 2.5]}}, controllers: [{wrench}]}}
task: {{plugin: hover, parameters: {{robot: quad}}}}
sensors: [{camera}]
observe: [eye.depth, eye.instance]
randomization:
  - plugin: start
    parameters: {{robot: quad, relative: true, velocity_max: 1, rate_max: 0.5}}
  - {{plugin: draw, parameters: {{what: ['robots.other.start.velocity[1]'], range: [18, 22]}}}}
"""


def test_another_robot_that_flies_by_is_seen_at_its_place(tmp_path: Path) -> None:
    """The complaint: the picture shows other robots late, or not at all."""
    wrench = "{plugin: wrench, parameters: {max_moment: [1, 1, 1], max_force: [1, 1, 1]}}"
    (tmp_path / "ball.urdf").write_text(BALL_ROBOT)
    (tmp_path / "scenario.yaml").write_text(
        FLY_BY.format(wrench=wrench, camera=camera(robot="quad"))
    )
    envs = skybody.make_vec(str(tmp_path / "scenario.yaml"), N, seed=3)
    observation, _ = envs.reset()
    seen = np.zeros(N, dtype=int)
    for _ in range(160):
        other = envs.state("robots.other.base.position")
        depth, sees_other = expected_depths(*pose_of(envs), other, radius=0.5)
        assert np.all(agreement(observation, depth, sees_other) > AGREE)
        seen += np.any(sees_other, axis=(1, 2))
        observation = envs.step(np.zeros((N, *envs.single_action_space.shape), np.float32))[0]
    assert np.all((seen > 50) & (seen < 160)), "it comes and goes"


# --- depth ----------------------------------------------------------------------------------------

THINGS = (
    "{name: ball, sphere: 0.6, position: [3, 0.5, 1.5]}",
    "{name: crate, box: [1, 0.8, 1], position: [2, -2, 0.5], rpy: [0, 0, 0.6]}",
    "{name: tree, capsule: [0.2, 3], position: [3, -3, 1.7]}",
    "{name: gate, gate: [1.4, 1.4, 0.1], position: [6, 1.5, 1.5], rpy: [0, 0, 0.3]}",
)


def test_lidar_and_depth_agree_ray_by_ray() -> None:
    """The complaint: a lidar and a depth camera in one place measure different distances."""
    rays = pixel_rays()
    azimuth = np.arctan2(rays[..., 1], rays[..., 0])
    elevation = np.arctan2(rays[..., 2], np.hypot(rays[..., 0], rays[..., 1]))
    angles = np.stack([azimuth, elevation], axis=-1).ravel().tolist()
    place = EYE.tolist()
    scan = sensor("lidar", "scan", angles=angles, outputs="[range, instance]", position=place)
    scene = (SCENE[0], f"obstacles=[{', '.join(THINGS)}]")
    observe = "scan.range, scan.instance, eye.depth, eye.instance"
    envs = envs_of([camera(), scan], observe, scene=scene)
    observation, _ = envs.reset()
    for step in range(5):
        ranges = observation["scan_range"].reshape(N, SIZE, SIZE)
        along = ranges / np.linalg.norm(rays, axis=-1)
        ids = observation["scan_instance"].reshape(N, SIZE, SIZE)
        # Farther than this a camera's farthest value is a depth, a lidar's a range.
        near = observation["eye_depth"] < 50.0
        close = np.isclose(along, observation["eye_depth"], rtol=2e-5)
        agree = close & (ids == observation["eye_instance"])
        assert np.mean(near) > 0.4
        assert np.mean(agree[near]) > 0.99, "all but pixels at edges"
        observation = envs.step(actions(step, N))[0]


TILT = 0.001  # rad, of a wall that faces the camera: depth changes by 0.7 mm per pixel


def test_depth_is_not_quantised() -> None:
    """The complaint: depth comes in steps, as of 8 or 16 bits."""
    wall = (
        f"{{name: wall, plane: true, position: [8, 0, 0], rpy: [0, -1.5707963267948966, {TILT}]}}"
    )
    still = "randomization=[{plugin: start, parameters: {robot: quad, relative: true}}]"
    scene = (SCENE[0], f"obstacles=[{wall}]", still)
    envs = envs_of([camera(ground="false", position=[0, 0, 0])], scene=scene)
    depth = envs.reset()[0]["eye_depth"]
    assert depth.dtype == np.float32
    normal = np.array([np.cos(TILT), np.sin(TILT), 0.0])
    expected = (normal @ [8.0, 0.0, 0.0]) / (pixel_rays() @ normal)
    np.testing.assert_allclose(depth, np.broadcast_to(expected, depth.shape), rtol=1e-5)
    differences = np.diff(depth.astype(float), axis=2)
    # Neighbours differ by 0.7 mm; float32 has steps of 1 um there.
    assert np.all(differences > 0.6e-3)
    assert np.all(differences < 0.8e-3)


ROOM = (
    "{name: east, plane: true, position: [7, 0, 0], rpy: [0, -1.5707963267948966, 0]}",
    "{name: north, plane: true, position: [0, 6, 0], rpy: [1.5707963267948966, 0, 0]}",
)
MOUNT = np.array([0.13, -0.07, 0.045])
TURN = (0.1, 0.35, 0.6)  # roll, pitch, yaw: the floor and both walls are in view


def eye_from_depth(depth: Reals, axes: Reals, instance: Any) -> Reals:
    """The place of an eye in the room, from its picture alone.

    A pixel with direction d (W, 1 along the optical axis) and depth z on the wall n . p = c says n
    . eye = c - z n . d; the mean over all pixels of a wall is exact to float32's rounding.
    """
    along = pixel_rays(len(depth)) @ BODY_FROM_CAMERA @ axes.T
    place = np.zeros(3)
    for axis, (wall, where) in enumerate(((3, 7.0), (4, 6.0), (1, 0.0))):  # east, north, ground
        seen = instance == wall
        assert np.sum(seen) > 20
        place[axis] = np.mean(where - (depth * along[..., axis])[seen])
    return place


def test_the_frame_of_depth_is_where_the_scenario_puts_it() -> None:
    """The complaint: depth is measured from a place beside the one that is stamped on it."""
    mounted = camera(position=MOUNT.tolist(), orientation=list(TURN))
    still = (
        "randomization=[{plugin: start, parameters: {robot: quad, position_min: [3, 2, 1], "
        "position_max: [5, 4, 2], rate_max: 1, velocity_max: 1}}]"
    )
    envs = envs_of([mounted], scene=(SCENE[0], f"obstacles=[{', '.join(ROOM)}]", still))
    observation, _ = envs.reset()
    geometry = skybody.camera.Camera(envs.compiled, "eye")
    for step in range(6):
        position, rotation = pose_of(envs)
        expected = position + matrices(rotation) @ MOUNT
        stamped, axes = geometry.pose(envs)
        np.testing.assert_allclose(stamped, expected, atol=1e-12)
        for k in range(N):
            seen = observation["eye_depth"][k].astype(float), observation["eye_instance"][k]
            found = eye_from_depth(seen[0], axes[k], seen[1])
            np.testing.assert_allclose(found, expected[k], atol=1e-5)
        observation = envs.step(actions(step, N))[0]
