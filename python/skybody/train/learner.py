"""What the trainer asks of a learner, whichever it is."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from skybody.train.policy_file import Layer, Policy

if TYPE_CHECKING:
    import torch

    from skybody._native import Channel

# Names under which tasks give the distance from their goal [m], in the order of preference.
POSITION_ERRORS = ("position_error", "payload_error", "formation_error")


@dataclass
class Report:
    """One rollout and its update."""

    episode_returns: list[float] = field(default_factory=list)  # of episodes that ended
    position_error: float = math.nan  # [m], mean over the rollout; nan: the task does not say
    faults: int = 0  # transitions that faulted
    environment_seconds: float = 0.0  # waiting for environments
    inference_seconds: float = 0.0  # the rest of the rollout
    update_seconds: float = 0.0
    losses: dict[str, float] = field(default_factory=dict)


class Learner(Protocol):
    """Alternates rollouts and updates; everything but its construction is resumable."""

    @property
    def steps(self) -> int:
        """Environment steps so far, over all environments."""

    def iterate(self) -> Report:
        """One rollout and its update."""

    def parameters(self) -> dict[str, torch.Tensor]:
        """All trained parameters by name."""

    def policy(self) -> Policy:
        """The deterministic policy as of now."""

    def state(self) -> dict[str, Any]:
        """Everything but the environments, as tensors and plain values."""

    def environments(self) -> bytes:
        """Everything of the environments."""

    def restore(self, state: dict[str, Any], environments: bytes) -> None:
        """Goes on from where state() and environments() were taken."""

    def close(self) -> None:
        """Ends the environments."""


def check_finite(name: str, learner: Learner) -> None:
    """Raises FloatingPointError where a parameter is no number any more."""
    for parameter, value in learner.parameters().items():
        if not bool(value.isfinite().all()):
            raise FloatingPointError(
                f"{name} diverged: {parameter} is not finite after {learner.steps} steps; "
                "try a smaller learning_rate (--set learning_rate=...)"
            )


def layers_of(network: torch.nn.Sequential) -> list[Layer]:
    """Linear and tanh modules in turn, as layers of a policy file."""
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


def position_error_columns(channels: Iterable[Channel]) -> slice | None:
    """Where a row of info or observations has its distance from the goal; None: nowhere."""
    places = {c.name: slice(c.first, c.first + c.count) for c in channels}
    return next((places[name] for name in POSITION_ERRORS if name in places), None)
