"""The interface between the trainer and all learners."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skybody._native import position_errors
from skybody.train.policy_file import Layer, Policy

if TYPE_CHECKING:
    import torch

    from skybody._native import Channel


@dataclass
class Report:
    """One rollout and its update."""

    episode_returns: list[float] = field(default_factory=list)  # of episodes that ended
    position_error: float = math.nan  # [m], mean over the rollout; nan: the task does not report it
    faults: int = 0  # number of transitions that faulted
    environment_seconds: float = 0.0  # waiting time for environments
    inference_seconds: float = 0.0  # the rest of the rollout
    update_seconds: float = 0.0
    losses: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Saved:
    """State of a learner between two iterations; arrays may be views, valid until the next one."""

    parameters: Mapping[str, torch.Tensor | NDArray[Any]]  # as in parameters()
    state: dict[str, Any]  # the state except the environments, as tensors and plain values
    environments: bytes  # the complete state of the environments


class Learner(Protocol):
    """Alternates rollouts and updates; its complete state can be saved and restored."""

    @property
    def steps(self) -> int:
        """Environment steps so far, over all environments."""

    def iterate(self) -> Report:
        """Makes one rollout and its update."""

    def parameters(self) -> Mapping[str, torch.Tensor | NDArray[Any]]:
        """All trained parameters by name."""

    def policy(self) -> Policy:
        """The current deterministic policy."""

    def save(self) -> Saved:
        """The learner's state for a checkpoint, and the parameters."""

    def restore(self, state: dict[str, Any], environments: bytes) -> None:
        """Continues from a state of save().

        If it raises, the learner is unchanged.
        """

    def close(self) -> None:
        """Closes the environments."""


def check_finite(name: str, parameters: Mapping[str, torch.Tensor], steps: int) -> None:
    """Raises FloatingPointError if a parameter is not finite after so many steps."""
    for parameter, value in parameters.items():
        if not bool(value.isfinite().all()):
            raise diverged(name, parameter, steps)


def diverged(name: str, what: str, steps: int) -> FloatingPointError:
    """The error of a learner with a number that is not finite after so many steps."""
    return FloatingPointError(
        f"{name} diverged: {what} is not finite after {steps} steps; "
        "try a smaller learning_rate (--set learning_rate=...)"
    )


def layers_of(network: torch.nn.Sequential) -> list[Layer]:
    """Alternating linear and tanh modules, as layers of a policy file."""
    import torch

    modules = list(network)
    layers = []
    for k, module in enumerate(modules):
        if not isinstance(module, torch.nn.Linear):
            continue
        tanh = k + 1 < len(modules) and isinstance(modules[k + 1], torch.nn.Tanh)
        weight = module.weight.detach().numpy().copy()
        bias = module.bias.detach().numpy().copy()
        layers.append(Layer(weight, bias, "tanh" if tanh else "none"))
    return layers


def columns_of(
    channels: Iterable[Channel], rows: NDArray[np.float32]
) -> dict[str, NDArray[np.float32]]:
    """The values of each channel, (n, count): views of `rows`, which are infos or observations."""
    return {c.name: rows[:, c.first : c.first + c.count] for c in channels}


def goal_distance(values: Mapping[str, NDArray[np.float32]]) -> NDArray[np.float64] | None:
    """Distance of each row from its goal [m], (n,); None if `values` do not contain it."""
    name = next((name for name in position_errors() if name in values), None)
    if name is None:
        return None
    error = values[name].reshape(len(values[name]), -1).astype(np.float64)
    distance: NDArray[np.float64] = np.sqrt(np.einsum("ij,ij->i", error, error))
    return distance
