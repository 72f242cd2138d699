"""The keywords of all constructors of environments: one list, one meaning, one default each."""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import skybody
from gymnasium.vector import AutoresetMode
from skybody import options
from skybody.env import SkybodyEnv
from skybody.multi_agent import ParallelEnv
from skybody.options import options_of
from skybody.python_task import PythonTaskVectorEnv
from skybody.sb3 import SkybodyVecEnv
from skybody.vector import SkybodyVectorEnv

ROOT = Path(__file__).resolve().parents[2]

TAKERS: dict[Any, type] = {
    skybody.make_vec: options.VectorOptions,
    SkybodyVectorEnv: options.VectorOptions,
    skybody.make_pool: options.PoolOptions,
    skybody.Pool: options.PoolOptions,
    SkybodyVecEnv: options.PooledOptions,
    SkybodyEnv: options.EnvOptions,
    ParallelEnv: options.EnvOptions,
    skybody.Simulation: options.SimulationOptions,
    skybody.SimulationPool: options.SimulationPoolOptions,
    PythonTaskVectorEnv: options.TaskOptions,
}
BY_TAKER = pytest.mark.parametrize(("taker", "kind"), TAKERS.items(), ids=lambda x: x.__name__)


@BY_TAKER
def test_help_has_every_option_with_its_default_and_its_meaning(taker: Any, kind: type) -> None:
    parameters = inspect.signature(taker).parameters
    text = " ".join(inspect.getdoc(taker).split())
    for name, (_, option) in options_of(kind).items():
        assert parameters[name].default == option.default
        assert parameters[name].kind is inspect.Parameter.KEYWORD_ONLY
        assert f"{name}: {' '.join(option.doc.split())}" in text
    assert "options" not in parameters


@BY_TAKER
def test_an_unknown_option_is_refused_and_the_nearest_is_named(taker: Any, kind: type) -> None:
    expected = (
        rf"{taker.__name__}\(\) got an unexpected keyword argument 'sed'; did you mean `seed`\? "
        "Allowed: .*seed"
    )
    with pytest.raises(TypeError, match=expected):
        taker("hover", 2, sed=1)
    with pytest.raises(TypeError, match=r"keyword argument 'colour'\. Allowed: "):
        taker("hover", 2, colour="red")


@BY_TAKER
def test_a_flag_that_is_neither_true_nor_false_is_refused(taker: Any, kind: type) -> None:
    for flag in (name for name, (type_, _) in options_of(kind).items() if type_ is bool):
        for value in ("x", "False", 1, None):
            with pytest.raises(TypeError, match=f"{flag} is {value!r}; it must be True or False"):
                taker("hover", 2, **{flag: value})
    if kind is options.VectorOptions:
        assert taker("formation_2", 1, joint=np.True_).action_space.shape == (1, 2, 4)


def test_what_has_no_use_for_an_option_refuses_it() -> None:
    with pytest.raises(TypeError, match="keyword argument 'batch_size'"):
        skybody.make_vec("hover", 2, batch_size=1)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="keyword argument 'joint'"):
        skybody.make_pool("hover", 2, joint=True)  # type: ignore[call-arg]


def test_options_may_come_as_a_dictionary() -> None:
    chosen: skybody.VectorOptions = {"seed": 3, "num_threads": 1, "autoreset": "same_step"}
    envs = skybody.make_vec("hover", 2, **chosen)
    again = skybody.make_vec("hover", 2, seed=3, num_threads=1)
    np.testing.assert_array_equal(envs.reset()[0], again.reset()[0])
    assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert chosen == {"seed": 3, "num_threads": 1, "autoreset": "same_step"}


@pytest.mark.parametrize("autoreset", ["same_step", "SameStep", AutoresetMode.SAME_STEP])
def test_pools_take_gymnasiums_autoreset_modes_too(autoreset: Any) -> None:
    with skybody.make_pool("hover", 2, autoreset=autoreset, num_threads=1) as pool:
        assert "final_obs" in pool.reset()[1]


def test_a_word_that_is_none_is_refused_alike_everywhere() -> None:
    for make in (skybody.make_vec, skybody.make_pool):
        with pytest.raises(ValueError, match="autoreset is 'never'; it must be one of next_step"):
            make("hover", 2, autoreset="never")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="order is 'any'; it must be one of fixed, arrival"):
        skybody.make_pool("hover", 2, order="any")  # type: ignore[arg-type]


def test_gymnasium_passes_options_on_and_tells_of_unknown_ones() -> None:
    envs = gymnasium.make_vec("skybody/Hover-v0", num_envs=2, seed=1, num_threads=1)
    assert envs.num_envs == 2
    env = gymnasium.make("skybody/Hover-v0", seed=1, overrides=["stepping.horizon=1"])
    env.reset()
    assert env.step(np.zeros(4, np.float32))[3]
    with pytest.raises(TypeError, match="did you mean `num_threads`"):
        gymnasium.make_vec("skybody/Hover-v0", num_envs=2, num_thread=1)


def test_the_manual_has_the_list_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "scripts"))
    script = importlib.import_module("python_options")
    assert set(script.TAKERS) == set(TAKERS.values())
    assert script.page() == script.PAGE.read_text(), "scripts/update_docs.sh writes it anew"
