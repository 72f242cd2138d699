"""The native learners' networks and optimiser against PyTorch, in double and in float."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from skybody import _native

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
    modules: list[Any] = []
    for weight, bias, activation in network.layers(parameters):
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
    """The greatest difference, as a share of the greatest value."""
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


def test_a_wrong_activation_is_refused_with_those_allowed() -> None:
    with pytest.raises(Exception, match="`gelu`; allowed: tanh, relu, elu"):
        _native.Network(3, [4], 1, "gelu")
