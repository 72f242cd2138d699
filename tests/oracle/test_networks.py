"""The native learners' networks and optimiser against PyTorch, in double and in float."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from skybody import _native
from skybody.train.policy_file import Layer, Policy, read_policy, write_policy

torch = pytest.importorskip("torch")

SHAPES = [
    (22, [64, 64], 4, "tanh"),
    (22, [64, 64], 1, "elu"),
    (7, [33, 130], 3, "relu"),
    (70, [512, 512], 4, "tanh"),
    (5, [], 2, "tanh"),
]
ACTIVATIONS = {"tanh": torch.nn.Tanh, "elu": torch.nn.ELU, "relu": torch.nn.ReLU}


def torch_network(network: Any, parameters: Any, dtype: Any) -> Any:
    return torch_dense(network.layers(parameters), dtype)


def torch_dense(layers: Any, dtype: Any) -> Any:
    modules: list[Any] = []
    for weight, bias, activation in layers:
        linear = torch.nn.Linear(weight.shape[1], weight.shape[0], dtype=dtype)
        with torch.no_grad():
            linear.weight.copy_(torch.from_numpy(weight))
            linear.bias.copy_(torch.from_numpy(bias))
        modules.append(linear)
        if activation != "none":
            modules.append(ACTIVATIONS[activation]())
    return torch.nn.Sequential(*modules)


def flat(layers: Any) -> np.ndarray:
    return np.concatenate([part.ravel() for weight, bias, *_ in layers for part in (weight, bias)])


def error(ours: np.ndarray, theirs: np.ndarray) -> float:
    """The largest difference, relative to the largest value."""
    return float(np.abs(ours - theirs).max() / np.abs(theirs).max())


def subject(shape: tuple[int, list[int], int, str], rows: int = 97) -> tuple[Any, ...]:
    inputs, hidden, outputs, activation = shape
    network = _native.Network(inputs, hidden, outputs, activation)
    generator = np.random.default_rng(3)
    x = generator.standard_normal((rows, inputs)).astype(np.float32)
    dy = generator.standard_normal((rows, outputs)).astype(np.float32)
    return network, network.initial_parameters(1.0, 7), x, dy


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_outputs_and_gradients_are_those_of_pytorch(shape: Any) -> None:
    network, parameters, x, dy = subject(shape)
    peer = torch_network(network, parameters, torch.float64)
    rows = torch.from_numpy(x).double().requires_grad_()
    y = peer(rows)
    y.backward(torch.from_numpy(dy).double())
    gradient, dx = network.backward(parameters, x, dy)
    wanted = np.concatenate([p.grad.numpy().ravel() for p in peer.parameters()])
    # Sums of up to 512 products of size 1 round 512 times by at most 2^-24 of their size.
    assert error(network.forward(parameters, x), y.detach().numpy()) < 1e-5
    assert error(dx, rows.grad.numpy()) < 1e-5
    assert error(flat(network.layers(gradient)), wanted) < 1e-5


@pytest.mark.parametrize("shape", SHAPES[:3], ids=str)
def test_updates_by_adam_are_those_of_pytorch(shape: Any) -> None:
    network, parameters, x, dy = subject(shape)
    peer = torch_network(network, parameters, torch.float32)
    theirs = torch.optim.Adam(peer.parameters(), lr=1e-3, eps=1e-5)
    ours = _native.Adam(network.parameter_count, 0.5)
    before = flat(network.layers(parameters))
    for _ in range(5):
        gradient, _ = network.backward(parameters, x, dy)
        parameters = ours.step(gradient, 1e-3, parameters)
        theirs.zero_grad()
        peer(torch.from_numpy(x)).backward(torch.from_numpy(dy))
        torch.nn.utils.clip_grad_norm_(peer.parameters(), 0.5)
        theirs.step()
    wanted = np.concatenate([p.detach().numpy().ravel() for p in peer.parameters()])
    after = flat(network.layers(parameters))
    assert error(after, wanted) < 1e-5
    # The steps themselves: five of about 1e-3 on parameters near 1 that are rounded to 2^-24.
    assert error(after - before, wanted - before) < 1e-3


RECURRENT = [(9, 64, [64], 4, "tanh"), (3, 5, [], 2, "tanh"), (22, 70, [33, 17], 1, "elu")]


def recurrent_subject(shape: Any) -> tuple[Any, ...]:
    inputs, units, hidden, outputs, activation = shape
    network = _native.RecurrentNetwork(inputs, units, hidden, outputs, activation)
    generator = np.random.default_rng(4)
    x = generator.standard_normal((7, 12, inputs)).astype(np.float32)
    dy = generator.standard_normal((7, 12, outputs)).astype(np.float32)
    states = generator.uniform(-1, 1, (7, units)).astype(np.float32)
    begins = generator.random((7, 12)) < 0.15
    return network, network.initial_parameters(1.0, 7), x, begins, states, dy


def torch_recurrent(layers: Any) -> tuple[Any, Any]:
    weight, bias, _, state_weight, state_bias = layers[0]
    cell = torch.nn.GRUCell(weight.shape[1], state_weight.shape[1], dtype=torch.float64)
    with torch.no_grad():
        cell.weight_ih.copy_(torch.from_numpy(weight))
        cell.weight_hh.copy_(torch.from_numpy(state_weight))
        cell.bias_ih.copy_(torch.from_numpy(bias))
        cell.bias_hh.copy_(torch.from_numpy(state_bias))
    return cell, torch_dense(layers[1:], torch.float64)


def run_torch(peer: tuple[Any, Any], x: Any, begins: Any, states: Any) -> Any:
    cell, head = peer
    state, outputs = torch.from_numpy(states).double(), []
    for t in range(x.shape[1]):
        state = torch.where(torch.from_numpy(begins[:, t, None]), 0.0, state)
        state = cell(x[:, t], state)
        outputs.append(head(state))
    return torch.stack(outputs, dim=1)


@pytest.mark.parametrize("shape", RECURRENT, ids=str)
def test_recurrent_outputs_and_gradients_are_those_of_pytorch(shape: Any) -> None:
    network, parameters, x, begins, states, dy = recurrent_subject(shape)
    peer = torch_recurrent(network.layers(parameters))
    rows = torch.from_numpy(x).double().requires_grad_()
    y = run_torch(peer, rows, begins, states)
    y.backward(torch.from_numpy(dy).double())
    gradient, dx = network.backward(parameters, x, begins.ravel(), states, dy)
    cell, head = peer
    ours = network.layers(gradient)
    # As above: float sums of at most a few hundred terms.
    assert error(network.forward(parameters, x, begins.ravel(), states), y.detach().numpy()) < 1e-5
    assert error(dx, rows.grad.numpy()) < 1e-5
    weight, bias, _, state_weight, state_bias = ours[0]
    assert error(weight, cell.weight_ih.grad.numpy()) < 1e-5
    assert error(bias, cell.bias_ih.grad.numpy()) < 1e-5
    assert error(state_weight, cell.weight_hh.grad.numpy()) < 1e-5
    assert error(state_bias, cell.bias_hh.grad.numpy()) < 1e-5
    wanted = np.concatenate([p.grad.numpy().ravel() for p in head.parameters()])
    assert error(flat(ours[1:]), wanted) < 1e-5


def test_a_recurrent_policy_file_acts_as_pytorch(tmp_path: Path) -> None:
    network, parameters, x, _, _, _ = recurrent_subject(RECURRENT[0])
    layers = [Layer(*layer) for layer in network.layers(parameters)]
    stamps = {"scenario": "hover", "scenario_hash": "0" * 16, "algorithm": "test", "steps": 5}
    file = tmp_path / "policy.h5"
    write_policy(file, Policy(layers, np.zeros(9), np.ones(9), 10.0, stamps))
    policy = read_policy(file)
    never, zero = np.zeros(x.shape[:2], bool), np.zeros((7, 64), np.float32)
    peer = torch_recurrent(network.layers(parameters))
    wanted = run_torch(peer, torch.from_numpy(x).double(), never, zero).detach().numpy()
    states = policy.states(7)
    for t in range(12):
        # Both evaluate the same float weights in double.
        np.testing.assert_allclose(policy(x[:, t], states), np.clip(wanted[:, t], -1, 1), atol=1e-9)


# Height, width, channels; channels, kernels, strides and padding of the convolutions; features.
ENCODERS = [
    (64, 64, 1, [16, 32, 32], [8, 4, 3], [4, 2, 1], False, 128, "relu"),
    (33, 40, 3, [20, 16], [5, 4], [3, 2], True, 30, "tanh"),
    (12, 12, 2, [], [], [], False, 7, "elu"),
]


def torch_encoder(layers: Any) -> Any:
    """The layers on images (rows, channels, height, width), in double."""
    modules: list[Any] = []
    for weight, bias, activation, (height, width, stride, padding) in layers:
        shape = (len(weight), height, width, weight.shape[1] // (height * width))
        conv = torch.nn.Conv2d(
            shape[3], shape[0], (height, width), stride=stride, dtype=torch.float64
        )
        with torch.no_grad():
            conv.weight.copy_(torch.from_numpy(weight.reshape(shape)).permute(0, 3, 1, 2))
            conv.bias.copy_(torch.from_numpy(bias))
        if padding == "same":
            modules.append(SamePadding(height, width, stride))
        modules += [conv, ACTIVATIONS[activation]()]
    return torch.nn.Sequential(*modules, torch.nn.Flatten())


class SamePadding(torch.nn.Module):
    """TensorFlow's padding `same`, which PyTorch has for a stride of 1 only."""

    def __init__(self, height: int, width: int, stride: int) -> None:
        super().__init__()
        self._kernel, self._stride = (height, width), stride

    def forward(self, x: Any) -> Any:
        sides: list[int] = []
        for size, kernel in zip(reversed(x.shape[2:]), reversed(self._kernel), strict=True):
            missing = max(0, (-(-size // self._stride) - 1) * self._stride + kernel - size)
            sides += [missing // 2, missing - missing // 2]
        return torch.nn.functional.pad(x, sides)


def encoder_gradient(peer: Any) -> np.ndarray:
    parts = []
    for module in peer:
        if isinstance(module, torch.nn.Conv2d):
            parts.append(module.weight.grad.permute(0, 2, 3, 1).numpy().ravel())
            parts.append(module.bias.grad.numpy().ravel())
    return np.concatenate(parts)


@pytest.mark.parametrize("shape", ENCODERS, ids=str)
def test_features_of_images_and_their_gradients_are_those_of_pytorch(shape: Any) -> None:
    encoder = _native.ImageEncoder(*shape)
    parameters = encoder.initial_parameters(7)
    generator = np.random.default_rng(5)
    x = generator.random((19, *shape[:3])).astype(np.float32)
    dy = generator.standard_normal((19, shape[7])).astype(np.float32)
    peer = torch_encoder(encoder.layers(parameters))
    y = peer(torch.from_numpy(x).double().permute(0, 3, 1, 2))
    y.backward(torch.from_numpy(dy).double())
    # As above: float sums of at most a few thousand terms.
    assert error(encoder.forward(parameters, x), y.detach().numpy()) < 1e-5
    ours = flat(encoder.layers(encoder.backward(parameters, x, dy)))
    assert error(ours, encoder_gradient(peer)) < 1e-5


def test_a_wrong_activation_is_refused_with_those_allowed() -> None:
    with pytest.raises(Exception, match="`gelu`; allowed: tanh, relu, elu"):
        _native.Network(3, [4], 1, "gelu")
