"""Calls of the vector environment with wrong actions or arguments, or at a wrong time: clear
errors.
"""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skybody
from reference import SEED, actions, short_hover
from skybody import make_vec
from skybody.vector import SkybodyVectorEnv

NUM_ENVS = 10


def make(autoreset: str = "next_step", **options: Any) -> SkybodyVectorEnv:
    return make_vec(short_hover(), NUM_ENVS, seed=SEED, autoreset=autoreset, **options)


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        (np.zeros((NUM_ENVS, 4)), TypeError, "float32"),
        (np.zeros((NUM_ENVS, 3), np.float32), ValueError, "shape"),
        (np.zeros((NUM_ENVS + 1, 4), np.float32), ValueError, "shape"),
        (np.zeros(4, np.float32), ValueError, "shape"),
    ],
)
def test_actions_of_another_kind_are_refused(given: Any, error: type[Exception], message: str):
    envs = make()
    envs.reset()
    with pytest.raises(error, match=message):
        envs.step(given)
    envs.step(actions(0, NUM_ENVS))  # and nothing was sent


@pytest.mark.parametrize(
    ("keywords", "error", "message"),
    [
        ({"seed": [1, 2, 3]}, TypeError, "one integer"),
        ({"seed": 1.5}, TypeError, "one integer"),
        ({"seed": -1}, ValueError, "from 0 to"),
        ({"options": {"mask": 1}}, ValueError, "unknown reset option `mask`"),
        ({"options": {"reset_mask": [True]}}, TypeError, "NumPy array of bool"),
        ({"options": {"reset_mask": np.ones(3, bool)}}, ValueError, "shape"),
        ({"options": {"reset_mask": np.zeros(NUM_ENVS, bool)}}, ValueError, "no True"),
        ({"seed": 1, "options": {"reset_mask": np.ones(NUM_ENVS, bool)}}, ValueError, "leave out"),
    ],
)
def test_bad_reset_arguments_are_refused(
    keywords: dict[str, Any], error: type[Exception], message: str
):
    envs = make()
    with pytest.raises(error, match=message):
        envs.reset(**keywords)
    envs.reset()


def test_a_step_without_reset_is_refused():
    with pytest.raises(ValueError, match="reset"):
        make().step(actions(0, NUM_ENVS))


def test_a_reset_after_an_interrupted_step_begins_anew():
    envs, untouched = make(), make()
    for each in (envs, untouched):
        each.reset()
    envs.native.send(actions(0, NUM_ENVS), None)  # the state that Ctrl-C in step() leaves behind
    with pytest.raises(skybody.Error, match=r"interrupted and .* in flight: reset\(\)"):
        envs.step(actions(0, NUM_ENVS))
    mask = np.arange(NUM_ENVS) < 2
    with pytest.raises(skybody.Error, match="interrupted"):  # the others' rows would be lost
        envs.reset(options={"reset_mask": mask})
    np.testing.assert_array_equal(envs.reset()[0], untouched.reset()[0])


def test_pickling_is_refused_with_a_remedy():
    with pytest.raises(TypeError, match=r"cannot be pickled.*save\(\)"):
        pickle.dumps(make())


def test_a_closed_environment_refuses_to_step():
    envs = make()
    envs.reset()
    envs.close()
    envs.close()
    with pytest.raises(skybody.Error, match="closed"):
        envs.step(actions(0, NUM_ENVS))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"num_envs": 0}, "num_envs is 0; it must be from 1 to 16777216"),
        ({"num_envs": 10**9}, "num_envs is 1000000000; it must be from 1 to 16777216"),
        ({"num_envs": 2**31}, "num_envs is 2147483648; it must be from 1 to 16777216"),
        ({"num_envs": 1, "num_threads": 2**31}, "num_threads is 2147483648; it must be from 0 to"),
        ({"num_envs": 1, "plugin_path": ["/nonexist"]}, "directory does not exist: /nonexist"),
        ({"num_envs": 2, "autoreset": "sometimes"}, "autoreset is 'sometimes'"),
    ],
)
def test_options_out_of_range_are_refused(options: dict[str, Any], message: str):
    with pytest.raises(ValueError, match=message):
        make_vec("hover", **options)


def test_a_pools_batch_size_out_of_range_is_refused():
    with pytest.raises(ValueError, match="batch_size is 2147483648; it must be from 0 to"):
        skybody.make_pool("hover", 2, batch_size=2**31)
    with pytest.raises(ValueError, match="batch_size is 9; it must be from 0 to 3"):
        skybody.make_pool("hover", 3, batch_size=9)


@pytest.mark.parametrize("make", [make_vec, skybody.make_pool, skybody.SimulationPool])
@pytest.mark.parametrize("scenario", [None, 3, b"hover"])
def test_what_is_no_scenario_is_refused_by_name(make: Any, scenario: Any):
    with pytest.raises(TypeError, match=f"scenario is {scenario!r}; it must be a text or a path"):
        make(scenario, 3)


def test_a_state_path_that_is_no_text_is_refused_by_name():
    envs = make()
    envs.reset()
    with pytest.raises(TypeError, match="path is 3; it must be a text"):
        envs.state(3)  # type: ignore[arg-type]
    envs.close()


def test_a_recording_does_not_begin_while_environments_are_in_flight(tmp_path: Path):
    with skybody.make_pool("hover", 4) as pool:
        pool.async_reset()
        with pytest.raises(skybody.Error, match=r"^record\(\) while 4 environments are in flight"):
            pool.record(tmp_path / "run.h5")
        pool.recv()
    assert not (tmp_path / "run.h5").exists()


def test_a_mistake_in_the_scenario_is_an_input_error():
    with pytest.raises(skybody.InputError):
        make_vec("no_such_scenario", 1)
    with pytest.raises(skybody.InputError, match="stepping"):
        make_vec("hover", 1, overrides=["stepping.dt=-1"])
    with pytest.raises(ValueError, match="loaded already"):
        make_vec(short_hover(), 1, overrides=["stepping.dt=0.002"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"num_envs": "4"}, "num_envs is '4'; it must be an integer"),
        ({"num_envs": 4, "num_threads": 1.5}, "num_threads is 1.5; it must be an integer"),
        ({"num_envs": 4, "overrides": "stepping.dt=0.002"}, "`overrides` is one text; give a list"),
    ],
)
def test_options_of_another_kind_are_refused(options: dict[str, Any], message: str):
    with pytest.raises(TypeError, match=message):
        make_vec("hover", **options)
