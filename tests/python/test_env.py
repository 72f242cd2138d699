"""A single environment by Gymnasium's own checks, and its ids."""

from __future__ import annotations

import subprocess
import sys

import gymnasium
import numpy as np
import pytest
import skybody
from gymnasium.utils.env_checker import check_env
from reference import SEED, Rollout, actions, short_hover
from skybody._native import shipped_scenarios
from skybody.env import SkybodyEnv
from skybody.registration import gymnasium_id


@pytest.mark.filterwarnings("ignore:.*infinity. This is probably too")
@pytest.mark.parametrize("scenario", ["hover", "payload", "formation"])
def test_passes_gymnasiums_check(scenario: str):
    """Positions have no bounds, so the warning about infinite bounds is expected."""
    with pytest.warns() as record:
        check_env(gymnasium.make(gymnasium_id(scenario)).unwrapped)
    others = [str(w.message) for w in record if "infinity" not in str(w.message)]
    assert others == []


def test_every_shipped_scenario_has_an_id():
    for scenario in shipped_scenarios():
        assert gymnasium_id(scenario) in gymnasium.registry
    assert gymnasium_id("hover_crazyflie") == "skybody/HoverCrazyflie-v0"


def test_gymnasium_make_gives_the_scenario():
    env = gymnasium.make("skybody/HoverCrazyflie-v0", seed=1)
    assert isinstance(env.unwrapped, SkybodyEnv)
    assert env.unwrapped.compiled.name == "hover_crazyflie"
    env.reset()
    env.step(env.action_space.sample())
    env.close()


def test_the_pool_works_where_gymnasium_is_not_installed():
    program = (
        "import sys; sys.modules['gymnasium'] = None\n"
        "import skybody\n"
        "print(skybody.make_pool('hover', 2).reset()[0].shape)\n"
        "skybody.make_vec('hover', 2)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout == "(2, 22)\n"
    assert "skybody.vector needs the package 'gymnasium" in done.stderr


@pytest.mark.parametrize("statement", ["import skybody.{}", "import skybody; skybody.{}"])
@pytest.mark.parametrize(
    ("module", "package", "extra"),
    [
        ("sb3", "stable_baselines3", "sb3"),
        ("sb3_adapter", "stable_baselines3", "sb3"),
        ("multi_agent", "pettingzoo", "multi-agent"),
    ],
)
def test_a_module_whose_package_is_missing_says_what_installs_it(
    module: str, package: str, extra: str, statement: str
):
    program = f"import sys; sys.modules[{package!r}] = None; {statement.format(module)}"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stderr.endswith(
        f"ImportError: skybody.{module} needs the package {package!r}: `pip install '.[{extra}]'` "
        "in Skybody's source folder\n"
    )


def test_steps_as_a_world_by_hand_does():
    compiled = short_hover()
    env, world = SkybodyEnv(compiled, seed=SEED, env_id=3), Rollout(compiled, 3)
    observation, _ = env.reset()
    np.testing.assert_array_equal(observation, world.first)
    for step in range(100):
        action = actions(step, 4)[3]
        observation, reward, terminated, truncated, info = env.step(action)
        row = world.step(action)
        np.testing.assert_array_equal(observation, row.observation)
        assert reward == row.reward
        assert (terminated, truncated) == (row.terminated, row.truncated)
        assert info["fault"] is False
        if row.first_of_next is not None:
            with pytest.raises(ValueError, match="ended"):
                env.step(action)
            np.testing.assert_array_equal(env.reset()[0], row.first_of_next)


def test_without_a_seed_two_environments_differ_and_with_one_they_do_not():
    compiled = short_hover()
    one, other = SkybodyEnv(compiled), SkybodyEnv(compiled)
    assert not np.array_equal(one.reset()[0], other.reset()[0])
    assert np.array_equal(one.reset(seed=3)[0], other.reset(seed=3)[0])
    assert np.array_equal(one.reset()[0], other.reset()[0])  # the second episode under seed 3


def test_restore_repeats_the_future():
    env = SkybodyEnv(short_hover(), seed=1)
    env.reset()
    saved = env.save()
    future = [env.step(actions(k, 1)[0])[0] for k in range(10)]
    env.restore(saved)
    np.testing.assert_array_equal([env.step(actions(k, 1)[0])[0] for k in range(10)], future)


def test_bad_arguments_are_refused():
    with pytest.raises(ValueError, match="render_mode"):
        SkybodyEnv("hover", render_mode="ansi")
    env = SkybodyEnv(short_hover())
    with pytest.raises(ValueError, match="reset"):
        env.step(np.zeros(4, np.float32))
    env.reset()
    with pytest.raises(ValueError, match="shape"):
        env.step(np.zeros(3, np.float32))
    with pytest.raises(TypeError, match="float32"):
        env.step(np.zeros(4))
    with pytest.raises(ValueError, match="option"):
        env.reset(options={"low": 0.0})
    env.close()
    with pytest.raises(skybody.Error, match="closed"):
        env.reset()
