"""Several robots: each an agent by PettingZoo's own tests, or one joint array without a copy."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test, parallel_seed_test
from skybody import make_vec
from skybody._native import CompiledScenario
from skybody.agents import commanded_by, observed_by
from skybody.multi_agent import ParallelEnv

SHORT = ("stepping.horizon=25",)


def hovering(env: ParallelEnv) -> dict[str, np.ndarray]:
    return {a: np.full(env.action_space(a).shape, 0.2, np.float32) for a in env.agents}


@pytest.mark.parametrize(
    "scenario", ["formation", "formation_obstacles", "cooperative_payload", "hover"]
)
def test_passes_pettingzoos_tests_without_a_warning(scenario: str):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(ParallelEnv(scenario, overrides=SHORT), num_cycles=60)
        parallel_seed_test(lambda: ParallelEnv(scenario, overrides=SHORT), num_cycles=60)


def test_agents_are_the_robots_by_name_and_end_together():
    env = ParallelEnv("formation", overrides=SHORT, seed=2)
    env.reset()
    assert env.agents == env.possible_agents == env.compiled.robots
    for step in range(25):
        _, _, terminations, truncations, infos = env.step(hovering(env))
        last = step == 24
        assert set(terminations.values()) == {False}
        assert set(truncations.values()) == {last}
        assert all(info["fault"] is False for info in infos.values())
    assert env.agents == []


def test_agents_see_their_own_channels_and_those_of_nobody():
    compiled = CompiledScenario("formation")
    env = ParallelEnv(compiled, seed=2)
    observations, _ = env.reset()
    row = env.state()
    for robot, agent in zip(compiled.agents, env.possible_agents, strict=True):
        expected = [
            row[channel.first : channel.first + channel.count]
            for channel in compiled.observation_channels
            if channel.robot in (robot, -1)
        ]
        np.testing.assert_array_equal(observations[agent], np.concatenate(expected))
        assert observations[agent] in env.observation_space(agent)
    owned = np.concatenate([commanded_by(compiled, robot) for robot in compiled.agents])
    assert sorted(owned.tolist()) == list(range(compiled.action_size))


def test_steps_as_the_vector_environment_does():
    compiled = CompiledScenario("formation", list(SHORT))
    env = ParallelEnv(compiled, seed=2)
    envs = make_vec(compiled, 1, seed=2)
    env.reset()
    envs.reset()
    for _ in range(20):
        observations, rewards, _, _, _ = env.step(hovering(env))
        rows, _, _, _, infos = envs.step(np.full((1, compiled.action_size), 0.2, np.float32))
        for k, (robot, agent) in enumerate(zip(compiled.agents, env.agents, strict=True)):
            np.testing.assert_array_equal(
                observations[agent], rows[0, observed_by(compiled, robot)]
            )
            assert rewards[agent] == infos["agent_reward"][0, k]


def test_a_joint_observation_is_a_view_of_agents_times_width():
    """The paper's arrays: (N, 18 + 16 (N - 1)) observed, (N, 4) commanded, one team reward."""
    compiled = CompiledScenario("formation")
    agents = len(compiled.agents)
    joint, flat = (make_vec(compiled, 3, seed=1, joint=flag) for flag in (True, False))
    assert joint.single_observation_space.shape == (agents, 18 + 16 * (agents - 1))
    assert joint.single_action_space.shape == (agents, 4)
    observations, _ = joint.reset()
    assert observations.shape == (3, agents, 18 + 16 * (agents - 1))
    assert not observations.flags.owndata
    assert observations in joint.observation_space
    np.testing.assert_array_equal(observations.reshape(3, -1), flat.reset()[0])
    given = np.full(joint.action_space.shape, 0.2, np.float32)
    given[1, 2] = -0.3
    ours, theirs = joint.step(given), flat.step(given.reshape(3, -1))
    np.testing.assert_array_equal(ours[0].reshape(3, -1), theirs[0])
    np.testing.assert_array_equal(ours[1], theirs[1])
    assert ours[1].shape == (3,)
    assert ours[4]["agent_reward"].shape == (3, agents)


def test_a_single_robot_is_a_joint_team_of_one():
    joint, flat = (make_vec("hover", 3, seed=1, joint=flag) for flag in (True, False))
    assert joint.single_observation_space.shape == (1, *flat.single_observation_space.shape)
    assert joint.single_action_space.shape == (1, 4)
    np.testing.assert_array_equal(joint.reset()[0][:, 0], flat.reset()[0])
    given = np.full((3, 4), 0.2, np.float32)
    for ours, theirs in zip(joint.step(given[:, None])[:4], flat.step(given)[:4], strict=True):
        np.testing.assert_array_equal(ours.reshape(theirs.shape), theirs)


def test_joint_final_obs_has_the_joint_shape():
    envs = make_vec("formation", 2, joint=True, autoreset="same_step", overrides=SHORT)
    envs.reset()
    given = np.full(envs.action_space.shape, 0.2, np.float32)
    for _ in range(25):
        infos = envs.step(given)[4]
    assert infos["final_obs"][0].shape == envs.single_observation_space.shape


def test_actions_that_are_missing_of_nobody_or_of_another_kind_are_refused():
    env = ParallelEnv("formation")
    env.reset()
    given = hovering(env)
    first, *rest = env.agents
    with pytest.raises(ValueError, match=f"no action for agent `{first}`"):
        env.step({agent: given[agent] for agent in rest})
    with pytest.raises(ValueError, match="an action for `nobody`, which is no agent; there must"):
        env.step({**given, "nobody": given[first]})
    with pytest.raises(ValueError, match="shape"):
        env.step({**given, first: np.zeros(3, np.float32)})
    with pytest.raises(TypeError, match="float32"):
        env.step({**given, first: np.zeros(4)})
    env.step(given)


def test_a_fault_of_one_robot_ends_the_episode_of_all():
    env = ParallelEnv("formation")
    env.reset()
    given = hovering(env)
    given[env.agents[1]] = np.full(4, np.nan, np.float32)
    observations, rewards, _, truncations, infos = env.step(given)
    assert all(truncations.values())
    assert all(info["fault"] for info in infos.values())
    assert all(np.isfinite(row).all() for row in observations.values())
    assert set(rewards.values()) == {0.0}
