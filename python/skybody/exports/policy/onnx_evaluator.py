"""An exported ONNX policy, run by ONNX Runtime."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skybody import InputError

from .interface import BEFORE_THE_FIRST
from .onnx_graph import ACTION, COMMAND, MEMORY, NEXT, ROBOT
from .source import PolicySource


def session_of(path: Path) -> Any:
    """A session on one thread.

    Raises:
        InputError: ONNX Runtime is missing.
    """
    try:
        import onnxruntime
    except ModuleNotFoundError:
        raise InputError("--check needs `onnxruntime`: `pip install onnxruntime`") from None
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])


class OnnxEvaluator:
    """One robot's policy, or `rows` of them at once."""

    def __init__(self, source: PolicySource, path: Path, robot: int = 0, rows: int = 1) -> None:
        """Opens the model and begins an episode."""
        self._interface, self._robot, self._rows = source.interface, robot, rows
        self._size = sum(layer.memory for layer in source.policy.layers)
        self._session = session_of(path)
        self.command = np.empty((rows, len(source.interface.outputs)), np.float32)
        self.reset()

    def reset(self) -> None:
        """Begins an episode."""
        rows = self._rows
        self._states = {
            f"past_{s.name}": np.full((rows, s.count), BEFORE_THE_FIRST, np.float32)
            for s in self._interface.past_actions
        }
        if self._size:
            self._states[MEMORY] = np.zeros((rows, self._size), np.float32)

    def act_rows(self, values: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """Actions (rows, A) in [-1, 1] of inputs by name, each (rows, ...)."""
        feed = {**values, **self._states}
        if self._interface.ranges_differ:
            feed[ROBOT] = np.full(self._rows, self._robot, np.int64)
        names = [ACTION, COMMAND, *(name + NEXT for name in self._states)]
        action, self.command, *states = self._session.run(names, feed)
        self._states = dict(zip(self._states, states, strict=True))
        return np.asarray(action, np.float32)

    def act(self, values: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """Actions (A,) in [-1, 1] of inputs by name."""
        interface = self._interface
        shapes: dict[str, tuple[int, ...]] = {s.name: (s.count,) for s in interface.inputs}
        shapes |= {image.name: image.shape for image in interface.images}
        rows = {name: values[name].reshape(1, *shape) for name, shape in shapes.items()}
        action: NDArray[np.float32] = self.act_rows(rows)[0]
        return action
