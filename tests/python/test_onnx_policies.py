"""ONNX policies of other programs fly: converted to policy.h5, they act as the original does."""

from __future__ import annotations

import subprocess
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import onnx
import pytest
import torch
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper
from skybody import CompiledScenario, InputError
from skybody.exports.__main__ import main
from skybody.exports.onnx_in.map_file import Map, read_map
from skybody.exports.onnx_in.reader import read_onnx
from skybody.exports.policy.onnx_evaluator import session_of
from skybody.exports.policy.onnx_file import write_model
from skybody.train.policy_file import Policy
from test_export_onnx import inputs_and_images
from test_export_policy import opened

from research.deploy.network_drafts import NETWORKS, write_draft

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
COLUMNS = ["position_error", "yaw_error", "velocity", "attitude", "angular_velocity", "actions"]
SIZE = 22  # values of the observation of hover_learn
# Both in float, and weights that the conversion has multiplied together.
LARGEST = 2e-6

torch.manual_seed(4)


class Vision(torch.nn.Module):
    """An image through convolutions and a layer, beside observations, then a recurrent layer."""

    def __init__(self, cell: type[torch.nn.Module]) -> None:
        super().__init__()
        convolutions = [torch.nn.Conv2d(1, 8, 8, 4), torch.nn.ReLU(), torch.nn.Conv2d(8, 16, 4, 2)]
        self.image = torch.nn.Sequential(*convolutions, torch.nn.ReLU(), torch.nn.Flatten())
        self.features = torch.nn.Linear(16 * 6 * 6, 32)
        self.memory = cell(32 + SIZE, 16, batch_first=True)
        self.out = torch.nn.Linear(16, 4)

    def forward(self, obs: Any, image: Any, *state: Any) -> Any:
        features = torch.relu(self.features(self.image(image / 20.0)))
        row = torch.cat([torch.clamp((obs - 1.0) / 2.0, -5, 5), features], 1)
        before = state if len(state) > 1 else state[0]
        found, after = self.memory(row.unsqueeze(1), before)
        return torch.tanh(self.out(found[:, -1])), after


class ActorCritic(torch.nn.Module):
    """Actions and values of two networks, as of Stable-Baselines3; a sigmoid among the layers."""

    def __init__(self) -> None:
        super().__init__()
        layers = [torch.nn.Linear(SIZE, 32), torch.nn.Sigmoid(), torch.nn.Linear(32, 24)]
        self.actor = torch.nn.Sequential(*layers, torch.nn.ELU(), torch.nn.Linear(24, 4))
        self.critic = torch.nn.Sequential(torch.nn.Linear(SIZE, 8), torch.nn.Softplus())

    def forward(self, obs: Any) -> Any:
        return torch.clamp(2.0 * self.actor(obs) - 0.25, -1.0, 1.0), self.critic(obs)


class Normed(torch.nn.Module):
    """Batch normalization before and between layers; actions without a bound."""

    def __init__(self) -> None:
        super().__init__()
        self.inputs = torch.nn.BatchNorm1d(SIZE)
        self.hidden = torch.nn.BatchNorm1d(16)
        self.first, self.last = torch.nn.Linear(SIZE, 16), torch.nn.Linear(16, 4)
        for norm in (self.inputs, self.hidden):
            torch.nn.init.uniform_(norm.weight, 0.5, 1.5)
            norm.running_mean = torch.randn(norm.num_features)
            norm.running_var = torch.rand(norm.num_features) + 0.5

    def forward(self, obs: Any) -> Any:
        return self.last(torch.tanh(self.hidden(self.first(self.inputs(obs)))))


def exported(module: torch.nn.Module, path: Path, names: list[str], *inputs: Any) -> Path:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        torch.onnx.export(
            module.eval(), inputs, path, input_names=names, opset_version=17, dynamo=False
        )
    return path


def differences(path: Path, policy: Policy, feeds: Callable[[Any, Any], dict[str, Any]]) -> float:
    """The largest difference of actions over steps of an episode; states come after the actions."""
    session = session_of(path)
    random, states, largest = np.random.default_rng(6), policy.states(1), 0.0
    memory = {
        value.name: np.zeros([d or 1 for d in value.shape], np.float32)
        for value in session.get_inputs()
        if value.name.startswith("state")
    }
    for _ in range(10):
        row = random.normal(size=(1, SIZE)).astype(np.float32)
        pixels = [
            random.uniform(i.low, i.high, (1, *i.shape)).astype(np.float32) for i in policy.images
        ]
        given, *after = session.run(None, feeds(row, pixels) | memory)
        memory = dict(zip(memory, after, strict=False))
        expected = policy(row, states, pixels)
        largest = max(largest, np.abs(np.clip(given, -1, 1) - expected).max())
    return largest


@pytest.mark.parametrize("network", NETWORKS)
def test_an_exported_policy_comes_back_the_same(network: str, tmp_path: Path) -> None:
    source = opened(write_draft(tmp_path / "policy.h5", "hover_camera", network))
    write_model(source, tmp_path / "policy.onnx")
    back = read_onnx(tmp_path / "policy.onnx", source.compiled, Map())
    inputs, images = inputs_and_images(source, 5)
    pixels = list(images.values())
    actions = (policy(inputs, None, pixels) for policy in (back, source.policy))
    assert np.abs(np.subtract(*actions)).max() < LARGEST


@pytest.mark.parametrize(("cell", "states"), [(torch.nn.GRU, 1), (torch.nn.LSTM, 2)])
def test_a_recurrent_network_of_pytorch_that_sees_images_acts_as_there(
    cell: type[torch.nn.Module], states: int, tmp_path: Path
) -> None:
    names = ["obs", "image", "state_h", "state_c"][: 2 + states]
    zeros = [torch.zeros(1, 1, 16)] * states
    image = torch.zeros(1, 1, 64, 64)
    path = exported(Vision(cell), tmp_path / "a.onnx", names, torch.zeros(1, SIZE), image, *zeros)
    chosen = Map("map.yaml", {"obs": COLUMNS, "image": ["front.depth"]}, "")
    policy = read_onnx(path, CompiledScenario("hover_camera"), _with_output(path, chosen))
    assert [layer.units for layer in policy.layers] == [16, 0]
    assert [layer.activation for layer in policy.images[0].layers] == ["relu", "relu", "relu"]

    def feeds(row: Any, pixels: Any) -> dict[str, Any]:
        return {"obs": row, "image": pixels[0].transpose(0, 3, 1, 2)}

    assert differences(path, policy, feeds) < LARGEST


def _with_output(path: Path, chosen: Map) -> Map:
    """The map with the name of the first output."""
    return Map(chosen.file, chosen.inputs, onnx.load(path).graph.output[0].name)


@pytest.mark.parametrize("module", [ActorCritic, Normed])
def test_a_network_of_pytorch_acts_as_there(module: type[torch.nn.Module], tmp_path: Path) -> None:
    path = exported(module(), tmp_path / "a.onnx", ["obs"], torch.zeros(1, SIZE))
    policy = read_onnx(path, CompiledScenario("hover_learn"), Map())
    assert differences(path, policy, lambda row, _: {"obs": row}) < LARGEST


def test_a_map_gives_other_names_and_another_order_of_the_quaternion(tmp_path: Path) -> None:
    model = torch.nn.Sequential(torch.nn.Linear(7, 4), torch.nn.Tanh())
    path = exported(model, tmp_path / "a.onnx", ["x"], torch.zeros(1, 7))
    (tmp_path / "map.yaml").write_text('inputs: {x: [velocity, "attitude[1,2,3,0]"]}\n')
    compiled = CompiledScenario("hover_learn")
    policy = read_onnx(path, compiled, read_map(tmp_path / "map.yaml"))
    row = np.random.default_rng(1).normal(size=(1, SIZE)).astype(np.float32)
    x = row[:, [4, 5, 6, 8, 9, 10, 7]]
    assert np.abs(session_of(path).run(None, {"x": x})[0] - policy(row)).max() < LARGEST


def test_the_program_flies_a_policy_in_onnx(tmp_path: Path) -> None:
    source = opened("shipped", "racing")
    write_model(source, tmp_path / "racing.onnx")
    actions = []
    for policy in (tmp_path / "racing.onnx", "shipped"):
        words = ["run", "racing", "--policy", str(policy), "--steps", "50", "--no-picture"]
        folder = tmp_path / str(len(actions))
        subprocess.run([PROGRAM, *words, "--out", folder], check=True, capture_output=True)
        with h5py.File(folder / "flight.h5") as log:
            actions.append(log["episodes/0001/action"][:])
    assert np.abs(actions[0] - actions[1]).max() < 1e-5  # differences grow during the flight
    assert np.abs(actions[0]).max() > 0.1


def test_a_policy_in_onnx_becomes_c(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = exported(ActorCritic(), tmp_path / "a.onnx", ["obs"], torch.zeros(1, SIZE))
    words = [str(path), "--scenario", "hover_learn", "--to", "c", "--check", "1"]
    assert main([*words, "-o", str(tmp_path / "c")]) == 0
    assert "every action equal in all bits" in capsys.readouterr().out


# --- refusals ---------------------------------------------------------------------------------


def model_of(*nodes: onnx.NodeProto, inputs: int = SIZE, **constants: NDArray[Any]) -> Any:
    """A model from x (1, inputs) to y (1, 4)."""
    x = helper.make_tensor_value_info("x", TensorProto.FLOAT, [1, inputs])
    y = helper.make_tensor_value_info("y", TensorProto.FLOAT, [1, 4])
    arrays = [numpy_helper.from_array(np.float32(v), name) for name, v in constants.items()]
    graph = helper.make_graph(list(nodes), "g", [x], [y], arrays)
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)


W = np.ones((SIZE, 4))
NODE = helper.make_node
GEMM = NODE("MatMul", ["x", "w"], ["h"])
REFUSED = {
    "an operator": (model_of(GEMM, NODE("Softplus", ["h"], ["y"]), w=W), "Softplus is not supp"),
    "an input of another size": (
        model_of(NODE("MatMul", ["x", "w"], ["y"]), inputs=3, w=np.ones((3, 4))),
        "input `x` is no observation: name its columns in --map FILE",
    ),
    "other actions": (
        model_of(NODE("MatMul", ["x", "w"], ["y"]), w=np.ones((SIZE, 3))),
        "the policy gives 3 actions; `hover_learn` takes 4",
    ),
    "a skipped layer": (
        model_of(GEMM, NODE("Add", ["h", "h"], ["y"]), w=W),
        "Add of two values that are no constants",
    ),
    "layers side by side": (
        model_of(
            GEMM,
            NODE("MatMul", ["x", "v"], ["i"]),
            NODE("Concat", ["h", "i"], ["y"], axis=1),
            w=W[:, :2],
            v=W[:, :2],
        ),
        "layers side by side",
    ),
    "a slice of outputs": (
        model_of(
            NODE("MatMul", ["x", "w"], ["h"]),
            NODE("Gather", ["h", "i"], ["y"], axis=1),
            w=np.ones((SIZE, 6)),
            i=np.arange(4),
        ),
        "Gather of the batch, or of a layer's outputs",
    ),
    "a constant": (model_of(NODE("Add", ["a", "b"], ["y"]), a=W[0], b=W[0]), "`y` is a constant"),
    "a clip inside": (
        model_of(
            GEMM,
            NODE("Clip", ["h", "low", "high"], ["i"]),
            NODE("MatMul", ["i", "v"], ["y"]),
            w=W,
            v=np.eye(4),
            low=-1.0,
            high=1.0,
        ),
        "a clip to \\[-1, 1\\] that is not the last step",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_network_that_cannot_be_flown_is_refused(name: str, tmp_path: Path) -> None:
    model, message = REFUSED[name]
    onnx.save(model, tmp_path / "a.onnx")
    with pytest.raises(InputError, match=message):
        read_onnx(tmp_path / "a.onnx", CompiledScenario("hover_learn"), Map())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("inputs: {y: velocity}", "the policy has no input `y`; it has x"),
        ("inputs: {x: speed}", "`hover_learn` observes no `speed`; there are position_error"),
        ('inputs: {x: "velocity[3]"}', r"`velocity\[3\]`: `velocity` has 3 values"),
        ("output: z", "the policy has no output `z`; it has y"),
        ("outputs: y", "must have the keys `inputs` and `output` alone"),
        ("{", ":1:2: is no YAML: "),
        ("inputs: {x: 3}", "`inputs.x` must be a column, or a list of columns"),
    ],
)
def test_a_map_that_does_not_fit_is_refused(text: str, message: str, tmp_path: Path) -> None:
    onnx.save(model_of(NODE("MatMul", ["x", "w"], ["y"]), w=W), tmp_path / "a.onnx")
    (tmp_path / "map.yaml").write_text(text)
    with pytest.raises(InputError, match=message):
        chosen = read_map(tmp_path / "map.yaml")
        read_onnx(tmp_path / "a.onnx", CompiledScenario("hover_learn"), chosen)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--policy", "cut.onnx"], "cut.onnx: is no ONNX file"),
        (["--policy", "hold", "--map", "map.yaml"], "--map is for a --policy in ONNX"),
    ],
)
def test_the_program_refuses_bad_files_with_one_line(
    words: list[str], message: str, tmp_path: Path
) -> None:
    (tmp_path / "cut.onnx").write_bytes(b"\x08\x08\x12")
    (tmp_path / "map.yaml").write_text("")
    command = [PROGRAM, "run", "hover_learn", *words, "--out", "log"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert message in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "log").exists()
