"""Sensors in the observation by `observe`: flat rows, dictionaries, privileged values."""

from __future__ import annotations

import subprocess
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import h5py
import numpy as np
import pytest
import skybody
import torch
from gymnasium.spaces import Box, Dict
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import parallel_api_test
from reference import actions
from skybody.env import SkybodyEnv
from skybody.multi_agent import ParallelEnv
from skybody.sb3 import SkybodyVecEnv
from skybody.vector import SkybodyVectorEnv
from stable_baselines3 import PPO

PROGRAM = Path(__file__).resolve().parents[2] / "build/release/bin/skybody"
N = 6
IMU = ("sensors=[{plugin: imu}]", "stepping.action_repeat=10", "stepping.horizon=20")
OBSERVED = (*IMU, "observe=[imu.specific_force, {channel: imu.angular_rate, name: gyro}]")
CRITIC = (
    *IMU,
    "observe=[imu.specific_force, {channel: imu.angular_rate, name: gyro, privileged: true}]",
)


def envs_of(overrides: tuple[str, ...], **options: Any) -> SkybodyVectorEnv:
    return skybody.make_vec("hover", N, seed=3, overrides=overrides, **options)


def test_observed_channels_follow_the_tasks_in_a_flat_box() -> None:
    envs = envs_of(OBSERVED)
    space = envs.single_observation_space
    assert isinstance(space, Box)
    assert space.shape == (28,)
    names = [column.name for column in envs.compiled.observation_columns]
    assert names[-2:] == ["imu.specific_force", "gyro"]
    observation, _ = envs.reset()
    assert observation.flags.c_contiguous
    np.testing.assert_allclose(np.linalg.norm(observation[:, 22:25], axis=1), 9.81, rtol=1e-3)


def test_observing_changes_nothing_of_the_tasks_own_values() -> None:
    plain, observed = envs_of(IMU), envs_of(OBSERVED)
    np.testing.assert_array_equal(plain.reset()[0], observed.reset()[0][:, :22])
    for step in range(30):
        given = actions(step, N)
        np.testing.assert_array_equal(plain.step(given)[0], observed.step(given)[0][:, :22])


@pytest.mark.parametrize("scenario", ["hover", "trajectory", "trajectory_compact"])
def test_without_past_actions_the_other_values_stay_as_they_are(scenario: str) -> None:
    hidden = ("task.parameters.past_actions=false",)
    whole = skybody.make_vec(scenario, N, seed=3)
    rest = skybody.make_vec(scenario, N, seed=3, overrides=hidden)
    columns = whole.compiled.observation_columns
    keep = np.concatenate([np.full(c.shape, c.name != "actions").ravel() for c in columns])
    assert not keep.all()
    seen, other = whole.reset()[0], rest.reset()[0]
    for step in range(5):
        np.testing.assert_array_equal(seen[:, keep], other)
        given = actions(step, N)
        seen, other = whole.step(given)[0], rest.step(given)[0]


def test_a_dictionary_holds_views_of_the_flat_rows() -> None:
    flat, named = envs_of(OBSERVED), envs_of(OBSERVED, dict_observations=True)
    assert isinstance(named.single_observation_space, Dict)
    rows, columns = flat.reset()[0], named.reset()[0]
    for step in range(30):
        assert columns in named.observation_space
        np.testing.assert_array_equal(np.concatenate(list(columns.values()), axis=1), rows)
        assert columns["gyro"].base is not None
        rows, columns = flat.step(actions(step, N))[0], named.step(actions(step, N))[0]


def test_keys_have_no_dots_for_pytorch_refuses_them() -> None:
    assert "imu_specific_force" in envs_of(OBSERVED, dict_observations=True).reset()[0]


def test_two_columns_of_one_key_are_refused() -> None:
    twin = "observe=[imu.angular_rate, {channel: imu.specific_force, name: imu_angular_rate}]"
    with pytest.raises(ValueError, match="would have the key `imu_angular_rate`"):
        envs_of((*IMU, twin), dict_observations=True)


def test_bounds_of_the_space_are_the_scenarios_where_it_gives_some() -> None:
    bounded = "observe=[{channel: imu.angular_rate, low: -35, high: 30}]"
    space = envs_of((*IMU, bounded), dict_observations=True).single_observation_space
    assert isinstance(space, Dict)
    assert (space["imu_angular_rate"].low == -35).all()
    assert (space["imu_angular_rate"].high == 30).all()


def test_joint_and_dictionaries_exclude_one_another() -> None:
    with pytest.raises(ValueError, match="exclude one another"):
        skybody.make_vec("formation_2", 2, joint=True, dict_observations=True)


@pytest.mark.parametrize("as_dict", [False, True])
def test_privileged_values_are_infos_and_not_observations(as_dict: bool) -> None:
    envs = envs_of(CRITIC, dict_observations=as_dict)
    reference = envs_of(OBSERVED)
    observation, infos = envs.reset()
    rows, _ = reference.reset()
    assert "gyro" not in observation if as_dict else observation.shape == (N, 25)
    np.testing.assert_array_equal(infos["privileged"], rows[:, 25:])
    assert infos["_privileged"].all()
    _, _, _, _, infos = envs.step(actions(0, N))
    np.testing.assert_array_equal(infos["privileged"], reference.step(actions(0, N))[0][:, 25:])
    np.testing.assert_array_equal(envs.privileged(), infos["privileged"])


@pytest.mark.parametrize("as_dict", [False, True])
def test_final_observations_and_infos_carry_all_columns(as_dict: bool) -> None:
    envs = envs_of(CRITIC, autoreset="same_step", dict_observations=as_dict)
    last = envs_of(OBSERVED, autoreset="disabled")
    envs.reset()
    last.reset()
    for step in range(20):
        infos = envs.step(actions(step, N))[4]
        rows = last.step(actions(step, N))[0]
        if "final_obs" in infos:
            break
    ended = np.flatnonzero(infos["_final_obs"])
    assert ended.size > 0
    for i in ended:
        final = infos["final_obs"][i]
        row = np.concatenate(list(final.values())) if as_dict else final
        np.testing.assert_array_equal(row, rows[i, :25])
        np.testing.assert_array_equal(infos["final_info"]["privileged"][i], rows[i, 25:])
        assert (infos["privileged"][i] != rows[i, 25:]).any()


def test_a_simulation_has_the_same_privileged_values() -> None:
    world = skybody.Simulation("hover", seed=3, overrides=CRITIC)
    world.reset()
    _, infos = envs_of(CRITIC).reset()
    np.testing.assert_array_equal(world.privileged, infos["privileged"][0])


def test_torch_takes_the_columns_of_a_dictionary_without_a_copy() -> None:
    observation, _ = envs_of(OBSERVED, dict_observations=True).reset()
    for values in observation.values():
        assert torch.from_numpy(values).data_ptr() == values.ctypes.data
        assert torch.from_dlpack(values).data_ptr() == values.ctypes.data


def test_a_pool_gives_dictionaries_and_privileged_values() -> None:
    pool = skybody.make_pool(
        "hover", N, batch_size=2, order="fixed", overrides=CRITIC, dict_observations=True
    )
    observation, info = pool.reset()
    assert observation["imu_specific_force"].shape == (2, 3)
    assert info["privileged"].shape == (2, 3)
    pool.close()


def test_observations_come_back_after_a_restore() -> None:
    envs = envs_of(CRITIC, dict_observations=True)
    envs.reset()
    before = {key: values.copy() for key, values in envs.step(actions(0, N))[0].items()}
    saved, privileged = envs.save(), envs.privileged()
    envs.step(actions(1, N))
    restored = envs.restore(saved)
    for key, values in before.items():
        np.testing.assert_array_equal(restored[key], values)
    np.testing.assert_array_equal(envs.privileged(), privileged)


@pytest.mark.parametrize("as_dict", [False, True])
def test_gymnasiums_checker_is_content(as_dict: bool) -> None:
    env = SkybodyEnv("hover", seed=1, overrides=CRITIC, dict_observations=as_dict)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about infinite bounds
        check_env(env, skip_render_check=True)
    _, info = env.reset()
    assert info["privileged"].shape == (3,)


def test_gymnasium_makes_dictionaries_by_its_own_name() -> None:
    envs = gymnasium.make_vec(
        "skybody/Hover-v0", num_envs=2, overrides=OBSERVED, dict_observations=True
    )
    assert isinstance(envs.single_observation_space, Dict)


def test_an_agent_sees_its_own_imu_alone() -> None:
    sensors = "[{plugin: imu, name: a, parameters: {robot: quad1}}, {plugin: imu, name: b, " + (
        "parameters: {robot: quad2}}]"
    )
    overrides = [f"sensors={sensors}", "observe=[a.angular_rate, b.angular_rate]"]
    env = ParallelEnv("formation_2", seed=1, overrides=overrides, dict_observations=True)
    flat = ParallelEnv("formation_2", seed=1, overrides=overrides)
    first, second = env.possible_agents
    seen, rows = env.reset()[0], flat.reset()[0]
    assert "a_angular_rate" in seen[first]
    assert "b_angular_rate" not in seen[first]
    assert "b_angular_rate" in seen[second]
    assert seen[first] in env.observation_space(first)
    np.testing.assert_array_equal(np.concatenate(list(seen[second].values())), rows[second])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        parallel_api_test(env, num_cycles=60)


@pytest.mark.parametrize(("policy", "as_dict"), [("MlpPolicy", False), ("MultiInputPolicy", True)])
def test_stable_baselines_trains_on_boxes_and_dictionaries(policy: Any, as_dict: bool) -> None:
    envs = SkybodyVecEnv("hover", N, seed=1, overrides=CRITIC, dict_observations=as_dict)
    model = PPO(policy, envs, n_steps=16, batch_size=32, device="cpu", seed=1)
    model.learn(3 * N * 16)
    assert model.num_timesteps == 3 * N * 16
    assert envs.last_info["privileged"].shape == (N, 3)
    envs.close()


def test_stable_baselines_terminal_observations_carry_all_columns() -> None:
    envs = SkybodyVecEnv("hover", N, seed=1, overrides=CRITIC, dict_observations=True)
    envs.reset()
    for step in range(20):
        envs.step_async(actions(step, N))
        _, _, dones, infos = envs.step_wait()
    assert dones.any()
    for i in np.flatnonzero(dones):
        assert infos[i]["terminal_observation"] in envs.observation_space
        assert infos[i]["privileged"].shape == (3,)
    envs.close()


def test_a_replay_compares_observed_and_privileged_values(tmp_path: Path) -> None:
    envs = envs_of(CRITIC)
    envs.record(tmp_path / "run.h5")
    envs.reset()
    for step in range(10):
        envs.step(actions(step, N))
    envs.close()
    with h5py.File(tmp_path / "run.h5") as file:
        assert file["columns"][-1] == b"gyro float32 [3] from imu.angular_rate, privileged"
        assert file["observation_names"][-1] == b"gyro[2]"
        assert file["transitions/observation"].shape == (11 * N, 28)
    done = subprocess.run(
        [str(PROGRAM), "replay", str(tmp_path / "run.h5")],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.stdout.startswith("identical"), done.stdout + done.stderr
