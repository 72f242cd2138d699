"""The keywords of all constructors of environments: one list, one meaning, one default each."""

from __future__ import annotations

import importlib
import inspect
import sys
from pathlib import Path
from typing import Any, Never, get_type_hints

import gymnasium
import numpy as np
import pytest
import skybody
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode
from skybody.python_task import PythonTask, PythonTaskVectorEnv

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
script = importlib.import_module("python_options")

TAKERS: dict[str, Any] = script.TAKERS
BY_TAKER = pytest.mark.parametrize("taker", TAKERS.values(), ids=TAKERS.keys())


class Still(PythonTask):
    observation_space = Box(-1, 1, (1,), np.float32)
    action_space = Box(-1, 1, (4,), np.float32)


def arguments(taker: Any) -> tuple[Any, ...]:
    """Positional arguments of a constructor."""
    if taker is PythonTaskVectorEnv:
        return Still(), "hover", 2
    needs_count = "num_envs" in inspect.signature(taker).parameters
    return ("hover", 2) if needs_count else ("hover",)


@BY_TAKER
def test_every_keyword_is_an_option_with_its_meaning(taker: Any) -> None:
    keywords = [
        parameter.name
        for parameter in inspect.signature(taker).parameters.values()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY
    ]
    of_gymnasium = {"render_mode", "max_episode_steps"}
    documented = [name for name, _, meaning in script.options_of(taker) if meaning]
    assert [name for name in keywords if name not in of_gymnasium] == documented
    assert "`skybody.options`" in inspect.getdoc(taker)


def test_an_option_has_one_default_and_one_meaning_but_for_seeds_of_single_environments() -> None:
    found: dict[str, set[Any]] = {}
    for taker in TAKERS.values():
        for name, *option in script.options_of(taker):
            found.setdefault(name, set()).add(tuple(option))
    assert [name for name, options in found.items() if len(options) > 1] == ["seed"]


@BY_TAKER
def test_an_unknown_option_is_refused_and_the_nearest_is_named(taker: Any) -> None:
    expected = (
        rf"{taker.__name__}\(\) got an unexpected keyword argument 'sed'; did you mean `seed`\? "
        "Allowed: .*seed"
    )
    with pytest.raises(TypeError, match=expected):
        taker(*arguments(taker), sed=1)
    with pytest.raises(TypeError, match=r"keyword argument 'colour'\. Allowed: "):
        taker(*arguments(taker), colour="red")


@BY_TAKER
def test_a_flag_that_is_neither_true_nor_false_is_refused(taker: Any) -> None:
    flags = [name for name, default, _ in script.options_of(taker) if isinstance(default, bool)]
    for flag in flags:
        for value in ("x", "False", 1, None):
            with pytest.raises(TypeError, match=f"{flag} is {value!r}; it must be True or False"):
                taker(*arguments(taker), **{flag: value})


def test_a_flag_of_numpy_is_a_flag() -> None:
    assert skybody.make_vec("formation_2", 1, joint=np.True_).action_space.shape == (1, 2, 4)


def test_what_has_no_use_for_an_option_refuses_it() -> None:
    with pytest.raises(TypeError, match="keyword argument 'batch_size'"):
        skybody.make_vec("hover", 2, batch_size=1)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="keyword argument 'joint'"):
        skybody.make_pool("hover", 2, joint=True)  # type: ignore[call-arg]


def test_options_may_come_as_a_dictionary() -> None:
    chosen: dict[str, Any] = {"seed": 3, "num_threads": 1, "autoreset": "same_step"}
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


def test_the_manual_has_the_list_as_it_is() -> None:
    assert script.page() == script.PAGE.read_text(), "scripts/update_docs.sh writes it anew"


@BY_TAKER
def test_type_checkers_refuse_unknown_options_too(taker: Any) -> None:
    assert get_type_hints(vars(taker)["__init__"])["unknown"] is Never
