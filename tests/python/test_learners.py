"""What the learners learn from: truncations, faults, spread episodes, moments."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch
from skybody._native import CompiledScenario
from skybody.train.lean_ppo import RunningMoments
from training import HORIZON, SCENARIO, SMALL, both, learner_of

pytestmark = pytest.mark.timeout(120)


@pytest.fixture(scope="module")
def compiled() -> CompiledScenario:
    return CompiledScenario(SCENARIO, [HORIZON])


class ScriptedPool:
    """Three environments whose episodes end in the first step: terminated, truncated, faulted."""

    def __init__(self, observations: int) -> None:
        self.step = 0
        self.observation = np.zeros((3, observations), np.float32)

    def send(self, actions: np.ndarray) -> None:
        assert actions.flags.c_contiguous and actions.dtype == np.float32

    def recv(self) -> SimpleNamespace:
        first, self.step = self.step == 0, self.step + 1
        return SimpleNamespace(
            observation=self.observation,
            final_observation=self.observation + 1.0,
            info=np.zeros((3, 1), np.float32),
            reward=np.array([1.0, 1.0, 0.0], np.float32),
            terminated=np.array([first, False, False]),
            truncated=np.array([False, first, first]),
            fault=np.array([False, False, first]),
        )

    def close(self) -> None:
        pass


def test_lean_ppo_bootstraps_truncations_from_the_last_observation_and_nothing_else(
    compiled: CompiledScenario,
) -> None:
    hyper = dataclasses.replace(
        SMALL, envs=3, rollout_steps=1, minibatch=3, normalize_rewards=False, discount=0.5
    )
    with learner_of("lean-ppo", compiled, hyper=hyper) as learner:
        learner.pool.close()
        learner.pool = ScriptedPool(compiled.observation_size)
        learner.observation = learner.pool.observation
        # the value of an observation: 2 plus its first entry
        learner.critic = torch.nn.Sequential(torch.nn.Linear(compiled.observation_size, 1))
        with torch.no_grad():
            learner.critic[0].weight.zero_()
            learner.critic[0].weight[0, 0] = 1.0
            learner.critic[0].bias.fill_(2.0)
        learner.mean, learner.scale = learner.moments.mean, torch.ones_like(learner.moments.mean)
        with torch.no_grad():
            truncations = learner._collect(
                SimpleNamespace(episode_returns=[], faults=0, environment_seconds=0.0)
            )
        _, returns = learner._advantages(truncations)
        # terminated: the reward; truncated: reward + 0.5 * (2 + 1); fault: nothing
        assert returns.tolist() == [[1.0, 2.5, 0.0]]


class Recorded:
    """A pool whose send_reset() is another function."""

    def __init__(self, pool: Any, send_reset: Callable[[Any], Any]) -> None:
        self._pool, self.send_reset = pool, send_reset

    def __getattr__(self, name: str) -> Any:
        return getattr(self._pool, name)


class Poisoned:
    """A pool to which environment 5's actions come as NaN."""

    def __init__(self, pool: Any) -> None:
        self._pool = pool

    def __getattr__(self, name: str) -> Any:
        return getattr(self._pool, name)

    def send(self, actions: np.ndarray, *others: Any) -> None:
        poisoned = actions.copy()
        poisoned[5] = math.nan
        self._pool.send(poisoned, *others)


@both
def test_an_environment_of_64_that_faults_in_every_step_leaves_the_weights_finite(
    algorithm: str, compiled: CompiledScenario
) -> None:
    hyper = dataclasses.replace(SMALL, envs=64, rollout_steps=16, minibatch=256)
    with learner_of(algorithm, compiled, hyper=hyper) as learner:
        if algorithm == "lean-ppo":
            learner.pool = Poisoned(learner.pool)
        else:
            learner.vec_env.native = Poisoned(learner.vec_env.native)
        for _ in range(3):
            assert learner.iterate().faults == 16
        for name, value in learner.parameters().items():
            assert bool(value.isfinite().all()), name


def test_lean_ppo_spreads_episodes_over_the_horizon(compiled: CompiledScenario) -> None:
    hyper = dataclasses.replace(SMALL, envs=8, rollout_steps=10, minibatch=40)
    with learner_of("lean-ppo", compiled, hyper=hyper) as learner:
        starts = []
        send_reset = learner.pool.send_reset
        learner.pool = Recorded(learner.pool, lambda mask: (starts.append(mask), send_reset(mask)))
        for _ in range(8):
            learner.iterate()
        # horizon 40: groups of 2 environments begin at 0 (all do), 10, 20 and 30 steps
        assert [np.flatnonzero(mask).tolist() for mask in starts] == [[2, 3], [4, 5], [6, 7]]


def test_running_moments_are_those_of_all_rows() -> None:
    rows = torch.from_numpy(np.random.default_rng(0).normal(3.0, 2.0, (500, 4)))
    moments = RunningMoments(4)
    for part in rows.split(120):
        moments.update(part)
    # float64 sums of 500 terms: some 500 rounding errors of 1e-16, relative
    torch.testing.assert_close(moments.mean, rows.mean(0), rtol=1e-12, atol=0)
    torch.testing.assert_close(moments.var, rows.var(0, correction=0), rtol=1e-12, atol=0)


@both
def test_observation_statistics_stay_after_normalization_steps(
    algorithm: str, compiled: CompiledScenario
) -> None:
    rollout = SMALL.envs * SMALL.rollout_steps
    hyper = dataclasses.replace(SMALL, normalization_steps=rollout)
    with learner_of(algorithm, compiled, hyper=hyper) as learner:
        means = [learner.policy().mean.copy()]
        for _ in range(3):
            learner.iterate()
            means.append(learner.policy().mean.copy())
    assert (means[1] != means[0]).any()
    for mean in means[2:]:
        np.testing.assert_array_equal(mean, means[1])
