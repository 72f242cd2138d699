"""Reads an ONNX policy as a policy of policy.h5.

The graph is walked from the actions back to the inputs; each operator extends a chain of layers.
At the end both are evaluated for random inputs, and a difference is an error.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import numpy_helper
from onnx.reference import ReferenceEvaluator

from skybody import CompiledScenario, InputError
from skybody._native import ObservationColumn
from skybody.train.policy_file import Policy

from ..policy.interface import PAST_ACTIONS, identifier
from .chain import Picture, Unmapped, Unsupported, observations
from .map_file import Map, places_of
from .operators import OPERATORS, Value, hidden, is_constant
from .to_policy import policy_of

ACTION_NAMES = ("action", "actions")
SAMPLES = 4  # inputs for which both are evaluated
LARGEST = 1e-4  # allowed difference of an action: float, of layers that were multiplied together


def read_onnx(path: Path, compiled: CompiledScenario, chosen: Map) -> Policy:
    """The policy of a file.

    Raises:
        InputError: it cannot be read, has layers that policy.h5 lacks, or inputs that are no
            observations.
    """
    try:
        model = onnx.load(path)
        onnx.checker.check_model(model)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except Exception as error:  # onnx raises errors of protobuf and its own, without a base
        first = str(error).strip().partition("\n")[0]
        raise InputError(f"{path}: is no ONNX file ({first or type(error).__name__})") from None
    try:
        reader = Reader(model.graph, compiled, chosen)
        policy = reader.policy()
        check_equal(model, policy, reader)
    except Unsupported as error:
        raise InputError(f"{path}: {error}") from None
    return policy


class Reader:
    """The walk through a graph."""

    def __init__(self, graph: onnx.GraphProto, compiled: CompiledScenario, chosen: Map) -> None:
        """Reads the constants, and maps the inputs."""
        self._compiled = compiled
        self._values: dict[str, Value] = {
            constant.name: numpy_helper.to_array(constant) for constant in graph.initializer
        }
        self._makers: dict[str, onnx.NodeProto] = {
            name: node for node in graph.node for name in node.output if name
        }
        self._graph = graph
        self.columns: list[ObservationColumn] = []  # of images
        self.inputs: dict[str, list[int] | ObservationColumn | None] = {}  # None: not mapped
        self._map_inputs(chosen)
        self.output = self._find_output(chosen)

    def policy(self) -> Policy:
        """The whole policy."""
        found = self._value(self.output)
        if isinstance(found, Picture):
            picture, found = found.features()
            self._pictures[picture.image] = picture
        if is_constant(found):
            raise Unsupported(f"`{self.output}` is a constant")
        return policy_of(hidden(found), self._pictures, self.columns, self._compiled)

    # --- inputs and outputs -----------------------------------------------------------------------

    def _map_inputs(self, chosen: Map) -> None:
        self._pictures: dict[int, Picture] = {}
        given = [i for i in self._graph.input if i.name not in self._values]
        names = {value.name for value in given}
        for name in chosen.inputs:
            if name not in names:
                there = ", ".join(sorted(names))
                raise InputError(f"{chosen.file}: the policy has no input `{name}`; it has {there}")
        for value in given:
            places = self._places(value, chosen, len(given))
            self.inputs[value.name] = places
            if isinstance(places, ObservationColumn):
                self._values[value.name] = self._picture(places, value)
            else:
                self._values[value.name] = (
                    Unmapped(value.name) if places is None else observations(places)
                )

    def _places(
        self, value: onnx.ValueInfoProto, chosen: Map, count: int
    ) -> list[int] | ObservationColumn | None:
        """Entries of the observation, or the image, that an input is."""
        if value.name in chosen.inputs:
            return places_of(chosen.inputs[value.name], self._compiled, chosen.file)
        for column in self._compiled.observation_columns:
            names = [identifier(column.name)]
            if PAST_ACTIONS.match(column.doc):
                names.append(f"past_{names[0]}")
            if not column.privileged and value.name in names:
                return column if column.image >= 0 else _entries(column)
        last = _last_extent(value)
        if count == 1 and last in (0, self._compiled.observation_size):
            return list(range(self._compiled.observation_size))
        return None

    def _picture(self, column: ObservationColumn, value: onnx.ValueInfoProto) -> Picture:
        height, width, channels = (*column.shape, 1)[:3]
        if not np.isfinite([column.low, column.high]).all():
            raise Unsupported(f"image `{column.name}` has no range")
        extents = [d.dim_value for d in value.type.tensor_type.shape.dim]
        axes = "NCHW" if extents[1:] == [channels, height, width] and channels != width else "NHWC"
        self.columns.append(column)
        span = column.high - column.low
        return Picture(
            len(self.columns) - 1,
            column.low,
            column.high,
            (),
            (height, width, channels),
            np.full(channels, span),
            np.full(channels, column.low),
            (height, width, channels),
            axes,
        )

    def _find_output(self, chosen: Map) -> str:
        names = [value.name for value in self._graph.output]
        if chosen.output:
            if chosen.output not in names:
                there = ", ".join(names)
                raise InputError(
                    f"{chosen.file}: the policy has no output `{chosen.output}`; it has {there}"
                )
            return chosen.output
        for name in (*ACTION_NAMES, names[0] if len(names) == 1 else ""):
            if name in names:
                return name
        size = self._compiled.action_size
        fitting = [value.name for value in self._graph.output if _last_extent(value) == size]
        if len(fitting) != 1:
            raise Unsupported(
                f"which of the outputs {', '.join(names)} has the {size} actions? Name it as "
                "`output` in --map FILE"
            )
        return str(fitting[0])

    # --- the walk ---------------------------------------------------------------------------------

    def _value(self, name: str) -> Value:
        """A tensor; those before it first, without recursion: graphs may be long."""
        waiting = [name]
        while waiting:
            current = waiting[-1]
            if not current or current in self._values:
                waiting.pop()
                continue
            if current not in self._makers:
                raise Unsupported(f"no node makes `{current}`")
            node = self._makers[current]
            missing = [i for i in node.input if i and i not in self._values]
            if missing:
                waiting += missing
                continue
            self._apply(node)
        return self._values[name]

    def _apply(self, node: onnx.NodeProto) -> None:
        """Computes a node's outputs."""
        attributes = {a.name: onnx.helper.get_attribute_value(a) for a in node.attribute}
        attributes = {k: v.decode() if isinstance(v, bytes) else v for k, v in attributes.items()}
        if node.op_type == "Constant":
            made: Value = numpy_helper.to_array(attributes["value"])
        else:
            if node.op_type not in OPERATORS:
                raise Unsupported(
                    f"operator {node.op_type} is not supported; allowed: {', '.join(OPERATORS)}"
                )
            values = [self._values[name] if name else None for name in node.input]
            if any(isinstance(v, Picture) and v.is_flat for v in values):
                values = [self._as_row(v, node.op_type) for v in values]
            try:
                made = OPERATORS[node.op_type](values, attributes)
            except (IndexError, TypeError, KeyError, ZeroDivisionError) as error:
                raise Unsupported(f"{node.op_type}: {error}") from None
        for name in node.output:
            if name:
                self._values[name] = made

    def _as_row(self, value: Value, operator: str) -> Value:
        """A flat image as features, except for the layer and the activation that follow it."""
        if not isinstance(value, Picture) or not value.is_flat:
            return value
        whole = value.layers[-1].activation == "none" and value.shape[:2] == (1, 1)
        extends = operator in ("Tanh", "Relu", "Elu", "Sigmoid") and whole
        is_first = operator in ("Gemm", "MatMul") and value.shape[:2] != (1, 1)
        is_affine = operator in ("Add", "Mul") and value.shape[:2] == (1, 1)
        if extends or is_first or is_affine or operator in ("Identity", "Dropout", "Reshape"):
            return value
        picture, features = value.features()
        self._pictures[picture.image] = picture
        return features


def _entries(column: ObservationColumn) -> list[int]:
    return list(range(column.first, column.first + column.shape[0]))


def _last_extent(value: onnx.ValueInfoProto) -> int:
    """The last extent of a tensor; 0: not known."""
    dims = value.type.tensor_type.shape.dim
    return int(dims[-1].dim_value) if dims else 0


def check_equal(model: onnx.ModelProto, policy: Policy, reader: Reader) -> None:
    """Evaluates both for random inputs. Raises Unsupported if actions differ."""
    random = np.random.default_rng(1)
    evaluator = ReferenceEvaluator(model)
    spread = np.where(policy.scale > 0.0, 1.0 / policy.scale, 1.0)
    for _ in range(SAMPLES):
        row = (policy.mean + random.normal(size=len(spread)) * spread).astype(np.float32)[None]
        images = [
            random.uniform(image.low, image.high, (1, *image.shape)).astype(column.dtype)
            for image, column in zip(policy.images, reader.columns, strict=True)
        ]
        feed: dict[str, Any] = {
            value.name: _feed(value, reader, row, images)
            for value in model.graph.input
            if value.name in reader.inputs
        }
        outputs: Any = evaluator.run([reader.output], feed)
        given = np.asarray(outputs[0], np.float64).reshape(1, -1)
        if not np.isfinite(given).all():
            raise Unsupported("its actions are not finite for ordinary observations; train it anew")
        expected = policy(row, None, images)
        difference = np.abs(np.clip(given, -1.0, 1.0) - expected).max()
        if not difference <= LARGEST:
            raise Unsupported(
                f"converted, an action differs by {difference:.2g}: this network cannot be flown"
            )


def _feed(
    value: onnx.ValueInfoProto,
    reader: Reader,
    row: NDArray[np.float32],
    images: list[NDArray[Any]],
) -> NDArray[Any]:
    """The value of an input: from the observation, or zero."""
    extents = [d.dim_value or 1 for d in value.type.tensor_type.shape.dim]
    dtype = onnx.helper.tensor_dtype_to_np_dtype(value.type.tensor_type.elem_type)
    places = reader.inputs[value.name]
    if places is None:
        return np.zeros(extents, dtype)
    if isinstance(places, ObservationColumn):
        names = [column.name for column in reader.columns]
        pixels = images[names.index(places.name)]
        is_first = extents[1:] == [pixels.shape[3], *pixels.shape[1:3]] != list(pixels.shape[1:])
        arranged = pixels.transpose(0, 3, 1, 2) if is_first else pixels
        return arranged.reshape(extents).astype(dtype)
    shape = [*extents[:-1], len(places)]
    return row[0, places].reshape(shape).astype(dtype)
