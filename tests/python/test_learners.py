"""Data that learners train on: faults, statistics of observations, noise."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
import pytest
from skybody._native import CompiledScenario, Error
from skybody.train import parameter_hash
from skybody.train.sb3_policy import QuickPolicy
from stable_baselines3.common.policies import ActorCriticPolicy
from training import HORIZON, SCENARIO, both, learner_of

pytestmark = pytest.mark.timeout(120)


@pytest.fixture(scope="module")
def compiled() -> CompiledScenario:
    return CompiledScenario(SCENARIO, [HORIZON])


class Poisoned:
    """A pool that replaces environment 5's actions by NaN."""

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


@pytest.mark.parametrize("bounded_mean", [False, True])
def test_a_rollout_of_ppo_is_that_of_stable_baselines3(
    bounded_mean: bool, compiled: CompiledScenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    def second_rollout() -> dict[str, np.ndarray]:
        with learner_of(
            "ppo", compiled, minibatch=60, rollout_steps=20, bounded_mean=bounded_mean
        ) as learner:
            learner.iterate()
            policy = learner.policy()
            learner.iterate()
            found = vars(learner.model.rollout_buffer)
            names = ("observations", "actions", "values", "log_probs", "returns", "advantages")
            return {name: found[name].copy() for name in names} | {"mean": policy.mean}

    ours = second_rollout()
    with monkeypatch.context() as patch:
        patch.setattr(QuickPolicy, "forward", ActorCriticPolicy.forward)
        theirs = second_rollout()
    for name, values in theirs.items():
        # Two rollouts and an update in single precision: some hundred roundings of 1e-7 of values
        # up to 10, amplified by the flight.
        np.testing.assert_allclose(ours[name], values, rtol=1e-4, atol=2e-4, err_msg=name)


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
            # One update after the start of the rollout changes it by a few learning rates (1e-3).
            assert abs(math.log(deviation) - line) < 0.1


@both
@pytest.mark.parametrize("part", ["state", "environments"])
def test_a_refused_checkpoint_leaves_the_learner_as_it_was(
    algorithm: str, part: str, compiled: CompiledScenario
) -> None:
    with learner_of(algorithm, compiled) as learner, learner_of(algorithm, compiled) as other:
        learner.iterate()
        earlier = copy.deepcopy(learner.save())
        state, environments = earlier.state, earlier.environments
        learner.iterate()
        wanted = [parameter_hash(learner.parameters()), learner.save().environments, learner.steps]
        if part == "state":
            del state[list(state)[-1]]  # the entry that is restored last
        else:
            environments = environments[:-16] + bytes(16)
        with pytest.raises((Error, KeyError, ValueError)):
            learner.restore(state, environments)
        assert [
            parameter_hash(learner.parameters()),
            learner.save().environments,
            learner.steps,
        ] == wanted
        saved = copy.deepcopy(learner.save())
        learner.iterate()
        other.restore(
            saved.state, saved.environments
        )  # with PyTorch's generator, shared by all learners of a process
        other.iterate()
        assert parameter_hash(learner.parameters()) == parameter_hash(other.parameters())
