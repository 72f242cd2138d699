"""The vector environment against worlds stepped by hand, in each autoreset mode."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
import skybody
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from reference import SEED, STEPS, Rollout, actions, short_hover
from skybody import make_vec
from skybody.env import SkybodyEnv
from skybody.vector import SkybodyVectorEnv

NUM_ENVS = 10


def make(autoreset: str = "next_step", **options: Any) -> SkybodyVectorEnv:
    return make_vec(short_hover(), NUM_ENVS, seed=SEED, autoreset=autoreset, **options)


def rollouts() -> list[Rollout]:
    compiled = short_hover()
    return [Rollout(compiled, i) for i in range(NUM_ENVS)]


def test_spaces_are_those_of_the_channels():
    envs = make()
    assert envs.single_observation_space.shape == (22,)
    assert envs.single_observation_space.dtype == np.float32
    assert envs.observation_space.shape == (NUM_ENVS, 22)
    assert np.all(envs.single_action_space.low == -1.0)
    assert np.all(envs.single_action_space.high == 1.0)
    assert envs.action_space.shape == (NUM_ENVS, 4)
    low, high = envs.single_observation_space.low, envs.single_observation_space.high
    for channel in envs.compiled.observation_channels:
        part = slice(channel.first, channel.first + channel.count)
        assert np.all(low[part] == np.float32(channel.low))
        assert np.all(high[part] == np.float32(channel.high))


def test_all_observations_of_a_rollout_lie_in_the_space():
    envs = make()
    observations, _ = envs.reset(seed=3)
    for step in range(STEPS):
        assert observations in envs.observation_space
        observations, rewards, terminations, truncations, _ = envs.step(actions(step, NUM_ENVS))
        assert rewards.dtype == np.float32
        assert terminations.dtype == truncations.dtype == np.bool_


def test_next_step_ignores_the_action_after_an_end_and_resets_instead():
    envs, worlds = make("next_step"), rollouts()
    observations, _ = envs.reset()
    pending: list[np.ndarray | None] = [None] * NUM_ENVS
    resets = 0
    for i, world in enumerate(worlds):
        np.testing.assert_array_equal(observations[i], world.first)
    for step in range(STEPS):
        given = actions(step, NUM_ENVS)
        observations, rewards, terminations, truncations, _ = envs.step(given)
        for i, world in enumerate(worlds):
            if pending[i] is not None:
                np.testing.assert_array_equal(observations[i], pending[i])
                assert rewards[i] == 0.0
                assert not terminations[i]
                assert not truncations[i]
                pending[i] = None
                resets += 1
                continue
            row = world.step(given[i])
            np.testing.assert_array_equal(observations[i], row.observation)
            assert rewards[i] == np.float32(row.reward)
            assert (terminations[i], truncations[i]) == (row.terminated, row.truncated)
            pending[i] = row.first_of_next
    assert resets >= NUM_ENVS


def test_same_step_gives_the_reset_row_and_the_last_row_as_final_obs():
    envs, worlds = make("same_step"), rollouts()
    envs.reset()
    ends = 0
    for step in range(STEPS):
        given = actions(step, NUM_ENVS)
        observations, rewards, terminations, truncations, infos = envs.step(given)
        for i, world in enumerate(worlds):
            row = world.step(given[i])
            assert rewards[i] == np.float32(row.reward)
            assert (terminations[i], truncations[i]) == (row.terminated, row.truncated)
            if row.first_of_next is None:
                np.testing.assert_array_equal(observations[i], row.observation)
                assert "final_obs" not in infos or infos["final_obs"][i] is None
            else:
                np.testing.assert_array_equal(observations[i], row.first_of_next)
                assert infos["_final_obs"][i]
                np.testing.assert_array_equal(infos["final_obs"][i], row.observation)
                ends += 1
    assert ends >= NUM_ENVS


def test_final_obs_keeps_its_values_while_later_steps_reuse_the_buffers():
    envs = make("same_step")
    envs.reset()
    kept: list[tuple[np.ndarray, np.ndarray]] = []
    for step in range(STEPS):
        infos = envs.step(actions(step, NUM_ENVS))[4]
        for row in infos.get("final_obs", []):
            if row is not None:
                kept.append((row, row.copy()))
    assert kept
    for row, as_it_was in kept:
        assert row.flags.owndata  # keeping a row does not keep the whole buffer
        np.testing.assert_array_equal(row, as_it_was)


def test_disabled_leaves_ended_environments_to_the_reset_mask():
    envs, worlds = make("disabled"), rollouts()
    envs.reset()
    ends = 0
    for step in range(STEPS):
        given = actions(step, NUM_ENVS)
        observations, _, terminations, truncations, _ = envs.step(given)
        rows = [world.step(given[i]) for i, world in enumerate(worlds)]
        for i, row in enumerate(rows):
            np.testing.assert_array_equal(observations[i], row.observation)
        ended = terminations | truncations
        if not ended.any():
            continue
        observations, infos = envs.reset(options={"reset_mask": ended})
        np.testing.assert_array_equal(infos["_fault"], ended)
        for i, row in enumerate(rows):
            expected = row.first_of_next if ended[i] else row.observation
            np.testing.assert_array_equal(observations[i], expected)
        ends += int(ended.sum())
    assert ends >= NUM_ENVS


def test_disabled_refuses_to_step_an_ended_environment():
    envs = make("disabled")
    envs.reset()
    with pytest.raises(ValueError, match="ended"):
        for step in range(STEPS):
            envs.step(actions(step, NUM_ENVS))


@pytest.mark.parametrize("mode", list(AutoresetMode))
@pytest.mark.parametrize("scenario", ["hover", "payload", "formation_2"])
def test_every_mode_gives_what_gymnasiums_own_sync_vector_env_gives(
    mode: AutoresetMode, scenario: str
):
    """Compares observations, rewards, ends, and infos with their masks, key by key.

    With SAME_STEP, `fault` and `agent_reward` beside `final_info` differ by design: ours belong to
    the transition, like the reward and the flags.
    """
    compiled = short_hover() if scenario == "hover" else short(scenario)
    ours = make_vec(compiled, NUM_ENVS, autoreset=mode)
    theirs = SyncVectorEnv(
        [lambda i=i: SkybodyEnv(compiled, env_id=i) for i in range(NUM_ENVS)],
        autoreset_mode=mode,
    )
    assert ours.metadata["autoreset_mode"] is theirs.metadata["autoreset_mode"]
    assert ours.observation_space == theirs.observation_space
    assert ours.action_space == theirs.action_space
    same = [ours.reset(seed=5), theirs.reset(seed=[5] * NUM_ENVS)]
    for step in range(STEPS):
        assert_equal(same[0], same[1])
        given = actions(step, NUM_ENVS, compiled.action_size)
        if step % 7 == 0:
            given[step % NUM_ENVS, 0] = np.nan
        same = [ours.step(given), theirs.step(given)]
        ended = same[0][2] | same[0][3]
        if mode is AutoresetMode.DISABLED and ended.any():
            assert_equal(same[0], same[1])
            same = [envs.reset(options={"reset_mask": ended.copy()}) for envs in (ours, theirs)]
        if mode is AutoresetMode.SAME_STEP:
            for _, _, _, _, infos in same:
                del infos["fault"]
                for key in ("agent_reward", "fault_reason", "_fault_reason"):
                    infos.pop(key, None)


def short(scenario: str) -> skybody.CompiledScenario:
    """Episodes of 23 steps of 5 ms."""
    return skybody.CompiledScenario(scenario, ["stepping.action_repeat=5", "stepping.horizon=23"])


def assert_equal(ours: Any, theirs: Any) -> None:
    """Equal values and, in dictionaries, equal keys; rewards may be float32 or float64."""
    if isinstance(ours, dict):
        assert ours.keys() == theirs.keys()
        for key in ours:
            assert_equal(ours[key], theirs[key])
    elif isinstance(ours, tuple):
        for one, other in zip(ours, theirs, strict=True):
            assert_equal(one, other)
    elif isinstance(ours, np.ndarray) and ours.dtype == object:
        assert theirs.dtype == object
        for one, other in zip(ours, theirs, strict=True):
            assert_equal(one, other)
    else:
        np.testing.assert_array_equal(ours, theirs)


def test_the_horizon_truncates_and_the_task_terminates():
    calm = make_vec(short_hover("task.parameters.tilt_max=3"), 2, seed=SEED, autoreset="disabled")
    calm.reset()
    for step in range(40):
        _, _, terminations, truncations, _ = calm.step(actions(step, 2))
        assert not terminations.any()
        assert truncations.all() == (step == 39)
    tilting = make_vec(short_hover("stepping.horizon=0"), 2, seed=SEED, autoreset="disabled")
    tilting.reset()
    for step in range(STEPS):
        _, _, terminations, truncations, _ = tilting.step(actions(step, 2))
        assert not truncations.any()
        if terminations.any():
            return
    pytest.fail("no episode was terminated")


def rollout_of(envs: SkybodyVectorEnv, seed: int | None = None, steps: int = 50) -> np.ndarray:
    rows = [envs.reset(seed=seed)[0].copy()]
    rows += [envs.step(actions(step, envs.num_envs))[0].copy() for step in range(steps)]
    return np.stack(rows)


def test_a_seed_reproduces_and_another_differs():
    envs = make()
    one = rollout_of(envs, seed=1)
    assert np.array_equal(one, rollout_of(envs, seed=1))
    assert np.array_equal(one, rollout_of(make(num_threads=1), seed=1))
    assert not np.array_equal(one, rollout_of(envs, seed=2))


def test_a_reset_without_seed_begins_the_next_episodes():
    envs = make()
    first, again = rollout_of(envs), rollout_of(envs)
    assert not np.array_equal(first[0], again[0])
    np.testing.assert_array_equal(first, rollout_of(envs, seed=SEED))
    np.testing.assert_array_equal(first, rollout_of(make()))


def test_environments_of_one_seed_differ_from_each_other():
    observations, _ = make().reset(seed=1)
    assert len(np.unique(observations, axis=0)) == NUM_ENVS


def test_a_nan_action_faults_its_environment_and_the_others_go_on():
    envs, untouched = make(), make()
    envs.reset()
    untouched.reset()
    given = actions(0, NUM_ENVS)
    bad = given.copy()
    bad[3, 1] = np.nan
    expected = untouched.step(given)
    observations, rewards, terminations, truncations, infos = envs.step(bad)
    others = np.arange(NUM_ENVS) != 3
    np.testing.assert_array_equal(observations[others], expected[0][others])
    np.testing.assert_array_equal(rewards[others], expected[1][others])
    np.testing.assert_array_equal(infos["fault"], ~others)
    assert set(infos["fault_reason"][~others]) == {"the action was not finite"}
    assert set(infos["fault_reason"][others]) == {None}
    np.testing.assert_array_equal(truncations, ~others)
    assert not terminations.any()
    assert np.isfinite(observations).all()
    assert np.isfinite(rewards).all()
    assert envs.faults == 1
    assert untouched.faults == 0


def test_same_step_tells_a_fault_beside_the_flags_and_in_final_info():
    envs = make("same_step")
    envs.reset()
    given = actions(0, NUM_ENVS)
    given[3] = np.inf
    _, _, _, truncations, infos = envs.step(given)
    assert truncations[3]
    assert infos["fault"][3]
    assert infos["final_info"]["fault"][3]
    assert infos["final_info"]["_fault"].sum() == 1
    for each in (infos, infos["final_info"]):
        assert each["fault_reason"].tolist() == [
            "the action was not finite" if i == 3 else None for i in range(NUM_ENVS)
        ]
        np.testing.assert_array_equal(each["_fault_reason"], each["fault"])


def test_observations_are_views_that_survive_as_long_as_they_are_held():
    envs = make()
    observations, _ = envs.reset()
    assert not observations.flags.owndata
    held = [observations]
    values = [observations.copy()]
    for step in range(10):
        held.append(envs.step(actions(step, NUM_ENVS))[0])
        values.append(held[-1].copy())
    for view, value in zip(held, values, strict=True):
        np.testing.assert_array_equal(view, value)
    assert envs.native.fresh_buffers > 0
    del held, view, observations
    before = envs.native.fresh_buffers
    for step in range(10):
        envs.step(actions(step, NUM_ENVS))
    assert envs.native.fresh_buffers <= before + 2  # the two buffers held when counting began


def test_gymnasium_make_vec_gives_the_native_one():
    envs = gymnasium.make_vec(
        "skybody/Hover-v0", num_envs=3, vectorization_mode="vector_entry_point", seed=SEED
    )
    assert isinstance(envs.unwrapped, SkybodyVectorEnv)
    expected, _ = make_vec("hover", 3, seed=SEED).reset()
    np.testing.assert_array_equal(envs.reset()[0], expected)
    envs.close()


def test_gymnasiums_vector_wrappers_work_on_it():
    envs = gymnasium.wrappers.vector.RecordEpisodeStatistics(make("next_step"))
    envs.reset(seed=1)
    lengths = []
    for step in range(STEPS):
        infos = envs.step(actions(step, NUM_ENVS))[4]
        if "episode" in infos:
            lengths += infos["episode"]["l"][infos["_episode"]].tolist()
    assert lengths
    assert max(lengths) == 40


def test_without_infos_rows_rewards_and_ends_are_the_same() -> None:
    with_infos = skybody.make_vec("hover", 16, num_threads=1, seed=3)
    without = skybody.make_vec("hover", 16, num_threads=1, seed=3, infos=False)
    for envs in (with_infos, without):
        envs.reset()
    actions = np.full((16, 4), 0.2, np.float32)
    for _ in range(50):
        observation, reward, terminated, truncated, infos = with_infos.step(actions)
        other = without.step(actions)
        for a, b in zip((observation, reward, terminated, truncated), other[:4], strict=True):
            np.testing.assert_array_equal(a, b)
        assert "position_error" in infos
        assert set(other[4]) == {"fault", "_fault"}
    with_infos.close()
    without.close()


def test_a_start_inside_an_obstacle_is_a_fault_with_its_reason():
    hall = "obstacles=[{name: hall, box: [50, 50, 20]}]"
    above = "robots.quad.pose.position=[0, 0, 20]"
    envs = skybody.make_vec(
        skybody.CompiledScenario("hover", [hall, "contact.redraws=2", above]), 2
    )
    _, infos = envs.reset(seed=1)
    assert infos["fault"].all()
    reason = infos["fault_reason"][0]
    assert reason.startswith("robot `quad` begins inside the obstacle `hall`, by ")
    assert reason.endswith("or raise `contact.redraws` (2)")
    envs.close()
