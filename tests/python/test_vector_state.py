"""Saving, restoring, forking and setting parameters through the vector environment."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from reference import SEED, actions, short_hover
from skybody import make_vec
from skybody.vector import SkybodyVectorEnv

NUM_ENVS = 10


def make(autoreset: str = "next_step", **options: Any) -> SkybodyVectorEnv:
    return make_vec(short_hover(), NUM_ENVS, seed=SEED, autoreset=autoreset, **options)


def future(envs: SkybodyVectorEnv, steps: int = 60) -> np.ndarray:
    return np.stack([envs.step(actions(step, NUM_ENVS))[0].copy() for step in range(steps)])


def test_restore_repeats_the_future_also_in_another_vector_environment():
    envs = make()
    envs.reset()
    future(envs, 17)
    now = envs.observations()
    saved = envs.save()
    after = future(envs)
    envs.restore(saved)
    np.testing.assert_array_equal(envs.observations(), now)
    np.testing.assert_array_equal(future(envs), after)
    other = make(num_threads=1)
    other.restore(saved)
    np.testing.assert_array_equal(future(other), after)


def test_restore_refuses_what_save_did_not_give():
    envs = make()
    envs.reset()
    saved = envs.save()
    with pytest.raises(ValueError, match="environments"):
        make_vec(short_hover(), NUM_ENVS + 1).restore(saved)
    with pytest.raises(ValueError):
        make_vec("payload", NUM_ENVS).restore(saved)
    with pytest.raises(ValueError):
        envs.restore(saved[:-3])


def test_fork_copies_the_future_and_rekey_gives_each_copy_its_own():
    def futures(rekey: bool) -> np.ndarray:
        envs = make("same_step")
        envs.reset()
        future(envs, 9)
        envs.fork(2, [0, 5], rekey=rekey)
        np.testing.assert_array_equal(envs.observations()[[0, 5]], envs.observations()[[2, 2]])
        same = np.tile(actions(0, NUM_ENVS)[1], (NUM_ENVS, 1))
        return np.stack(
            [envs.step(same)[0][[0, 2, 5]] for _ in range(80)]
        )  # longer than an episode

    alike, own = futures(rekey=False), futures(rekey=True)
    np.testing.assert_array_equal(alike[:, 0], alike[:, 1])
    np.testing.assert_array_equal(alike[:, 2], alike[:, 1])
    np.testing.assert_array_equal(own[:, 1], alike[:, 1])  # the source is unchanged
    assert not np.array_equal(own[:, 0], own[:, 1])
    assert not np.array_equal(own[:, 0], own[:, 2])


def test_fork_refuses_ids_that_are_none():
    envs = make()
    envs.reset()
    with pytest.raises(ValueError):
        envs.fork(0, [NUM_ENVS])
    with pytest.raises(ValueError):
        envs.fork(0, [2**40])
    with pytest.raises(TypeError, match="integers"):
        envs.fork(0, [0.5])


def test_a_parameter_is_set_in_one_environment_alone():
    envs, untouched = make(), make()
    path = "robots.quad.links.base_link.mass"
    envs.reset()
    untouched.reset()
    mass = envs.param(3, path)
    envs.set_param(3, path, 1.2 * mass)
    assert envs.param(3, path) == 1.2 * mass
    assert envs.param(2, path) == mass
    changed = (future(envs, 5) != future(untouched, 5)).any(axis=(0, 2))
    np.testing.assert_array_equal(changed, np.arange(NUM_ENVS) == 3)
    with pytest.raises(ValueError, match="no_such"):
        envs.param(0, "no_such")
