"""What the learners learn from: faults, statistics of observations, noise."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from skybody._native import CompiledScenario
from training import HORIZON, SCENARIO, both, learner_of

pytestmark = pytest.mark.timeout(120)


@pytest.fixture(scope="module")
def compiled() -> CompiledScenario:
    return CompiledScenario(SCENARIO, [HORIZON])


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


def test_an_environment_of_64_that_faults_in_every_step_leaves_the_weights_finite(
    compiled: CompiledScenario,
) -> None:
    small = {"envs": 64, "rollout_steps": 16, "minibatch": 256}
    with learner_of("ppo", compiled, **small) as learner:
        learner.vec_env.native = Poisoned(learner.vec_env.native)
        for _ in range(3):
            assert learner.iterate().faults == 16
        for name, value in learner.parameters().items():
            assert bool(value.isfinite().all()), name


@both
def test_observation_statistics_stay_after_normalization_steps(
    algorithm: str, compiled: CompiledScenario
) -> None:
    with learner_of(algorithm, compiled, normalization_steps=300) as learner:  # one rollout
        means = [learner.policy().mean.copy()]
        for _ in range(3):
            learner.iterate()
            means.append(learner.policy().mean.copy())
    assert (means[1] != means[0]).any()
    for mean in means[2:]:
        np.testing.assert_array_equal(mean, means[1])


@both
def test_exploration_noise_falls_along_its_line(algorithm: str, compiled: CompiledScenario) -> None:
    small = {"envs": 4, "rollout_steps": 8, "minibatch": 16, "log_std": -1.0, "final_log_std": -3.0}
    with learner_of(algorithm, compiled, total_steps=64, **small) as learner:  # two rollouts
        for line in (-1.0, -2.0):
            deviation = learner.iterate().losses["action_std"]
            # One update after the rollout's start moves it by some learning rates (1e-3).
            assert abs(math.log(deviation) - line) < 0.1
