"""Stable-Baselines3's policy, with rollouts computed by the engine's networks.

PyTorch's calls on small networks cost more than their products: 128 us for a step of 64
environments. The policy's form, sampling and training are those of Stable-Baselines3;
numbers agree to single precision.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.type_aliases import Schedule

from skybody._native import Network


class Inference:
    """A copy of dense tanh layers in the engine's order of parameters."""

    def __init__(self, layers: list[torch.nn.Linear]) -> None:
        self._layers = layers
        hidden = [layer.out_features for layer in layers[:-1]]
        self._network = Network(layers[0].in_features, hidden, layers[-1].out_features)
        count = self._network.parameter_count
        self._parameters = np.zeros(count, np.float32)
        # Layers filled with 0, 1, 2, ... give the index of each weight.
        places = self._network.layers(np.arange(count, dtype=np.float32))
        self._places = [
            (weight.astype(np.int64), bias.astype(np.int64)) for weight, bias, *_ in places
        ]

    def update(self) -> None:
        """Copies the current weights."""
        for layer, (weight, bias) in zip(self._layers, self._places, strict=True):
            self._parameters[weight] = layer.weight.detach().numpy()
            self._parameters[bias] = layer.bias.detach().numpy()

    def __call__(self, rows: NDArray[np.float32]) -> NDArray[np.float32]:
        """The last layer's outputs (n, outputs) of rows (n, inputs)."""
        outputs: NDArray[np.float32] = self._network.forward(self._parameters, rows)
        return outputs


class NoDistribution(ArithmeticError):
    """The actions' mean or deviation is not finite, or the deviation is 0."""


class QuickPolicy(ActorCriticPolicy):
    """Two networks of tanh layers and a diagonal Gaussian.

    Args:
        bounded_mean: applies tanh to the actions' mean.
        others: arguments of ActorCriticPolicy.
    """

    def __init__(self, *others: Any, bounded_mean: bool = False, **named: Any) -> None:
        self._bounded_mean = bounded_mean
        super().__init__(*others, **named)
        extractor = self.mlp_extractor
        self._actor = Inference([*linear(extractor.policy_net), *linear([self.action_net])])
        self._critic = Inference([*linear(extractor.value_net), *linear([self.value_net])])

    def _build(self, lr_schedule: Schedule) -> None:
        super()._build(lr_schedule)
        if self._bounded_mean:
            self.action_net = torch.nn.Sequential(self.action_net, torch.nn.Tanh())

    def begin_rollout(self) -> None:
        """Call this after weights have changed, before forward()."""
        self._actor.update()
        self._critic.update()

    def forward(
        self, obs: Any, deterministic: bool = False
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Actions, values and log-probabilities of a step of a rollout, without gradients.

        The noise equals that of `DiagGaussianDistribution`: PyTorch's generator, in the same order.

        Raises NoDistribution.
        """
        rows = obs.numpy()
        mean = self._actor(rows)
        if self._bounded_mean:
            mean = np.tanh(mean)
        if not np.isfinite(mean).all():
            raise NoDistribution
        noise = np.zeros_like(mean)
        if not deterministic:
            noise = torch.normal(torch.zeros(mean.shape), torch.ones(mean.shape)).numpy()
        log_std = self.log_std.detach().numpy()
        log_scale = log_std.sum() + 0.5 * log_std.size * math.log(2.0 * math.pi)
        log_probability = (-0.5 * (noise * noise).sum(axis=1) - log_scale).astype(np.float32)
        return (
            torch.from_numpy(mean + noise * np.exp(log_std)),
            torch.from_numpy(self._critic(rows)),
            torch.from_numpy(log_probability),
        )

    def evaluate_actions(
        self, obs: Any, actions: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor | None]:
        """As in the base class. Raises NoDistribution where PyTorch's Normal raises ValueError."""
        try:
            return super().evaluate_actions(obs, actions)
        except ValueError as error:
            raise NoDistribution from error


def linear(modules: Iterable[torch.nn.Module]) -> list[torch.nn.Linear]:
    """The linear layers, including those within a Sequential."""
    found: list[torch.nn.Linear] = []
    for module in modules:
        inner = module if isinstance(module, torch.nn.Sequential) else [module]
        found += [layer for layer in inner if isinstance(layer, torch.nn.Linear)]
    return found
