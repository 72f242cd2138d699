"""The average of a policy over its last updates: it varies less than single updates.

Near its end a run moves randomly about a good policy, by more than its last centimetres. The mean
of its weights over that walk lies closer to the middle (Polyak and Juditsky 1992). Only the policy
that is evaluated and flown is averaged; training continues with its own weights.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skybody.train.policy_file import Policy

if TYPE_CHECKING:
    import torch


class PolicyAverage:
    """Exponential mean of weights and biases, in float64."""

    def __init__(self, window: int) -> None:
        """`window`: approximate length of the mean, in steps of all environments; 0: no mean."""
        self.window = window
        self.count = 0
        self.values: list[NDArray[np.float64]] = []

    def add(self, policy: Policy, steps: int) -> None:
        """Adds the policy, `steps` steps after the last one."""
        if self.window == 0:
            return
        values = _values(policy)
        self.count += 1
        share = max(1.0 / self.count, min(1.0, steps / self.window))
        if self.count == 1:
            self.values = values
        else:
            for mean, value in zip(self.values, values, strict=True):
                mean += share * (value - mean)

    def of(self, policy: Policy) -> Policy:
        """`policy` with the averaged weights; `policy` itself if there is no mean."""
        if not self.values:
            return policy
        means = iter([value.astype(np.float32) for value in self.values])
        layers = [replace(layer, weight=next(means), bias=next(means)) for layer in policy.layers]
        return replace(policy, layers=layers)

    def state(self) -> dict[str, Any]:
        """The complete state, as tensors and plain values."""
        if not self.values:
            return {"count": self.count, "values": []}
        import torch

        values = [torch.from_numpy(value.copy()) for value in self.values]
        return {"count": self.count, "values": values}

    def restore(self, state: dict[str, Any], policy: Policy) -> None:
        """The inverse of state(). Raises ValueError unless it is a mean of similar policies."""
        tensors: list[torch.Tensor] = state["values"]
        values = [tensor.numpy().copy() for tensor in tensors]
        if values and [v.shape for v in values] != [v.shape for v in _values(policy)]:
            raise ValueError("the averaged weights are of another network")
        self.count, self.values = int(state["count"]), values


def _values(policy: Policy) -> list[NDArray[np.float64]]:
    return [
        array.astype(np.float64) for layer in policy.layers for array in (layer.weight, layer.bias)
    ]
