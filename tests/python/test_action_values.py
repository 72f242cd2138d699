"""Clipped actions are counted, requests of another size are refused, lists can be emptied."""

from __future__ import annotations

import numpy as np
import pytest
import skybody
from skybody.env import SkybodyEnv


def test_values_beyond_the_range_of_actions_are_counted() -> None:
    envs = skybody.make_vec("hover", 4, num_threads=1)
    envs.reset(seed=1)
    actions = np.zeros((4, 4), np.float32)
    assert "clipped" not in envs.step(actions)[4]
    actions[2] = [1500, -1.5, 1, -1]  # rad/s where -1 to 1 is required
    infos = envs.step(actions)[4]
    assert infos["clipped"].tolist() == [0, 0, 2, 0]
    assert infos["_clipped"].all()
    assert envs.clipped == 2
    assert "clipped" not in envs.step(np.zeros((4, 4), np.float32))[4]

    env = SkybodyEnv("hover")
    env.reset(seed=1)
    assert env.step(np.full(4, 1500, np.float32))[4]["clipped"] == 4

    with skybody.make_pool("hover", 4, batch_size=2, num_threads=1) as pool:
        pool.reset()
        pool.recv()
        pool.send(actions[1:3], [1, 2])
        *_, info = pool.recv()
        assert dict(zip(info["env_id"].tolist(), info["clipped"].tolist(), strict=True)) == {
            1: 0,
            2: 2,
        }


def test_one_number_for_a_vector_is_refused() -> None:
    envs = skybody.make_vec("hover", 2, num_threads=1)
    envs.reset(seed=1)
    with pytest.raises(ValueError, match=r"`gravity` has 3 values, and one number is given: give "):
        envs.request(None, {"gravity": -9.81})
    with pytest.raises(ValueError, match=r"or name one of them, such as `.*\.com\[0\]`"):
        envs.request(None, {"robots.quad.links.base_link.com": 0.0})
    envs.request(None, {"gravity[2]": -9.0, "robots.quad.links.base_link.mass": 1.5})
    envs.request(None, {"robots.quad.rotors[*].thrust_constant": 2e-6})


LISTS = {  # a word of each, and the list
    "infos": ("gravity", "[gravity]"),
    "sensors": ("imu", "[{plugin: imu, parameters: {link: base_link}}]"),
    "effects": ("wind", "[{plugin: wind}]"),
    "obstacles": ("ball", "[{name: ball, sphere: 0.1, position: [50, 0, 50]}]"),
    "couplings": ("tether", "[{name: tether, kind: rope, ends: [{robot: quad}, {}]}]"),
}


@pytest.mark.parametrize("empty", ["[]", "~", ""])
@pytest.mark.parametrize("key", LISTS)
def test_lists_can_be_emptied(key: str, empty: str) -> None:
    word, full = LISTS[key]
    overrides = [f"{key}={full}"]
    assert word in skybody.CompiledScenario("hover", overrides).scenario_text
    assert (
        word not in skybody.CompiledScenario("hover", [*overrides, f"{key}={empty}"]).scenario_text
    )
