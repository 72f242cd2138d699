"""Evaluates a trained policy by the format of docs/policies.md, in NumPy alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
ACTIVATIONS = {
    "tanh": np.tanh,
    "relu": lambda x: np.maximum(x, 0.0),
    "elu": lambda x: np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0))),
    "none": lambda x: x,
}


class Network:
    """Dense layers behind a normalization. `arrays` is made by arrays_of()."""

    def __init__(self, arrays: Mapping[str, Any]) -> None:
        self.mean, self.scale = arrays["mean"], arrays["scale"]
        self.clip = float(arrays["clip"])
        names = [str(name) for name in arrays["activations"]]
        self.layers = [
            (arrays[f"weight{k}"].T, arrays[f"bias{k}"], ACTIVATIONS[name])
            for k, name in enumerate(names)
        ]

    def __call__(self, rows: Reals) -> Reals:
        """Actions in [-1, 1] of observations (N, O)."""
        x = np.clip((rows - self.mean) * self.scale, -self.clip, self.clip)
        for weight, bias, activation in self.layers:
            x = activation(x @ weight + bias)
        return np.clip(x, -1.0, 1.0)


def arrays_of(policy: Path) -> dict[str, Any]:
    """The arrays of a policy.h5 without images and memory, to be saved as NPZ."""
    import h5py  # not in the environments of other simulators

    with h5py.File(policy) as file:
        normalization = file["normalization"]
        arrays = {name: normalization[name][:].astype(float) for name in ("mean", "scale")}
        arrays["clip"] = float(normalization.attrs["clip"])
        layers = [file[f"layers/{k}"] for k in range(len(file["layers"]))]
        arrays["activations"] = [layer.attrs["activation"].decode() for layer in layers]
        for k, layer in enumerate(layers):
            arrays |= {f"{name}{k}": layer[name][:].astype(float) for name in ("weight", "bias")}
    return arrays
