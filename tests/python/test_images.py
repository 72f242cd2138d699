"""Images of sensors in the observation: dictionaries, dtypes, lifetimes, a replay."""

from __future__ import annotations

import subprocess
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skybody
from gymnasium.spaces import Box, Dict
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray
from reference import actions
from skybody.env import SkybodyEnv
from skybody.multi_agent import ParallelEnv
from skybody.sb3 import SkybodyVecEnv
from skybody.vector import SkybodyVectorEnv
from stable_baselines3 import PPO

BUILD = Path(__file__).resolve().parents[2] / "build/release"
PLUGINS = [BUILD / "tests/plugins/images"]
N = 6
SEEING = (
    "sensors=[{plugin: image_sensor, name: eye, parameters: {period: 10}}]",
    "observe=[eye.grey, eye.depth, eye.range, eye.height]",
    "stepping.action_repeat=10",
    "stepping.horizon=12",
)


def envs_of(**options: Any) -> SkybodyVectorEnv:
    return skybody.make_vec("hover", N, seed=3, overrides=SEEING, plugin_path=PLUGINS, **options)


def heights(observation: dict[str, NDArray[Any]]) -> NDArray[np.float32]:
    return observation["eye_height"][:, 0]


def check_pixels(observation: dict[str, NDArray[Any]], steps: int) -> None:
    """Tests that the images are those of the sensor after this number of physics steps."""
    grey = np.arange(36 * 40, dtype=np.uint8).reshape(36, 40, 1) + np.uint8(steps % 256)
    np.testing.assert_array_equal(observation["eye_grey"], np.broadcast_to(grey, (N, 36, 40, 1)))
    height = heights(observation).astype(np.float64)
    depth = 1000 * height[:, None, None] + np.arange(15).reshape(3, 5)
    np.testing.assert_allclose(observation["eye_depth"], depth, atol=1.01)
    reach = height[:, None, None] + np.arange(4).reshape(2, 2)
    np.testing.assert_allclose(observation["eye_range"], reach, rtol=1e-6)


def test_images_make_the_space_a_dictionary_of_their_types() -> None:
    space = envs_of().single_observation_space
    assert isinstance(space, Dict)
    assert space["eye_grey"] == Box(0, 255, (36, 40, 1), np.uint8)
    assert space["eye_depth"] == Box(0, 65535, (3, 5), np.uint16)
    assert space["eye_range"] == Box(0, 100, (2, 2), np.float32)
    assert space["eye_height"] == Box(-np.inf, np.inf, (1,), np.float32)
    assert "velocity" in space.keys()  # noqa: SIM118 (a Dict is no dictionary)


def test_images_are_views_that_follow_the_steps() -> None:
    envs = envs_of()
    observation, _ = envs.reset()
    check_pixels(observation, 0)
    for step in range(5):
        assert observation in envs.observation_space
        observation = envs.step(actions(step, N))[0]
        check_pixels(observation, 10 * (step + 1))
        assert not observation["eye_depth"].flags.owndata


def test_final_observations_have_the_images_of_the_end() -> None:
    envs = envs_of(autoreset="same_step")
    envs.reset()
    for step in range(12):
        observation, _, _, _, infos = envs.step(actions(step, N))
    ended = np.flatnonzero(infos["_final_obs"])
    assert ended.size > 0
    for i in ended:
        assert observation["eye_grey"][i, 0, 0, 0] == 0
        assert infos["final_obs"][i]["eye_grey"][0, 0, 0] == 120
        assert infos["final_obs"][i] in envs.single_observation_space


def test_a_restored_state_brings_its_images_along() -> None:
    envs, other = envs_of(), envs_of()
    envs.reset()
    before = {key: values.copy() for key, values in envs.step(actions(0, N))[0].items()}
    restored = other.restore(envs.save())
    for key, values in before.items():
        np.testing.assert_array_equal(restored[key], values)


def test_threads_leave_images_and_hashes_alone() -> None:
    one, two = envs_of(num_threads=1, keep_hash=True), envs_of(num_threads=2, keep_hash=True)
    one.reset()
    two.reset()
    for step in range(8):
        a, b = one.step(actions(step, N))[0], two.step(actions(step, N))[0]
        for key in a:
            np.testing.assert_array_equal(a[key], b[key])
    assert one.hash() == two.hash()


def test_batches_in_part_have_the_images_of_their_environments() -> None:
    pool = skybody.make_pool(
        "hover", N, batch_size=2, overrides=SEEING, plugin_path=PLUGINS, seed=3, order="fixed"
    )
    whole = envs_of()
    expected = whole.reset()[0]
    pool.async_reset()
    for _ in range(N // 2):
        observation, _, _, _, info = pool.recv()
        for key, values in observation.items():
            np.testing.assert_array_equal(values, expected[key][info["env_id"]])
    pool.close()


def test_gymnasiums_checker_and_stable_baselines_take_images() -> None:
    env = SkybodyEnv("hover", seed=1, overrides=SEEING, plugin_path=PLUGINS)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        check_env(env, skip_render_check=True)
    envs = SkybodyVecEnv("hover", N, seed=1, overrides=SEEING[:3], plugin_path=PLUGINS)
    model = PPO("MultiInputPolicy", envs, n_steps=4, batch_size=12, n_epochs=1, device="cpu")
    model.learn(2 * N * 4)
    assert model.num_timesteps == 2 * N * 4
    envs.close()


def test_an_agent_sees_its_own_camera_alone() -> None:
    sensors = (
        "sensors=[{plugin: image_sensor, name: a, parameters: {robot: quad1}}, "
        "{plugin: image_sensor, name: b, parameters: {robot: quad2}}]"
    )
    env = ParallelEnv(
        "formation_2",
        seed=1,
        overrides=[sensors, "observe=[a.grey, b.grey]"],
        plugin_path=PLUGINS,
    )
    observation, _ = env.reset()
    assert "a_grey" in observation["quad1"]
    assert "a_grey" not in observation["quad2"]
    assert observation["quad2"] in env.observation_space("quad2")
    assert env.state().shape == (env.compiled.observation_size,)


def test_joint_rows_have_no_place_for_images() -> None:
    with pytest.raises(ValueError, match=r"`formation_2` observes a\.grey; .* use joint=False"):
        skybody.make_vec(
            "formation_2",
            2,
            joint=True,
            overrides=[
                "sensors=[{plugin: image_sensor, name: a, parameters: {robot: quad1}}]",
                "observe=[a.grey]",
            ],
            plugin_path=PLUGINS,
        )


def test_a_replay_finds_the_same_images(tmp_path: Path) -> None:
    envs = envs_of()
    envs.record(tmp_path / "run.h5")
    envs.reset()
    for step in range(5):
        envs.step(actions(step, N))
    saved = envs.save()
    envs.step(actions(5, N))
    envs.restore(saved)
    envs.step(actions(6, N))
    envs.close()
    program = [BUILD / "bin/skybody", "replay", tmp_path / "run.h5", "--plugin-path", *PLUGINS]
    done = subprocess.run(
        [str(word) for word in program], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stdout.startswith("identical"), done.stdout + done.stderr
