"""Cameras: what they see, and when; the same bits on any threads, batches and instruction sets."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import skybody
from camera_scene import (
    BALL_ID,
    BALL_OBSTACLE,
    SINGLE_STEPS,
    N,
    camera,
    copied,
    envs_of,
    overrides,
)
from instruction_sets import hashes_of
from reference import actions


def test_an_absent_obstacle_is_not_seen() -> None:
    envs = envs_of()
    observation, _ = envs.reset()
    assert np.any(observation["eye_instance"] == BALL_ID)
    envs.request(None, {"obstacles.ball.present": 0})
    observation = envs.step(actions(0, N))[0]
    assert not np.any(observation["eye_instance"] == BALL_ID)


def test_other_robots_are_seen_and_the_own_one_if_wanted() -> None:
    cameras = [
        camera("front", "instance", robot="quad1", width=64),
        camera(
            "all",
            "instance",
            robot="quad1",
            width=64,
            sees_own_robot="true",
            position=[0, 0, 0.6],
            orientation=[0, 1.5, 0],
        ),
    ]
    scene = ["stepping.action_repeat=10", "robots.quad2.pose.position=[2, 0, 1]"]
    envs = skybody.make_vec(
        "formation_2",
        2,
        seed=1,
        overrides=[
            "randomization=[]",
            "robots.quad1.pose.position=[0, 0, 1]",
            *overrides(cameras, "front.instance, all.instance", scene),
        ],
    )
    observation, _ = envs.reset()
    assert set(np.unique(observation["front_instance"])) >= {0, 1, 3}
    assert 2 not in observation["front_instance"]
    assert 2 in observation["all_instance"]


@pytest.mark.parametrize("latency", [1, 4, 10, 25])
@pytest.mark.parametrize("period", [1, 5])
def test_a_late_frame_shows_the_world_at_its_exposure(latency: int, period: int) -> None:
    """With one physics step per action, a late image is the image of `latency` steps before."""
    cameras = [camera(period=period), camera("late", period=period, latency=latency)]
    envs = envs_of(cameras, "eye.depth, late.depth", 2, SINGLE_STEPS)
    frames = [copied(envs.reset()[0])]
    for step in range(40):
        frames.append(copied(envs.step(actions(step, 2))[0]))
    for n, frame in enumerate(frames):
        arrived = (n - latency) // period * period if n >= latency else 0
        np.testing.assert_array_equal(frame["late_depth"], frames[arrived]["eye_depth"])
    assert not np.array_equal(frames[-1]["late_depth"], frames[-1]["eye_depth"])


def test_period_and_phase_choose_the_exposures() -> None:
    cameras = [camera(period=1), camera("slow", period=7, phase=3)]
    envs = envs_of(cameras, "eye.depth, slow.depth", 2, SINGLE_STEPS)
    frames = [copied(envs.reset()[0])]
    for step in range(30):
        frames.append(copied(envs.step(actions(step, 2))[0]))
    for n, frame in enumerate(frames):
        exposed = (n - 3) // 7 * 7 + 3 if n >= 3 else 0
        np.testing.assert_array_equal(frame["slow_depth"], frames[exposed]["eye_depth"])


@pytest.mark.parametrize(
    ("period", "phase", "latency"), [(1, 0, 0), (3, 1, 0), (4, 2, 7), (25, 0, 50)]
)
def test_frames_between_actions_are_those_of_single_steps(
    period: int, phase: int, latency: int
) -> None:
    """Left-out frames change nothing: actions of ten physics steps, and ten actions of one."""
    cameras = [camera(period=period, phase=phase, latency=latency)]
    coarse, fine = (
        envs_of(
            cameras,
            num_envs=2,
            scene=[f"stepping={{dt: 0.002, action_repeat: {repeat}}}", BALL_OBSTACLE],
        )
        for repeat in (10, 1)
    )
    coarse.reset()
    fine.reset()
    for step in range(12):
        seen = coarse.step(actions(step, 2))[0]
        for _ in range(10):
            singly = fine.step(actions(step, 2))[0]
        np.testing.assert_array_equal(seen["eye_depth"], singly["eye_depth"])


LATE = (camera(period=3, latency=8),)


def test_a_restored_state_has_its_frames_and_their_future() -> None:
    envs, other = envs_of(LATE), envs_of(LATE)
    envs.reset()
    for step in range(5):
        before = copied(envs.step(actions(step, N))[0])
    restored = other.restore(envs.save())
    for key, values in before.items():
        np.testing.assert_array_equal(restored[key], values)
    for step in range(5, 20):
        a, b = envs.step(actions(step, N))[0], other.step(actions(step, N))[0]
        for key in a:
            np.testing.assert_array_equal(a[key], b[key])


def test_a_fork_sees_what_its_source_sees() -> None:
    envs = envs_of(LATE)
    envs.reset()
    for step in range(3):
        envs.step(actions(step, N))
    envs.fork(1, [2, 4])
    same = np.repeat(actions(3, N)[1:2], N, axis=0)
    for _ in range(3):
        observation = envs.step(same)[0]
        for key, values in observation.items():
            np.testing.assert_array_equal(values[2], values[1], key)
            np.testing.assert_array_equal(values[4], values[1], key)


ALL = (camera("eye", "depth, range, instance, class, normal, rgb", period=3, latency=8),)
ALL_OBSERVED = "eye.depth, eye.range, eye.instance, eye.class, eye.normal, eye.rgb"


def frames_hash(num_envs: int = N, **options: Any) -> int:
    envs = envs_of(ALL, ALL_OBSERVED, num_envs, keep_hash=True, **options)
    envs.reset()
    for step in range(20):
        envs.step(actions(step, num_envs))
    return envs.hash()


@pytest.mark.parametrize("threads", [2, 4])
def test_threads_leave_frames_alone(threads: int) -> None:
    assert frames_hash(40, num_threads=threads) == frames_hash(40, num_threads=1)


def test_an_environment_sees_the_same_in_every_batch() -> None:
    alone, many = envs_of(ALL, ALL_OBSERVED, 1), envs_of(ALL, ALL_OBSERVED, 40)
    pool = skybody.make_pool(
        "hover", 40, seed=3, batch_size=8, order="fixed", overrides=overrides(ALL, ALL_OBSERVED)
    )
    a, b = alone.reset()[0], many.reset()[0]
    pool.async_reset()
    for step in range(6):
        for first in range(0, 40, 8):
            part, _, _, _, info = pool.recv()
            for key, values in part.items():
                np.testing.assert_array_equal(values, b[key][info["env_id"]])
            assert info["env_id"][0] == first
            pool.send(actions(step, 40)[info["env_id"]], info["env_id"])
        for key, values in a.items():
            np.testing.assert_array_equal(values[0], b[key][0])
        given = actions(step, 40)
        a, b = alone.step(given[:1])[0], many.step(given)[0]
    pool.close()


def test_instruction_sets_leave_frames_alone() -> None:
    hashes = hashes_of("test_cameras", "frames_hash")
    assert len(set(hashes.values())) == 1, hashes
    assert frames_hash() in hashes.values()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"width": 0}, r"`width` is 0; allowed: an integer from 1 to 4096 pixels"),
        ({"field_of_view": 3.5}, r"`field_of_view` .*3\.5.*allowed"),
        ({"link": "nose"}, r"robot `quad` has no link `nose`: there are "),
        ({"phase": 5, "period": 5}, r"`phase` is 5; allowed: 0 to 4, less than `period`"),
        ({"latency": 1000}, r"`latency` is 1000 periods; allowed: less than 64"),
    ],
)
def test_wrong_parameters_are_named(parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(skybody.InputError, match=message):
        envs_of([camera(**parameters)])


@pytest.mark.parametrize(
    ("images", "message"),
    [
        ("", r"`outputs` is empty: name one or more of depth, range"),
        ("depth, depht", r"`outputs` has an unknown image depht: choose from depth, range"),
        ("depth, depth", r"`outputs` names depth twice"),
    ],
)
def test_wrong_images_are_named(images: str, message: str) -> None:
    with pytest.raises(skybody.InputError, match=message):
        envs_of([camera("eye", images)])


def test_images_beyond_the_memory_are_refused() -> None:
    large = camera(width=4096, height=4096)
    with pytest.raises(ValueError, match=r"images of 96 MiB each need .* take fewer env"):
        envs_of([large], num_envs=100_000)


LAYERS = 6
# Depths of layers are 3 m apart, solids at most 1.4 m across: two pixels of one solid differ by
# less than 1.5 m, two of different solids, or of one and nothing, by more.
JUMP = 1.5


def test_instances_change_where_depth_jumps_and_nowhere_else() -> None:
    kinds = ("box: [0.8, 0.7, 0.9]", "sphere: 0.6", "cylinder: [0.4, 0.9]", "capsule: [0.3, 0.7]")
    solids = [
        f"{{name: solid_{k}, {kinds[k % 4]}, position: [{4 + 3 * (k % LAYERS)}, 0, 50]}}"
        for k in range(3 * LAYERS)
    ]
    moves = [
        "{plugin: start, parameters: {robot: quad, relative: true, position_min: [0, 0, 49], "
        "position_max: [0, 0, 49]}}",
        "{plugin: draw, name: across, parameters: {what: ['obstacles.*.position[1]'], "
        "form: shift, range: [-4, 4]}}",
        "{plugin: draw, name: up, parameters: {what: ['obstacles.*.position[2]'], "
        "form: shift, range: [-4, 4]}}",
        "{plugin: draw, name: turns, parameters: {what: ['obstacles.*.rotation'], range: [-1, 1]}}",
    ]
    scene = [f"obstacles=[{', '.join(solids)}]", f"randomization=[{', '.join(moves)}]"]
    eye = camera(width=96, height=96, ground="false", max_range=30)
    observation, _ = envs_of([eye], num_envs=40, scene=scene).reset()
    depth, ids = observation["eye_depth"].astype(float), observation["eye_instance"].astype(int)
    assert len(np.unique(ids)) == 1 + len(solids)
    for axis in (1, 2):
        jumps = np.abs(np.diff(depth, axis=axis)) > JUMP
        edges = np.diff(ids, axis=axis) != 0
        # Of one layer two solids may touch, so that their numbers differ and their depths do not.
        layer = np.where(ids == 0, -1, (ids - 3) % LAYERS)
        np.testing.assert_array_equal(jumps, np.diff(layer, axis=axis) != 0)
        assert np.all(edges[jumps])
        assert np.sum(jumps) > 5_000


def test_a_camera_in_a_wall_sees_the_wall_at_no_distance() -> None:
    wall = "obstacles=[{name: wall, box: [14, 14, 8], position: [0, 0, 3]}]"
    contact = "contact.redraws=0"  # the robot is in the wall, too
    envs = envs_of(
        [camera(images="depth, range, instance, class, normal")],
        "eye.depth, eye.range, eye.instance, eye.class, eye.normal",
        scene=[wall, contact],
    )
    observation, _ = envs.reset()
    for key, value in {"depth": 0, "range": 0, "instance": 3, "class": 3, "normal": 0}.items():
        np.testing.assert_array_equal(observation[f"eye_{key}"], value, key)
