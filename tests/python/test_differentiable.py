"""Derivatives of transitions, from Python."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest
import skybody
from skybody import DifferentiableEnv

STEPS = 12
STEP = 2.0**-8  # of differences, exact in float32


class Flight:
    """A flight of random actions, and a weighted sum over its observations and rewards."""

    def __init__(self, scenario, num_envs=3, steps=STEPS, **options):
        self.env = DifferentiableEnv(scenario, num_envs, steps=steps, seed=4, **options)
        compiled = self.env.compiled
        random = np.random.default_rng(7)
        self.actions = self.random(random, (steps, num_envs, compiled.action_size))
        self.slopes = random.normal(size=(steps, num_envs, compiled.observation_size))
        self.slopes = self.slopes.astype(np.float32)
        self.reward_slopes = random.normal(size=(steps, num_envs)).astype(np.float32)

    @staticmethod
    def random(random, shape):
        return random.uniform(-0.3, 0.7, shape).astype(np.float32)

    def sums(self, actions):
        self.env.reset(seed=4)
        total = np.zeros(self.env.num_envs)
        for action, slope, by_reward in zip(actions, self.slopes, self.reward_slopes, strict=True):
            observation, reward, _, _ = self.env.step(action)
            total += (observation.astype(float) * slope).sum(axis=1) + by_reward * reward
        return total

    def gradient(self):
        self.sums(self.actions)
        result, d_state, end = np.empty_like(self.actions), None, self.env.transition
        for back in range(1, len(self.actions) + 1):
            slopes = self.slopes[-back], self.reward_slopes[-back]
            result[-back], d_state = self.env.pull_back(end - back, *slopes, d_state)
        return result

    def differences(self, t, k):
        """Left and right, of every environment."""
        nudge = np.zeros_like(self.actions)
        nudge[t, :, k] = STEP
        here = self.sums(self.actions)
        right = (self.sums(self.actions + nudge) - here) / STEP
        return (here - self.sums(self.actions - nudge)) / STEP, right


@pytest.mark.parametrize("scenario", ["hover_learn", "payload", "windy_hover", "trajectory"])
def test_gradients_are_those_of_differences(scenario):
    flight = Flight(scenario)
    gradient = flight.gradient()
    size = np.abs(gradient).max()
    smooth = 0
    for t, k in ((0, 0), (3, 1), (7, 2), (STEPS - 1, 3)):
        left, right = flight.differences(t, k)
        # Where they differ a rotor changed between speeding up and slowing down: no derivative.
        where = np.abs(right - left) < 0.02 * size
        # Rows are floats, errors of 1e-7 of values of about 10, over a step of 2^-8.
        central = (left + right) / 2
        np.testing.assert_allclose(gradient[t, where, k], central[where], atol=6e-3 * size)
        smooth += where.sum()
    assert smooth >= 9  # of 12


def test_steps_are_those_of_vector_environments():
    envs = skybody.make_vec("hover_learn", 33, seed=4)
    flight = Flight("hover_learn", 33)
    np.testing.assert_array_equal(flight.env.reset(), envs.reset()[0])
    for action in flight.actions:
        observations, rewards, terminated, truncated = flight.env.step(action)
        expected = envs.step(action)
        np.testing.assert_array_equal(observations, expected[0])
        np.testing.assert_array_equal(rewards, expected[1].astype(np.float32))
        np.testing.assert_array_equal(terminated, expected[2])
        np.testing.assert_array_equal(truncated, expected[3])


def test_gradients_do_not_depend_on_the_other_environments():
    many, few = Flight("hover_learn", 33, 4), Flight("hover_learn", 2, 4)
    for name in ("actions", "slopes", "reward_slopes"):
        setattr(few, name, getattr(many, name)[:, :2])
    np.testing.assert_array_equal(many.gradient()[:, :2], few.gradient())


def test_the_derivative_by_a_clipped_value_is_zero():
    flight = Flight("hover_learn", 1)
    flight.actions[3, 0, 1] = 1.5
    gradient = flight.gradient()
    assert gradient[3, 0, 1] == 0.0
    assert np.count_nonzero(gradient) == gradient.size - 1


def test_an_environment_stands_still_after_its_episode():
    flight = Flight("hover_learn", 2, 6, overrides=["stepping.horizon=3"])
    env = flight.env
    env.reset()
    results = [env.step(action) for action in flight.actions]
    for observation, reward, _, truncated in results[3:]:
        np.testing.assert_array_equal(observation, results[2][0])
        assert truncated.all() and not reward.any()
    # The repeated observation has the derivatives of the last one of the episode.
    slope = flight.slopes[0]
    d_action, d_state = env.pull_back(5, slope, flight.reward_slopes[0])
    assert not d_action.any()
    for t in (4, 3):
        _, d_state = env.pull_back(t, d_state=d_state)
    through, _ = env.pull_back(2, d_state=d_state)
    np.testing.assert_array_equal(through, env.pull_back(2, slope)[0])
    assert through.any()


def test_a_fault_ends_the_derivatives_of_its_environment_alone():
    flight = Flight("hover_learn", 2)
    expected = flight.gradient()
    flight.actions[5, 0] = np.nan
    gradient = flight.gradient()
    np.testing.assert_array_equal(gradient[:, 1], expected[:, 1])
    assert not gradient[5:, 0].any()
    assert gradient[:5, 0].any() and np.isfinite(gradient).all()


def test_resets_follow_seeds_and_number_transitions_on():
    env = DifferentiableEnv("hover_learn", 2, steps=3, seed=4)
    first, second = env.reset(), env.reset()
    assert (first != second).any()
    np.testing.assert_array_equal(env.reset(seed=4), first)
    env.step(np.zeros((2, 4), np.float32))
    env.reset()
    assert env.transition == 1


@pytest.mark.parametrize(
    ("scenario", "overrides", "error", "words"),
    [
        ("formation_2", [], skybody.InputError, ["formation.yaml:", "`formation`", "fast-ppo"]),
        ("payload", ["observe=[imu.angular_rate]"], skybody.InputError, ["`imu`", "observe"]),
        ("hover_learn", ["stepping.integrator=cvode"], skybody.Error, ["integrator", "midpoint"]),
    ],
)
def test_a_scenario_without_derivatives_is_refused_in_one_line(scenario, overrides, error, words):
    with pytest.raises(error) as raised:
        DifferentiableEnv(scenario, overrides=overrides)
    assert "\n" not in str(raised.value)
    for word in words:
        assert word in str(raised.value)


def test_the_pages_block_runs():
    page = (Path(__file__).resolve().parents[2] / "docs/python.md").read_text()
    section = page.partition("## Gradients through the dynamics")[2]
    names: dict[str, np.ndarray] = {}
    exec(section.partition("```python\n")[2].partition("```")[0], names)
    assert names["gradient"].any(axis=(0, 2)).all()


def test_wrong_calls_are_refused():
    env = DifferentiableEnv("hover_learn", 2, steps=1)
    action = np.zeros((2, 4), np.float32)
    with pytest.raises(skybody.Error, match=r"before reset\(\)"):
        env.step(action)
    env.reset()
    with pytest.raises(skybody.Error, match=r"transition 0 is not in the record.*empty"):
        env.pull_back(0)
    with pytest.raises(TypeError, match="actions has dtype float64; expected float32"):
        env.step(action.astype(float))
    with pytest.raises(ValueError, match=r"actions has shape \(1, 4\); expected \(2, 4\)"):
        env.step(action[:1])
    env.step(action)
    with pytest.raises(skybody.Error, match="`steps` is 1"):
        env.step(action)
    with pytest.raises(ValueError, match=r"d_reward has shape \(3,\); expected \(2,\)"):
        env.pull_back(0, d_reward=np.zeros(3, np.float32))
    with pytest.raises(ValueError, match="d_state has shape"):
        env.pull_back(0, d_state=np.zeros((2, 1)))
    env.reset()
    with pytest.raises(skybody.Error, match="transition 0 is not in the record"):
        env.pull_back(0)
    with pytest.raises(TypeError, match="cannot be pickled"):
        pickle.dumps(env)
    with pytest.raises(ValueError, match="steps is 0; it must be from 1"):
        DifferentiableEnv("hover_learn", steps=0)
    with pytest.raises(TypeError, match="num_env"):
        DifferentiableEnv("hover_learn", num_env=3)
