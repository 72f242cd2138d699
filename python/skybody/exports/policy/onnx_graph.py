"""The graph of an exported policy in ONNX's operators."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import onnx
from numpy.typing import ArrayLike
from onnx import TensorProto, helper, numpy_helper

from skybody.train.image_layers import Convolution, PolicyImage, border
from skybody.train.policy_file import Layer, Policy

from .interface import Image, Interface

BATCH = "batch"  # the first dimension of each input and output
ACTIVATIONS = {"tanh": "Tanh", "relu": "Relu", "elu": "Elu"}
PIXELS = {
    "float32": TensorProto.FLOAT,
    "uint8": TensorProto.UINT8,
    "uint16": TensorProto.UINT16,
}
MEMORY, ROBOT, ACTION, COMMAND = "memory", "robot", "action", "command"
NEXT = "_next"  # added to the name of a state's input: its value for the next evaluation


@dataclass
class Graph:
    """A graph that grows by nodes; each method returns the name of its result."""

    nodes: list[onnx.NodeProto] = field(default_factory=list)
    constants: list[onnx.TensorProto] = field(default_factory=list)
    inputs: list[onnx.ValueInfoProto] = field(default_factory=list)
    outputs: list[onnx.ValueInfoProto] = field(default_factory=list)

    def constant(self, values: ArrayLike, dtype: Any = np.float32) -> str:
        """Adds an array."""
        name = f"constant_{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.asarray(values, dtype), name))
        return name

    def add(self, kind: str, *inputs: str, outputs: Sequence[str] = (), **attributes: Any) -> str:
        """Adds a node; `outputs`: names, of which the last is returned (default: a new one)."""
        names = list(outputs) or [f"value_{len(self.nodes)}"]
        self.nodes.append(helper.make_node(kind, list(inputs), names, **attributes))
        return names[-1]

    def name(self, result: str, name: str) -> str:
        """Gives a result a name of its own."""
        return self.add("Identity", result, outputs=[name])

    def columns(self, values: str, begin: int, end: int) -> str:
        """Columns begin ... end - 1 of rows."""
        limits = [self.constant([k], np.int64) for k in (begin, end, 1)]
        return self.add("Slice", values, *limits)

    def activate(self, values: str, activation: str) -> str:
        """An activation of policy.h5."""
        return values if activation == "none" else self.add(ACTIVATIONS[activation], values)


def declared(
    name: str, meaning: str, *shape: int, kind: int = TensorProto.FLOAT
) -> onnx.ValueInfoProto:
    """An input or output with the batch's dimension."""
    return helper.make_tensor_value_info(name, kind, [BATCH, *shape], doc_string=meaning)


def graph_of(policy: Policy, interface: Interface, name: str) -> onnx.GraphProto:
    """The whole graph."""
    graph = Graph()
    x = _inputs(graph, interface)
    if np.isfinite(policy.clip):
        x = _normalize(graph, policy, x)
    features = [
        _features(graph, image, seen)
        for image, seen in zip(policy.images, interface.images, strict=True)
    ]
    if features:
        x = graph.add("Concat", x, *features, axis=1)
    _layers(graph, policy, interface, x)
    return helper.make_graph(graph.nodes, name, graph.inputs, graph.outputs, graph.constants)


def _inputs(graph: Graph, interface: Interface) -> str:
    """Declares the inputs; returns the network's, in one row."""
    parts = []
    for signal in interface.signals:
        past = signal.actions is not None
        name = f"past_{signal.name}" if past else signal.name
        parts.append(name)
        unit = f"[{signal.unit}] " if signal.unit else ""
        graph.inputs.append(declared(name, unit + signal.meaning, signal.count))
    return graph.add("Concat", *parts, axis=1)


def _normalize(graph: Graph, policy: Policy, x: str) -> str:
    """In float with the mean in two parts, as core/policy/network_layers.h."""
    mean = policy.mean.astype(np.float32)
    x = graph.add("Sub", x, graph.constant(mean))
    x = graph.add("Sub", x, graph.constant(policy.mean - mean.astype(np.float64)))
    x = graph.add("Mul", x, graph.constant(policy.scale))
    return graph.add("Clip", x, graph.constant(-policy.clip), graph.constant(policy.clip))


def _features(graph: Graph, image: PolicyImage, seen: Image) -> str:
    """Features (batch, F) of an image."""
    meaning = f"[{seen.unit}] image `{seen.column}`" if seen.unit else f"image `{seen.column}`"
    graph.inputs.append(declared(seen.name, meaning, *seen.shape, kind=PIXELS[seen.dtype]))
    low, high = np.float32(image.low), np.float32(image.high)
    x = graph.add("Cast", seen.name, to=TensorProto.FLOAT)
    if seen.dtype == "float32":
        x = graph.add("Where", graph.add("IsNaN", x), graph.constant(high), x)
    x = graph.add("Clip", x, graph.constant(low), graph.constant(high))
    x = graph.add("Sub", x, graph.constant(low))
    x = graph.add("Mul", x, graph.constant(np.float32(1.0) / (high - low)))
    x = graph.add("Transpose", x, perm=[0, 3, 1, 2])
    shape: Sequence[int] = image.shape
    for layer in image.layers:
        x, shape = _convolve(graph, layer, x, shape)
    return graph.add("Flatten", x, axis=1)


def _convolve(
    graph: Graph, layer: Convolution, x: str, shape: Sequence[int]
) -> tuple[str, Sequence[int]]:
    """The output of a convolution, (batch, channels, rows, columns), and its shape."""
    height, width, channels = shape
    *kernel, stride, padding = layer.kernel
    pads = [(0, 0), (0, 0)]
    if padding == "same":
        pads = [border(height, kernel[0], stride), border(width, kernel[1], stride)]
    weight = layer.weight.reshape(-1, *kernel, channels).transpose(0, 3, 1, 2)
    x = graph.add(
        "Conv",
        x,
        graph.constant(weight),
        graph.constant(layer.bias),
        kernel_shape=kernel,
        strides=[stride, stride],
        pads=[pads[0][0], pads[1][0], pads[0][1], pads[1][1]],
    )
    rows, columns = (
        (size + sum(pad) - k) // stride + 1
        for size, pad, k in zip((height, width), pads, kernel, strict=True)
    )
    return graph.activate(x, layer.activation), (rows, columns, len(layer.bias))


def _layers(graph: Graph, policy: Policy, interface: Interface, x: str) -> None:
    """The network after its inputs, and all outputs."""
    size = sum(layer.memory for layer in policy.layers)
    if size:
        graph.inputs.append(declared(MEMORY, "recurrent state, zero before the first", size))
    states, begin = [], 0
    for layer in policy.layers:
        if layer.units:
            before = [
                graph.columns(MEMORY, first, first + layer.units)
                for first in range(begin, begin + layer.memory, layer.units)
            ]
            after = _recurrent(graph, layer, x, before)
            x = after[0]
            begin += layer.memory
            states += after
        else:
            weight, bias = graph.constant(layer.weight), graph.constant(layer.bias)
            x = graph.activate(graph.add("Gemm", x, weight, bias, transB=1), layer.activation)
    _outputs(graph, policy, interface, x)
    if size:
        graph.name(graph.add("Concat", *states, axis=1), MEMORY + NEXT)
        graph.outputs.append(declared(MEMORY + NEXT, "recurrent state for the next step", size))


# The order of gates in ONNX: z, r, n of GRU, i, o, f, g of LSTM, as places in that of policy.h5.
GATES = {3: ("GRU", (1, 0, 2)), 4: ("LSTM", (0, 3, 1, 2))}


def _recurrent(graph: Graph, layer: Layer, x: str, states: list[str]) -> list[str]:
    """The states after a step. ONNX has a sequence's dimension first."""
    assert layer.state_weight is not None and layer.state_bias is not None
    kind, order = GATES[layer.gates]
    weight, state_weight, bias, state_bias = (
        np.concatenate([np.split(array, layer.gates)[gate] for gate in order])
        for array in (layer.weight, layer.state_weight, layer.bias, layer.state_bias)
    )
    first = graph.constant([0], np.int64)
    constants = (weight[None], state_weight[None], np.concatenate([bias, state_bias])[None])
    results = [f"state_{len(graph.nodes)}_{k}" for k in range(len(states))]
    graph.add(
        kind,
        graph.add("Unsqueeze", x, first),
        *(graph.constant(values) for values in constants),
        "",
        *(graph.add("Unsqueeze", state, first) for state in states),
        outputs=["", *results],
        hidden_size=layer.units,
        **({"linear_before_reset": 1} if kind == "GRU" else {}),
    )
    return [graph.add("Squeeze", result, first) for result in results]


def _outputs(graph: Graph, policy: Policy, interface: Interface, x: str) -> None:
    """Actions, commands and past actions."""
    count = len(interface.outputs)
    bounded = (
        graph.add("Tanh", x)
        if policy.squash == "tanh"
        else graph.add("Clip", x, graph.constant(-1.0), graph.constant(1.0))
    )
    graph.name(bounded, ACTION)
    low, high = (
        np.array(values, np.float32).T
        for values in zip(*((output.low, output.high) for output in interface.outputs), strict=True)
    )
    graph.name(_command(graph, interface, low, high), COMMAND)
    names = ", ".join(
        f"{output.name} [{output.unit}]" if output.unit else output.name
        for output in interface.outputs
    )
    graph.outputs.append(declared(COMMAND, f"command: {names}", count))
    graph.outputs.append(declared(ACTION, f"actions in [-1, 1]: {names}", count))
    for signal in interface.past_actions:
        assert signal.actions is not None
        name, size = f"past_{signal.name}", len(signal.actions)
        newest = graph.columns(ACTION, signal.actions.start, signal.actions.stop)
        if signal.count > size:
            older = graph.columns(name, 0, signal.count - size)
            newest = graph.add("Concat", newest, older, axis=1)
        graph.name(newest, name + NEXT)
        graph.outputs.append(declared(name + NEXT, f"`{name}` of the next step", signal.count))


def _command(graph: Graph, interface: Interface, low: ArrayLike, high: ArrayLike) -> str:
    """low + (action + 1) / 2 (high - low), by the robot if ranges differ."""
    middle = graph.add("Add", ACTION, graph.constant(1.0))
    share = graph.add("Mul", middle, graph.constant(0.5))
    least, span = graph.constant(low), graph.constant(np.subtract(high, low))
    if interface.ranges_differ:
        robots = ", ".join(f"{k} {robot}" for k, robot in enumerate(interface.robots))
        graph.inputs.append(
            declared(ROBOT, f"whose ranges of commands count: {robots}", kind=TensorProto.INT64)
        )
        least, span = graph.add("Gather", least, ROBOT), graph.add("Gather", span, ROBOT)
    return graph.add("Add", least, graph.add("Mul", share, span))
