"""Data that Stable-Baselines3 learns from: rows around resets, bootstrapping, faults."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from reference import SEED, Rollout, actions, short_hover
from skybody.sb3 import SkybodyVecEnv
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecMonitor, VecNormalize

GAMMA = 0.5
NUM_ENVS = 6
STEPS = 40
EASY_TO_END = ("stepping.horizon=15", "task.parameters.tilt_max=0.05")

Change = Callable[[int, NDArray[np.float32]], None]


@dataclass
class Step:
    actions: NDArray[np.float32]
    rewards: NDArray[np.float32]
    dones: NDArray[np.bool_]
    infos: list[dict[str, Any]]


class Tap(VecEnvWrapper):
    """Records all rows and actions, and changes some actions."""

    def __init__(self, venv: VecEnv, change: Change | None = None) -> None:
        super().__init__(venv)
        self.steps: list[Step] = []
        self._change = change
        self._actions = np.empty(0, np.float32)

    def reset(self) -> Any:
        return self.venv.reset()

    def step_async(self, actions: NDArray[np.float32]) -> None:
        self._actions = actions.copy()
        if self._change is not None:
            self._change(len(self.steps), self._actions)
        super().step_async(self._actions)

    def step_wait(self) -> Any:
        result = self.venv.step_wait()
        self.steps.append(Step(self._actions, result[1].copy(), result[2].copy(), result[3]))
        return result


def value(observations: torch.Tensor) -> torch.Tensor:
    """A value function with a different value for every observation."""
    return observations @ torch.arange(1.0, observations.shape[1] + 1.0)[:, None]


def collected(change: Change | None = None) -> tuple[PPO, Tap]:
    """One rollout, bootstrapped with `value`."""
    tap = Tap(SkybodyVecEnv(short_hover(*EASY_TO_END), NUM_ENVS, seed=SEED), change)
    model = PPO(
        "MlpPolicy",
        tap,
        n_steps=STEPS,
        batch_size=60,
        n_epochs=1,
        gamma=GAMMA,
        seed=SEED,  # also of the environments
        policy_kwargs={"log_std_init": -2.0},
        device="cpu",
    )
    model.policy.predict_values = value  # type: ignore[method-assign]
    model.learn(STEPS * NUM_ENVS)
    return model, tap


def test_a_truncation_is_bootstrapped_from_the_observation_before_the_reset():
    model, tap = collected()
    compiled = short_hover(*EASY_TO_END)
    worlds = [Rollout(compiled, i) for i in range(NUM_ENVS)]
    truncations = terminations = 0
    for k, step in enumerate(tap.steps):
        for i, world in enumerate(worlds):
            row = world.step(step.actions[i])
            expected = np.float32(row.reward)
            if row.truncated and not row.terminated:
                terminal = torch.as_tensor(row.observation)[None]
                expected += np.float32(GAMMA) * np.float32(value(terminal).item())
                truncations += 1
            terminations += row.terminated
            # the same float32 product and sum, but in torch's order
            assert model.rollout_buffer.rewards[k, i] == pytest.approx(expected, rel=1e-5)
            assert step.dones[i] == (row.terminated or row.truncated)
    assert truncations > 0
    assert terminations > 0


def test_the_rollout_buffer_has_the_observations_that_were_acted_on():
    model, tap = collected()
    compiled = short_hover(*EASY_TO_END)
    for i in range(NUM_ENVS):
        world = Rollout(compiled, i)
        observation = world.first
        for k, step in enumerate(tap.steps):
            flat = i * STEPS + k  # training has put one environment's rows after the other's
            np.testing.assert_array_equal(model.rollout_buffer.observations[flat], observation)
            row = world.step(step.actions[i])
            observation = row.observation if row.first_of_next is None else row.first_of_next


def test_a_fault_is_not_bootstrapped():
    def break_one(step: int, given: NDArray[np.float32]) -> None:
        if step == 5:
            given[2] = np.nan

    model, tap = collected(break_one)
    info = tap.steps[5].infos[2]
    assert tap.steps[5].dones[2]
    assert info["fault"] is True
    assert info["TimeLimit.truncated"] is False
    assert np.isfinite(info["terminal_observation"]).all()
    assert model.rollout_buffer.rewards[5, 2] == 0.0


def test_time_limit_truncated_is_false_where_the_task_terminated():
    _, tap = collected()
    ended = [info for step in tap.steps for info in step.infos if info]
    flags = {info["TimeLimit.truncated"] for info in ended}
    assert flags == {True, False}
    assert all(info["fault"] is False for info in ended)


def test_infos_stand_only_where_episodes_ended():
    _, tap = collected()
    for step in tap.steps:
        for done, info in zip(step.dones, step.infos, strict=True):
            assert ("terminal_observation" in info) == bool(done)


def test_what_is_returned_stays_as_it_was():
    """Stable-Baselines3 and its callbacks keep these arrays over later steps."""
    envs = SkybodyVecEnv(short_hover(), NUM_ENVS, seed=SEED)
    kept: list[tuple[NDArray[Any], NDArray[Any]]] = []
    kept.append((first := envs.reset(), first.copy()))
    for step in range(60):
        observations, rewards, dones, infos = envs.step(actions(step, NUM_ENVS))
        rows = [info["terminal_observation"] for info in infos if info]
        kept += [(array, array.copy()) for array in (observations, rewards, dones, *rows)]
    for array, as_it_was in kept:
        np.testing.assert_array_equal(array, as_it_was)
    assert envs.native.fresh_buffers == 0


@pytest.mark.parametrize("normalise", [False, True])
def test_one_faulting_environment_of_64_leaves_ppos_weights_finite(normalise: bool):
    def break_one(step: int, given: NDArray[np.float32]) -> None:
        if step % 3 == 0:
            given[17] = np.nan

    tap = Tap(SkybodyVecEnv(short_hover(), 64, seed=SEED), break_one)
    envs: VecEnv = VecNormalize(tap) if normalise else tap
    model = PPO("MlpPolicy", envs, n_steps=16, batch_size=256, n_epochs=2, seed=1, device="cpu")
    model.learn(3 * 16 * 64)
    assert all(torch.isfinite(parameter).all() for parameter in model.policy.parameters())
    assert tap.venv.faults == sum(step.infos[17].get("fault", False) for step in tap.steps)
    assert tap.venv.faults >= len(tap.steps) // 4
    others = [info for step in tap.steps for i, info in enumerate(step.infos) if i != 17]
    assert not any(info.get("fault", False) for info in others)


def test_the_replay_buffers_next_observation_is_the_one_before_the_reset():
    tap = Tap(SkybodyVecEnv(short_hover(*EASY_TO_END), 2, seed=SEED))
    model = SAC("MlpPolicy", tap, learning_starts=1000, buffer_size=200, seed=3, device="cpu")
    model.learn(80)
    buffer = model.replay_buffer
    assert buffer is not None
    ends = 0
    for k, step in enumerate(tap.steps):
        for i, info in enumerate(step.infos):
            if info:
                np.testing.assert_array_equal(
                    buffer.next_observations[k, i], info["terminal_observation"]
                )
                assert buffer.timeouts[k, i] == info["TimeLimit.truncated"]
                ends += 1
    assert ends > 0


def test_vec_monitor_reports_episodes_that_truly_ended():
    envs = VecMonitor(SkybodyVecEnv(short_hover(*EASY_TO_END), NUM_ENVS, seed=SEED))
    envs.reset()
    lengths = []
    for step in range(60):
        infos = envs.step(actions(step, NUM_ENVS))[3]
        lengths += [info["episode"]["l"] for info in infos if "episode" in info]
    assert max(lengths) == 15


def test_seed_sets_the_next_reset_and_reproduces():
    envs = SkybodyVecEnv(short_hover(), NUM_ENVS, seed=SEED)
    first = envs.reset()
    assert envs.seed(11) == [11] * NUM_ENVS
    seeded = envs.reset()
    assert not np.array_equal(seeded, first)
    assert not np.array_equal(envs.reset(), seeded)
    envs.seed(11)
    np.testing.assert_array_equal(envs.reset(), seeded)
    envs.seed(SEED)
    np.testing.assert_array_equal(envs.reset(), first)


def test_restore_repeats_the_future():
    envs = SkybodyVecEnv(short_hover(), NUM_ENVS, seed=SEED)
    envs.reset()
    observations = envs.step(actions(0, NUM_ENVS))[0]
    saved = envs.save()
    future = [envs.step(actions(k, NUM_ENVS))[0] for k in range(50)]
    np.testing.assert_array_equal(envs.restore(saved), observations)
    again = [envs.step(actions(k, NUM_ENVS))[0] for k in range(50)]
    np.testing.assert_array_equal(again, future)


def test_attributes_and_methods_of_environments():
    envs = SkybodyVecEnv(short_hover(), 3)
    path = "robots.quad.links.base_link.mass"
    assert envs.get_attr("render_mode") == [None] * 3
    assert envs.get_attr("num_envs", [0, 2]) == [3, 3]
    assert not envs.has_attr("no_such")
    envs.reset()
    (mass,) = envs.env_method("param", path, indices=1)
    envs.env_method("set_param", path, 1.1 * mass, indices=[1])
    assert envs.env_method("param", path) == [mass, 1.1 * mass, mass]
    with pytest.raises(AttributeError, match="no method `render`"):
        envs.env_method("render")
    with pytest.raises(AttributeError, match="set_param"):
        envs.set_attr("mass", 1.0)
    with pytest.raises(ValueError, match="unknown reset option `low`"):
        envs.set_options({"low": 1})
    assert envs.env_is_wrapped(VecMonitor) == [False] * 3
