"""policy.h5: a seal over all its bytes, which docs/policies.md describes for other writers."""

from __future__ import annotations

import dataclasses
import struct
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hash_chain import hash_of
from skybody._native import Error, policy_seal
from skybody.train.policy_file import Agent, Layer, Policy, read_policy, write_policy

LAYER = Layer(np.ones((1, 2), np.float32), np.zeros(1, np.float32), "none")
STAMPS = {"scenario": "hover", "scenario_hash": "0" * 16, "algorithm": "ppo", "steps": 5}
POLICY = Policy([LAYER], np.zeros(2), np.ones(2), 10.0, STAMPS)


def written(folder: Path) -> Path:
    path = folder / "policy.h5"
    write_policy(path, POLICY)
    return path


def seal(path: Path) -> None:
    """Writes a valid seal into a changed file."""
    content = path.read_bytes()[512:]
    path.write_bytes(policy_seal(content) + content)


@pytest.mark.parametrize("size", [0, 1, 8, 1000])
def test_the_seal_is_what_the_documentation_says(size: int) -> None:
    content = bytes(k % 251 for k in range(size))
    lines = f"skybody-policy 2\nbytes {size}\nhash {hash_of(content):016x}\n"
    assert policy_seal(content) == lines.encode().ljust(512, b"\0")


def test_a_layer_whose_arrays_do_not_fit_together_is_not_written(tmp_path: Path) -> None:
    short = Layer(LAYER.weight, np.zeros(0, np.float32), "none")
    with pytest.raises(Error, match="`bias` of a policy's layer has 0 values; its sizes ask for 1"):
        write_policy(tmp_path / "policy.h5", dataclasses.replace(POLICY, layers=[short]))
    other = Layer(LAYER.weight, LAYER.bias, "sine")
    with pytest.raises(Error, match="activation is `sine`: take tanh, relu, elu or none"):
        write_policy(tmp_path / "policy.h5", dataclasses.replace(POLICY, layers=[other]))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"scale": np.array([1.0, 0.0])}, "value 1 of `/normalization/scale` is 0; allowed: > 0"),
        ({"scale": np.array([-2.0, 1.0])}, "value 0 of `/normalization/scale` is -2; allowed: > 0"),
        ({"clip": -1.0}, "`clip` of `/normalization` is -1; allowed: > 0"),
        ({"attributes": {**STAMPS, "scenario_hash": "none"}}, "`scenario_hash` is `none`"),
        ({"attributes": {**STAMPS, "steps": -1}}, "`steps` is -1; allowed: >= 0"),
    ],
)
def test_values_that_no_learner_makes_are_not_written(
    change: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with pytest.raises(Error, match=message):
        write_policy(tmp_path / "policy.h5", dataclasses.replace(POLICY, **change))
    assert not list(tmp_path.iterdir())


def test_other_programs_read_a_policy_as_hdf5(tmp_path: Path) -> None:
    with h5py.File(written(tmp_path), "r") as file:
        assert file.userblock_size == 512
        assert bytes(file.attrs["scenario"]) == b"hover"
        assert (file.attrs["version"], file.attrs["observation_size"]) == (2, 2)
        np.testing.assert_array_equal(file["layers/0/weight"], [[1.0, 1.0]])


def test_a_policy_that_was_changed_after_it_was_written_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path)
    with h5py.File(path, "r+") as file:
        del file["normalization"]
    with pytest.raises(ValueError, match=r"policy\.h5: damaged, cut short or changed"):
        read_policy(path)


def test_a_sealed_file_that_points_elsewhere_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path)
    with h5py.File(path, "r+") as file:
        del file["normalization"]
        file["normalization"] = h5py.ExternalLink("other.h5", "/")
    seal(path)
    with pytest.raises(ValueError, match=r"policy\.h5: `/normalization` is a link"):
        read_policy(path)


def test_a_sealed_file_that_claims_more_weights_than_it_has_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path)
    with h5py.File(path, "r+") as file:
        del file["layers/0/weight"]
        file["layers/0"].create_dataset("weight", (2**40, 2), "f4", chunks=(1, 2))
    seal(path)
    with pytest.raises(ValueError, match=r"policy\.h5: `/layers/0/weight` claims more values"):
        read_policy(path)


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("layers/0/bias", [np.nan], "is not finite"),
        ("normalization/mean", [0.0, np.inf], "is not finite"),
        ("layers/0/bias", [0.0, 1.0], "needed: 1"),
        ("layers/0/weight", [[1.0, 1.0, 1.0]], "needed: outputs x 2"),
    ],
)
def test_a_sealed_file_with_bad_numbers_or_sizes_is_refused(
    name: str, values: list[float], message: str, tmp_path: Path
) -> None:
    path = written(tmp_path)
    with h5py.File(path, "r+") as file:
        del file[name]
        file[name] = np.array(values, np.float32)
    seal(path)
    with pytest.raises(ValueError, match=message):
        read_policy(path)


def test_a_policy_replaces_another_as_a_whole(tmp_path: Path) -> None:
    first = written(tmp_path).read_bytes()
    assert written(tmp_path).read_bytes() == first
    assert [path.name for path in tmp_path.iterdir()] == ["policy.h5"]
    assert struct.unpack("<8B", first[512:520]) == tuple(b"\x89HDF\r\n\x1a\n")


def test_a_shared_policy_is_evaluated_for_each_robot(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    layers = [
        Layer(rng.normal(0, 0.5, (6, 3)), rng.normal(0, 0.1, 6), "tanh"),
        Layer(rng.normal(0, 0.5, (2, 6)), rng.normal(0, 0.1, 2), "none"),
    ]
    layers = [
        Layer(x.weight.astype(np.float32), x.bias.astype(np.float32), x.activation) for x in layers
    ]
    agents = [
        Agent(np.array([1, 2, 0]), np.array([0, 1])),
        Agent(np.array([3, 4, 0]), np.array([2, 3])),
    ]
    attributes = {**STAMPS, "observation_size": 5}
    policy = Policy(layers, np.zeros(3), np.ones(3), 10.0, attributes, agents, "tanh")
    write_policy(tmp_path / "policy.h5", policy)
    read = read_policy(tmp_path / "policy.h5")
    observation = rng.normal(0, 1, (4, 5)).astype(np.float32)
    actions = read(observation)
    for k, agent in enumerate(agents):
        x = observation[:, agent.observation].astype(np.float64)
        hidden = np.tanh(x @ layers[0].weight.T + layers[0].bias)
        wanted = np.tanh(hidden @ layers[1].weight.T + layers[1].bias)
        np.testing.assert_allclose(actions[:, 2 * k : 2 * k + 2], wanted, rtol=1e-12)


@pytest.mark.parametrize(
    ("observation", "action", "words"),
    [
        (
            [[1, 2, 0], [3, 5, 0]],
            [[0, 1], [2, 3]],
            r"value 4 of `/agents/observation` is 5; allowed: 0..4",
        ),
        ([[1, 2, 0], [3, 4, 0]], [[0, 1], [1, 3]], "value 1 of the action is decided by 2 robots"),
        ([[1, 2, 0]], [[0, 1], [2, 3]], "observations of 1 robots and actions of 2"),
    ],
)
def test_agents_that_do_not_fit_are_refused(
    tmp_path: Path, observation: list[list[int]], action: list[list[int]], words: str
) -> None:
    layers = [Layer(np.zeros((2, 3), np.float32), np.zeros(2, np.float32), "none")]
    agents = [Agent(np.array(o), np.array(a)) for o, a in zip(observation, action, strict=False)]
    attributes = {**STAMPS, "observation_size": 5}
    file = tmp_path / "policy.h5"
    write_policy(file, Policy(layers, np.zeros(3), np.ones(3), 10.0, attributes, agents))
    with h5py.File(file, "r+") as content:
        del content["agents"]
        content["agents/observation"] = np.array(observation, np.int32)
        content["agents/action"] = np.array(action, np.int32)
        content.attrs["action_size"] = 4
    seal(file)
    with pytest.raises(ValueError, match=words):
        read_policy(file)
