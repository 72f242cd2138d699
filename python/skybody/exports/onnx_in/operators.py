"""ONNX's operators on the values of chain.py."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from skybody.train.image_layers import border
from skybody.train.policy_file import Layer

from .chain import Hidden, Inputs, Picture, Unmapped, Unsupported, joined, with_layer

Value = Any  # Inputs, Hidden, Picture, Unmapped, a constant array; None: left out
Attributes = dict[str, Any]
GATES = {"GRU": (1, 0, 2), "LSTM": (0, 2, 3, 1)}  # places in ONNX of the gates of policy.h5


def is_constant(value: Value) -> bool:
    """Whether a value does not depend on the inputs."""
    return isinstance(value, (np.ndarray, np.generic))


def same(values: Sequence[Value], _: Attributes) -> Value:
    """Operators that do not change a row of numbers."""
    return values[0]


def affine(name: str) -> Callable[[Sequence[Value], Attributes], Value]:
    """Add, Sub, Mul or Div with a constant."""

    def apply(values: Sequence[Value], _: Attributes) -> Value:
        a, b = values
        if is_constant(a) and is_constant(b):
            return {"Add": np.add, "Sub": np.subtract, "Mul": np.multiply, "Div": np.divide}[name](
                a, b
            )
        value, constant = (data(b), a) if is_constant(a) else (data(a), b)
        if not is_constant(constant):
            raise Unsupported(
                f"{name} of two values that are no constants: layers side by side and skipped "
                "layers are not supported"
            )
        number = per_entry(value, constant)
        if name == "Add":
            return value.mapped(1.0, number)
        if name == "Mul":
            return value.mapped(number, 0.0)
        if name == "Sub":
            return value.mapped(1.0, -number) if value is a else value.mapped(-1.0, number)
        if value is b:
            raise Unsupported("a constant divided by a value")
        return value.mapped(1.0 / number, 0.0)

    return apply


def data(value: Value) -> Inputs | Hidden | Picture:
    """A value that depends on observations. Raises Unsupported."""
    return value if isinstance(value, Picture) else row(value)


def per_entry(value: Value, constant: Value) -> Any:
    """A constant as a number, or one for each entry or channel."""
    numbers = np.asarray(constant, np.float64)
    if numbers.size == 1:
        return float(numbers.reshape(-1)[0])
    size = len(value.factor) if hasattr(value, "factor") else 0
    if numbers.size != size:
        raise Unsupported(f"a constant of {numbers.size} values for a row of {size}")
    return numbers.reshape(-1)


def gemm(values: Sequence[Value], attributes: Attributes) -> Value:
    """A dense layer."""
    if attributes.get("transA", 0) or not is_constant(values[1]):
        raise Unsupported("Gemm of a transposed value, or without constant weights")
    weight = np.asarray(values[1], np.float64) * attributes.get("alpha", 1.0)
    weight = weight if attributes.get("transB", 0) else weight.T
    bias = np.zeros(len(weight))
    if len(values) > 2 and values[2] is not None:
        bias = bias + np.asarray(values[2], np.float64).reshape(-1) * attributes.get("beta", 1.0)
    return dense(values[0], weight, bias)


def matmul(values: Sequence[Value], _: Attributes) -> Value:
    """A dense layer without bias."""
    if not is_constant(values[1]):
        raise Unsupported("MatMul of two values that are no constants")
    weight = np.asarray(values[1], np.float64).T
    return dense(values[0], weight, np.zeros(len(weight)))


def dense(value: Value, weight: Any, bias: Any) -> Value:
    """A value through a dense layer."""
    if isinstance(value, Picture):
        return replace(value.through(weight, bias), is_flat=True)
    return with_layer(row(value), Layer(weight, bias, "none"))


def row(value: Value) -> Inputs | Hidden:
    """A value that is a row. Raises Unsupported."""
    if isinstance(value, Unmapped):
        raise Unsupported(f"input `{value.name}` is no observation: name its columns in --map FILE")
    if not isinstance(value, (Inputs, Hidden)):
        raise Unsupported("a layer of a constant, or of an image that is not flat")
    return value


def activation(name: str) -> Callable[[Sequence[Value], Attributes], Value]:
    """An activation that policy.h5 has."""

    def apply(values: Sequence[Value], attributes: Attributes) -> Value:
        if attributes.get("alpha", 1.0) != 1.0:
            raise Unsupported("Elu with another alpha than 1")
        value = values[0] if isinstance(values[0], Picture) else hidden(values[0])
        return value.activated(name)

    return apply


def sigmoid(values: Sequence[Value], _: Attributes) -> Value:
    """1 / (1 + e^-x) = 1 / 2 + tanh(x / 2) / 2."""
    value = values[0] if isinstance(values[0], Picture) else hidden(values[0])
    return value.mapped(0.5, 0.0).activated("tanh").mapped(0.5, 0.5)


def hidden(value: Value) -> Hidden:
    """A value that is the output of a layer, of the identity if it is an input."""
    found = row(value)
    if isinstance(found, Hidden):
        return found
    size = len(found)
    return with_layer(found, Layer(np.eye(size), np.zeros(size), "none"))


def clip(values: Sequence[Value], _: Attributes) -> Value:
    """Clip of inputs and images, and of the actions."""
    value, low, high = [*values, None, None][:3]
    least = -np.inf if low is None else float(np.asarray(low).reshape(-1)[0])
    most = np.inf if high is None else float(np.asarray(high).reshape(-1)[0])
    if isinstance(value, Picture):
        return value.clipped(least, most)
    if isinstance(value, Inputs):
        if least != -most:
            raise Unsupported(f"inputs clipped to {least:g} ... {most:g}; only -c ... c can be")
        return value.clipped(most)
    if (least, most) == (0.0, np.inf):
        return hidden(value).activated("relu")
    if (least, most) != (-1.0, 1.0):
        raise Unsupported(f"outputs clipped to {least:g} ... {most:g}; allowed: -1 ... 1")
    return replace(hidden(value), is_bounded=True)


def concat(values: Sequence[Value], _: Attributes) -> Value:
    """Inputs and features in one row."""
    if all(is_constant(value) for value in values):
        return np.concatenate([np.atleast_1d(value) for value in values])
    if all(isinstance(value, Unmapped) for value in values):
        return values[0]
    parts = [row(value) for value in values]
    if not all(isinstance(part, Inputs) for part in parts):
        raise Unsupported("layers side by side, or that skip one")
    return joined([part for part in parts if isinstance(part, Inputs)])


def chosen(values: Sequence[Value], attributes: Attributes) -> Value:
    """Slice of the entries of a row."""
    value = values[0]
    if isinstance(value, Unmapped):
        return value
    begin, end, axis, step = (
        int(np.asarray(v).reshape(-1)[0]) if v is not None else default
        for v, default in zip([*values[1:], None, None][:4], (0, 0, 1, 1), strict=True)
    )
    if is_constant(value):
        return np.asarray(value)[begin:end:step]
    if isinstance(value, Hidden) and begin in (0, -1):
        return value  # the last of a sequence of one step; check_equal() finds other slices
    if axis not in (1, -1) or not isinstance(value, Inputs):
        raise Unsupported("Slice of the batch, or of a layer's outputs")
    return value.taken(slice(begin, min(end, len(value)), step))


def gather(values: Sequence[Value], attributes: Attributes) -> Value:
    """Chosen entries of a row."""
    value, index = values
    if isinstance(value, Unmapped):
        return value
    places = np.asarray(index).reshape(-1).astype(np.intp)
    if is_constant(value):
        return np.asarray(value)[places if np.ndim(index) else int(places[0])]
    if isinstance(value, Hidden) and len(places) == 1 and places[0] in (0, -1):
        return value  # likewise
    if attributes.get("axis", 0) not in (1, -1) or not isinstance(value, Inputs):
        raise Unsupported("Gather of the batch, or of a layer's outputs")
    return value.taken(places)


def transpose(values: Sequence[Value], attributes: Attributes) -> Value:
    """Another order of an image's axes; rows keep theirs."""
    value, order = values[0], list(attributes.get("perm", []))
    if not isinstance(value, Picture):
        return value
    if order == [0, 3, 1, 2] and value.axes == "NHWC":
        return replace(value, axes="NCHW")
    if order == [0, 2, 3, 1] and value.axes == "NCHW":
        return replace(value, axes="NHWC")
    raise Unsupported(f"Transpose of an image by {order}")


def flatten(values: Sequence[Value], attributes: Attributes) -> Value:
    """An image as a row."""
    value = values[0]
    if is_constant(value):
        return np.asarray(value).reshape(-1)
    return replace(value, is_flat=True) if isinstance(value, Picture) and value.layers else value


def convolution(values: Sequence[Value], attributes: Attributes) -> Value:
    """A convolution of an image."""
    value = values[0]
    if not isinstance(value, Picture):
        raise Unsupported("Conv of a row")
    weight = np.asarray(values[1], np.float64).transpose(0, 2, 3, 1)
    bias = np.zeros(len(weight)) if len(values) < 3 else np.asarray(values[2], np.float64)
    height, width = weight.shape[1:3]
    strides = attributes.get("strides", [1, 1])
    if attributes.get("group", 1) != 1 or set(attributes.get("dilations", [1])) != {1}:
        raise Unsupported("Conv with groups or dilations")
    if len(set(strides)) != 1:
        raise Unsupported("Conv with two strides")
    borders = [
        border(size, kernel, strides[0])
        for size, kernel in zip(value.shape[:2], (height, width), strict=True)
    ]
    pads = list(attributes.get("pads", [0, 0, 0, 0]))
    same_pads = [borders[0][0], borders[1][0], borders[0][1], borders[1][1]]
    if attributes.get("auto_pad", "NOTSET") in ("SAME_UPPER",):
        pads = same_pads
    padding = "valid" if pads == [0, 0, 0, 0] else "same"
    if padding == "same" and pads != same_pads:
        raise Unsupported(f"Conv with pads {pads}; allowed: none, or {same_pads}")
    found = replace(value, axes="NCHW")
    return found.convolved(weight, bias, (height, width, strides[0], padding))


def normalization(values: Sequence[Value], attributes: Attributes) -> Value:
    """BatchNormalization with fixed statistics."""
    value = data(values[0])
    scale, bias, mean, variance = (np.asarray(v, np.float64) for v in values[1:])
    factor = scale / np.sqrt(variance + attributes.get("epsilon", 1e-5))
    return value.mapped(factor, bias - mean * factor)


def recurrent(kind: str) -> Callable[[Sequence[Value], Attributes], Value]:
    """GRU or LSTM, one step of a sequence; states are zero at first."""

    def apply(values: Sequence[Value], attributes: Attributes) -> Value:
        value, weight, state_weight, bias = [*values, None][:4]
        if attributes.get("direction", "forward") != "forward":
            raise Unsupported(f"{kind} in another direction than forward")
        if "activations" in attributes or "clip" in attributes:
            raise Unsupported(f"{kind} with own activations or a clip")
        if kind == "GRU" and not attributes.get("linear_before_reset", 0):
            raise Unsupported("GRU without linear_before_reset")
        arrays = [np.asarray(array, np.float64)[0] for array in (weight, state_weight)]
        rows, units = arrays[1].shape
        biases = np.zeros(2 * rows) if bias is None else np.asarray(bias, np.float64)[0]
        arrays += [biases[:rows], biases[rows:]]
        ours = [
            np.concatenate([np.split(array, rows // units)[gate] for gate in GATES[kind]])
            for array in arrays
        ]
        layer = Layer(ours[0], ours[2], "none", ours[1], ours[3])
        return with_layer(row(value), layer)

    return apply


def where(values: Sequence[Value], _: Attributes) -> Value:
    """A pixel that is no number replaced by a constant: policy.h5 does so, too."""
    condition, _, value = values
    if condition != "is not a number":
        raise Unsupported("Where")
    return value


def is_nan(_: Sequence[Value], __: Attributes) -> Value:
    """The condition of where()."""
    return "is not a number"


OPERATORS: dict[str, Callable[[Sequence[Value], Attributes], Value]] = {
    **{name: same for name in ("Identity", "Dropout", "Cast", "Squeeze", "Unsqueeze", "Expand")},
    **{name: affine(name) for name in ("Add", "Sub", "Mul", "Div")},
    "Gemm": gemm,
    "MatMul": matmul,
    "Tanh": activation("tanh"),
    "Relu": activation("relu"),
    "Elu": activation("elu"),
    "Sigmoid": sigmoid,
    "Clip": clip,
    "Concat": concat,
    "Slice": chosen,
    "Gather": gather,
    "Transpose": transpose,
    "Flatten": flatten,
    "Reshape": flatten,
    "Conv": convolution,
    "BatchNormalization": normalization,
    "GRU": recurrent("GRU"),
    "LSTM": recurrent("LSTM"),
    "Where": where,
    "IsNaN": is_nan,
}
