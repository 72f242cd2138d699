"""`skybody export --to onnx`: the engine's actions to 1e-6 in ONNX Runtime."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import onnx
import pytest
from numpy.typing import NDArray
from skybody._native import PolicyNetwork, shipped_policies
from skybody.exports.__main__ import main
from skybody.exports.policy.onnx_evaluator import OnnxEvaluator, session_of
from skybody.exports.policy.onnx_file import write_model
from skybody.exports.policy.source import PolicySource
from test_export_policy import opened

from research.deploy.network_drafts import NETWORKS, write_draft

ROWS = 1000
IMAGE_ROWS = 20
# Both compute in float: sums of up to 700 products in another order, of values up to 10.
LARGEST = 1e-6


def inputs_and_images(
    source: PolicySource, rows: int
) -> tuple[NDArray[np.float32], dict[str, NDArray[np.generic]]]:
    """Inputs of the network (rows, I), normal after normalization, and images by name."""
    random, policy = np.random.default_rng(3), source.policy
    normal = random.normal(size=(rows, len(policy.mean)))
    inputs = (normal / policy.scale + policy.mean).astype(np.float32)
    images = {
        image.name: random.uniform(image.low, image.high, (rows, *image.shape)).astype(image.dtype)
        for image in source.interface.images
    }
    return inputs, images


def engine_actions(
    source: PolicySource, inputs: NDArray[np.float32], images: dict[str, NDArray[np.generic]]
) -> NDArray[np.float32]:
    """Actions (rows, A) of the engine, of the first robot; rows are steps of an episode."""
    network = PolicyNetwork(str(source.file), [image.dtype for image in source.interface.images])
    agents = source.policy.agents
    observation = np.zeros((len(inputs), source.policy.sizes()["observation_size"]), np.float32)
    observation[:, agents[0].observation if agents else slice(None)] = inputs
    bytes_of = [np.ascontiguousarray(p.reshape(len(p), -1)).view(np.uint8) for p in images.values()]
    return network.act(observation, bytes_of)[:, agents[0].action if agents else slice(None)]


@pytest.mark.parametrize("scenario", shipped_policies())
def test_onnx_of_a_shipped_policy_gives_the_engines_actions(scenario: str, tmp_path: Path) -> None:
    source = opened("shipped", scenario)
    write_model(source, tmp_path / "policy.onnx")
    rows = IMAGE_ROWS if source.interface.images else ROWS
    inputs, images = inputs_and_images(source, rows)
    feed = {
        (s.name if s.actions is None else f"past_{s.name}"): inputs[:, s.first : s.first + s.count]
        for s in source.interface.signals
    }
    if source.interface.ranges_differ:
        feed["robot"] = np.zeros(rows, np.int64)
    (actions,) = session_of(tmp_path / "policy.onnx").run(["action"], feed | images)
    assert np.abs(actions - engine_actions(source, inputs, images)).max() <= LARGEST


@pytest.mark.parametrize("is_normalized", [True, False])
@pytest.mark.parametrize("network", NETWORKS)
def test_onnx_of_each_kind_of_layer_flies_in_lockstep(
    network: str, is_normalized: bool, tmp_path: Path
) -> None:
    file = tmp_path / "policy.h5"
    source = opened(write_draft(file, "hover_camera", network, is_normalized=is_normalized))
    write_model(source, tmp_path / "policy.onnx")
    evaluator = OnnxEvaluator(source, tmp_path / "policy.onnx")
    inputs, images = inputs_and_images(source, IMAGE_ROWS)
    past = {s.name: s for s in source.interface.past_actions}
    network_ = PolicyNetwork(str(file), [image.dtype for image in source.interface.images])
    before = {name: np.full(s.count, -1.0, np.float32) for name, s in past.items()}
    for step in range(IMAGE_ROWS):
        for name, signal in past.items():
            inputs[step, signal.first : signal.first + signal.count] = before[name]
        seen = {name: pixels[step] for name, pixels in images.items()}
        values = {
            s.name: inputs[step, s.first : s.first + s.count] for s in source.interface.inputs
        }
        given = evaluator.act(values | seen)
        expected = network_.act(
            inputs[step : step + 1],
            [np.ascontiguousarray(p).reshape(1, -1).view(np.uint8) for p in seen.values()],
        )[0]
        assert np.abs(given - expected).max() <= LARGEST
        before = {name: np.concatenate([expected, old[:-4]]) for name, old in before.items()}


def test_the_model_has_opset_17_a_free_batch_names_units_and_frames(tmp_path: Path) -> None:
    source = opened(write_draft(tmp_path / "policy.h5", "hover_learn", "with_memory"))
    write_model(source, tmp_path / "policy.onnx")
    model = onnx.load(tmp_path / "policy.onnx")
    assert [opset.version for opset in model.opset_import] == [17]
    names = ["position_error", "yaw_error", "velocity", "attitude", "angular_velocity"]
    assert [value.name for value in model.graph.input] == [*names, "past_actions", "memory"]
    outputs = [value.name for value in model.graph.output]
    assert outputs == ["command", "action", "past_actions_next", "memory_next"]
    velocity = model.graph.input[2]
    assert velocity.type.tensor_type.shape.dim[0].dim_param == "batch"
    assert velocity.doc_string == "[m/s] velocity of the base's frame, W"
    properties = {entry.key: entry.value for entry in model.metadata_props}
    assert properties["scenario"] == "hover_learn"
    assert float(properties["period"]) == 0.02
    assert json.loads(properties["outputs"])[0]["unit"] == "rad/s"
    assert "W world, z up" in properties["frames"]


def test_check_flies_the_model_and_writes_a_page_beside_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "racing.onnx"
    arguments = ["shipped", "--scenario", "racing", "--to", "onnx", "--check", "1", "-o", str(file)]
    assert main(arguments) == 0
    assert "1 episodes" in (out := capsys.readouterr().out)
    assert "every action equal within" in out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["racing.md", "racing.onnx"]


def test_a_model_that_differs_is_not_written_and_not_called_equal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from skybody.exports.policy import onnx_file

    monkeypatch.setattr(onnx_file, "LARGEST", 0.0)
    file = tmp_path / "racing.onnx"
    arguments = ["shipped", "--scenario", "racing", "--to", "onnx", "--check", "1", "-o", str(file)]
    assert main(arguments) == 1
    captured = capsys.readouterr()
    assert "not equal, nothing written" in captured.err
    assert "every action" not in captured.out
    assert not list(tmp_path.iterdir())


def test_commands_are_in_physical_units_by_the_robot(tmp_path: Path) -> None:
    source = opened("shipped", "chase_agents")
    write_model(source, tmp_path / "policy.onnx")
    inputs, _ = inputs_and_images(source, 1)
    values = {s.name: inputs[0, s.first : s.first + s.count] for s in source.interface.inputs}
    for robot in (0, 3):
        evaluator = OnnxEvaluator(source, tmp_path / "policy.onnx", robot)
        action = evaluator.act(values)
        low = np.array([output.low[robot] for output in source.interface.outputs])
        high = np.array([output.high[robot] for output in source.interface.outputs])
        expected = low + (action + 1.0) / 2.0 * (high - low)
        assert evaluator.command[0] == pytest.approx(expected, abs=1e-6)


def test_a_missing_package_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "onnxruntime", None)
    arguments = ["shipped", "--scenario", "racing", "--to", "onnx", "--check", "1"]
    assert main([*arguments, "-o", str(tmp_path / "racing.onnx")]) == 2
    assert "`pip install onnxruntime`" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
