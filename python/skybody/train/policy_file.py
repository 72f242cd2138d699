"""policy.h5: a trained policy as plain numbers, read by `skybody run --policy` and by evaluate.py.

Root attributes say what it was trained on; /normalization and /layers/0, 1, ... hold the network.
docs/policies.md has the whole format. h5py is imported where it is needed: `--help` works without.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FORMAT = "skybody-policy"
VERSION = 1


@dataclass(frozen=True)
class Layer:
    """activation(weight x + bias)."""

    weight: NDArray[np.float32]  # (out, in)
    bias: NDArray[np.float32]  # (out)
    activation: str  # "tanh", "relu" or "none"


@dataclass(frozen=True)
class Policy:
    """The mean of a Gaussian policy: a multilayer perceptron on normalized observations."""

    layers: list[Layer]
    mean: NDArray[np.float64]  # (O) of observations
    scale: NDArray[np.float64]  # (O), 1 / deviation
    clip: float  # of normalized observations
    attributes: dict[str, Any] = field(default_factory=dict)

    def __call__(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Actions (n, A) in [-1, 1] for observations (n, O); float64 from float32 weights."""
        x = np.clip((observation - self.mean) * self.scale, -self.clip, self.clip)
        x = x.astype(np.float32).astype(np.float64)
        for layer in self.layers:
            x = x @ layer.weight.astype(np.float64).T + layer.bias
            if layer.activation == "tanh":
                x = np.tanh(x)
            elif layer.activation == "relu":
                x = np.maximum(x, 0.0)
        return np.clip(x, -1.0, 1.0)


def write_policy(path: Path, policy: Policy) -> None:
    """Writes `policy` with its attributes to a new HDF5 file."""
    sizes = {
        "observation_size": policy.layers[0].weight.shape[1],
        "action_size": policy.layers[-1].weight.shape[0],
    }
    import h5py  # type: ignore[import-untyped]

    with h5py.File(path, "w") as file:
        stamp = {"format": FORMAT, "version": VERSION, "action_squash": "clip"}
        file.attrs.update({**policy.attributes, **sizes, **stamp})
        normalization = file.create_group("normalization")
        _put(normalization, "mean", policy.mean)
        _put(normalization, "scale", policy.scale)
        normalization.attrs["clip"] = policy.clip
        for k, layer in enumerate(policy.layers):
            group = file.create_group(f"layers/{k}")
            _put(group, "weight", layer.weight)
            _put(group, "bias", layer.bias)
            group.attrs["activation"] = layer.activation


def _put(group: Any, name: str, values: NDArray[Any]) -> None:
    """With a checksum that HDF5 checks whenever the values are read, by `skybody run` as well."""
    group.create_dataset(name, data=values, fletcher32=True)


def read_policy(path: Path) -> Policy:
    """Reads what write_policy() wrote. Raises ValueError for another format or version."""
    import h5py

    with h5py.File(path, "r") as file:
        found = (file.attrs.get("format"), int(file.attrs.get("version", 0)))
        if found != (FORMAT, VERSION):
            raise ValueError(f"{path}: format {found}, expected {(FORMAT, VERSION)}")
        if (squash := file.attrs.get("action_squash")) != "clip":
            raise ValueError(f"{path}: action_squash {squash}; the learners write `clip` only")
        layers = [
            Layer(group["weight"][()], group["bias"][()], str(group.attrs["activation"]))
            for group in (file[f"layers/{k}"] for k in range(len(file["layers"])))
        ]
        normalization = file["normalization"]
        return Policy(
            layers,
            normalization["mean"][()],
            normalization["scale"][()],
            float(normalization.attrs["clip"]),
            dict(file.attrs),
        )
