"""The network of a policy as a list of C tables and calls (core/policy/network_layers.h)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from skybody._native import policy_panels
from skybody.train.image_layers import Convolution, PolicyImage, border
from skybody.train.policy_file import Layer, Policy

from .c_text import arguments, number, table

ACTIVATIONS = {"none": "LAYER_NONE", "tanh": "LAYER_TANH", "relu": "LAYER_RELU", "elu": "LAYER_ELU"}


@dataclass
class Network:
    """C text of the tables, and statements that evaluate the network; sizes of the work space.

    The statements read `inputs`, whose features of images they also write, and use `values[2]`,
    `sums` and `memory`. The last layer's outputs are in `result`.
    """

    tables: list[str] = field(default_factory=list)
    image_calls: list[list[str]] = field(default_factory=list)  # of each image, after its pixels
    calls: list[str] = field(default_factory=list)
    width: int = 1  # of each of the two buffers
    sums: int = 0  # of a recurrent layer
    memory: int = 0  # recurrent states
    features: int = 0  # of all images
    operations: int = 0  # products
    result: str = "inputs"

    def add_table(self, name: str, values: NDArray[np.floating]) -> str:
        """Adds an array; returns its name."""
        self.tables.append(table(name, values))
        return name


def network_of(policy: Policy) -> Network:
    """The network of a policy."""
    made = Network()
    inputs = len(policy.mean)
    if np.isfinite(policy.clip):
        _normalize(made, policy)
    for k, image in enumerate(policy.images):
        made.image_calls.append(_image(made, image, f"image{k}", inputs))
        inputs += image.size
        made.features += image.size
    for k, layer in enumerate(policy.layers):
        _layer(made, layer, k)
    return made


def _normalize(made: Network, policy: Policy) -> None:
    mean = policy.mean.astype(np.float32)
    rest = policy.mean - mean.astype(np.float64)
    names = [
        made.add_table("mean", mean),
        made.add_table("mean_rest", rest),
        made.add_table("scale", policy.scale),
    ]
    words = ["inputs", *names, number(policy.clip), str(len(mean)), "inputs"]
    made.calls.append(f"layer_normalize({arguments(words)});")


def _image(made: Network, image: PolicyImage, name: str, first: int) -> list[str]:
    """Tables and calls of an image's convolutions; its pixels are in values[0]."""
    calls: list[str] = []
    shape: Sequence[int] = image.shape
    made.width = max(made.width, int(np.prod(shape)))
    for k, layer in enumerate(image.layers):
        last = k + 1 == len(image.layers)
        target = f"inputs + {first}" if last else f"values[{(k + 1) % 2}]"
        shape = _convolution(made, layer, f"{name}_{k}", shape)
        words = [
            f"&{name}_{k}", f"{name}_{k}_weight", f"{name}_{k}_bias",
            ACTIVATIONS[layer.activation], f"values[{k % 2}]", target,
        ]  # fmt: skip
        calls.append(f"layer_convolve({arguments(words)});")
        made.width = max(made.width, int(np.prod(shape)))
    return calls


def _convolution(
    made: Network, layer: Convolution, name: str, shape: Sequence[int]
) -> tuple[int, int, int]:
    """Adds a convolution's tables; returns the shape of its output."""
    height, width, channels = shape
    kernel_height, kernel_width, stride, padding = layer.kernel
    top = left = 0
    if padding == "same":
        top, left = border(height, kernel_height, stride)[0], border(width, kernel_width, stride)[0]
        rows, columns = -(-height // stride), -(-width // stride)
    else:
        rows, columns = (height - kernel_height) // stride + 1, (width - kernel_width) // stride + 1
    outputs = len(layer.bias)
    sizes = (
        height, width, channels, kernel_height, kernel_width, stride, top, left, rows, columns,
        outputs,
    )  # fmt: skip
    made.tables.append(
        f"static const LayerConvolution {name} = {{{', '.join(map(str, sizes))}}};\n"
    )
    made.add_table(f"{name}_weight", policy_panels(layer.weight.astype(np.float64)))
    made.add_table(f"{name}_bias", layer.bias)
    made.operations += rows * columns * layer.weight.size
    return rows, columns, outputs


def _layer(made: Network, layer: Layer, k: int) -> None:
    """Adds a layer, from `result` to the other buffer."""
    target = "values[1]" if made.result == "values[0]" else "values[0]"
    name = f"layer{k}"
    rows, inputs = layer.weight.shape
    made.add_table(f"{name}_weight", policy_panels(layer.weight.astype(np.float64)))
    made.add_table(f"{name}_bias", layer.bias)
    made.operations += layer.weight.size
    made.width = max(made.width, rows if not layer.units else 1)
    if layer.state_weight is None or layer.state_bias is None:
        words = [
            f"{name}_weight", f"{name}_bias", str(inputs), str(rows),
            ACTIVATIONS[layer.activation], made.result, target,
        ]  # fmt: skip
        made.calls.append(f"layer_dense({arguments(words)});")
        made.result = target
        return
    made.add_table(f"{name}_state_weight", policy_panels(layer.state_weight.astype(np.float64)))
    made.add_table(f"{name}_state_bias", layer.state_bias)
    made.operations += layer.state_weight.size
    state = f"state->memory + {made.memory}"
    words = [
        f"{name}_weight", f"{name}_bias", f"{name}_state_weight", f"{name}_state_bias",
        str(inputs), str(layer.units), made.result, state, "state->sums",
    ]  # fmt: skip
    kind = {3: "layer_gru", 4: "layer_lstm"}[layer.gates]
    made.calls.append(f"{kind}({arguments(words)});")
    made.memory += layer.memory
    made.sums = max(made.sums, 2 * rows)
    made.result = state
