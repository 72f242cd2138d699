"""A whole update of fast-ppo against PyTorch: loss, gradient, norm and Adam, step by step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from skybody import _native
from skybody._native import CompiledScenario, PpoSlices
from skybody.train.hyperparameters import with_settings
from skybody.train.native_learners import FastPpo
from skybody.train.presets import preset
from test_networks import torch_dense

torch = pytest.importorskip("torch")

TOTAL = 100_000


@dataclass
class Step:
    """Arguments that slices received before a gradient step."""

    policy: np.ndarray
    value: np.ndarray
    index: int
    wants: tuple[bool, bool]
    mean: float
    scale: float
    order: list[np.ndarray]  # of each slice's rows


class Watched:
    """All slices in this process; records their arguments and training data."""

    def __init__(self, compiled: CompiledScenario, hyper: Any) -> None:
        self.held = PpoSlices(compiled, vars(hyper), 1, TOTAL, 0, 8)
        self.steps: list[Step] = []
        self.rollout: list[Any] = []

    def find_gradients(self, *told: Any) -> Any:
        given = self.held.find_gradients(*told)
        self.rollout = self.held.rollout()
        policy, value, _, index, wants_policy, wants_value, mean, scale = told
        order = [part["order"] for part in self.rollout]
        parameters = np.array(policy), np.array(value)
        self.steps.append(Step(*parameters, index, (wants_policy, wants_value), mean, scale, order))
        return given

    def __getattr__(self, method: str) -> Any:
        return getattr(self.held, method)


class Oracle:
    """The same networks and steps in PyTorch, in double."""

    def __init__(self, hyper: Any, first: Step, sizes: tuple[int, int], minibatches: int) -> None:
        self.hyper, self.minibatches = hyper, minibatches
        shape = (list(hyper.hidden), hyper.activation)
        self.natives = [
            _native.Network(sizes[0], shape[0], outputs, shape[1]) for outputs in (sizes[1], 1)
        ]
        self.policy, self.value = (
            torch_dense(native.layers(parameters[: self.count(native)]), torch.float64)
            for native, parameters in zip(self.natives, (first.policy, first.value), strict=True)
        )
        at = self.count(self.natives[0])
        logs = torch.from_numpy(first.policy[at : at + sizes[1]].astype(np.float64))
        self.log_std = torch.nn.Parameter(logs)
        rate = hyper.learning_rate
        self.adam = [
            torch.optim.Adam([*self.policy.parameters(), self.log_std], rate, eps=1e-5),
            torch.optim.Adam(self.value.parameters(), rate, eps=1e-5),
        ]

    @staticmethod
    def count(native: Any) -> int:
        return len(native.initial_parameters(1.0, 0))

    def rows(self, rollout: list[Any], step: Step) -> dict[str, Any]:
        """The minibatch: its share of each slice's order."""
        parts: dict[str, list[np.ndarray]] = {}
        for slice_, order in zip(rollout, step.order, strict=True):
            cuts = [len(order) * k // self.minibatches for k in (step.index, step.index + 1)]
            for name, values in slice_.items():
                if name != "order":
                    parts.setdefault(name, []).append(values[order[cuts[0] : cuts[1]]])
        return {n: torch.from_numpy(np.concatenate(p).astype(np.float64)) for n, p in parts.items()}

    def take(self, rollout: list[Any], step: Step) -> None:
        rows = self.rows(rollout, step)
        losses = [
            self.policy_loss(rows, step) if step.wants[0] else None,
            self.value_loss(rows) if step.wants[1] else None,
        ]
        for loss, adam in zip(losses, self.adam, strict=True):
            if loss is None:
                continue
            adam.zero_grad()
            loss.backward()
            parameters = adam.param_groups[0]["params"]
            torch.nn.utils.clip_grad_norm_(parameters, self.hyper.max_grad_norm)
            adam.step()

    def policy_loss(self, rows: dict[str, Any], step: Step) -> Any:
        mean = self.policy(rows["inputs"])
        if self.hyper.bounded_mean:
            mean = torch.tanh(mean)
        normal = torch.distributions.Normal(mean, self.log_std.exp())
        constant = 0.5 * math.log(2 * math.pi) * mean.shape[1]
        now = normal.log_prob(rows["action"]).sum(1) + constant
        ratio = (now - rows["log_probability"][:, 0]).exp()
        advantage = (rows["advantage"][:, 0] - step.mean) * step.scale
        bound = self.hyper.clip_range
        clipped = ratio.clamp(1 - bound, 1 + bound)
        surrogate = torch.minimum(ratio * advantage, clipped * advantage).mean()
        return -surrogate - self.hyper.entropy_weight * normal.entropy().sum(1).mean()

    def value_loss(self, rows: dict[str, Any]) -> Any:
        errors = self.value(rows["inputs"])[:, 0] - rows["value_target"][:, 0]
        return self.hyper.value_weight * errors.square().mean()

    def check(self, step: Step) -> None:
        """Float parameters after some dozen steps of 1e-3 each differ by round-off."""
        at = self.count(self.natives[0])
        for native, ours, theirs in (
            (self.natives[0], step.policy[:at], self.policy),
            (self.natives[1], step.value[: self.count(self.natives[1])], self.value),
        ):
            flat = [p.detach().numpy() for p in theirs.parameters()]
            layers = [part for layer in native.layers(ours) for part in layer[:2]]
            for one, other in zip(layers, flat, strict=True):
                np.testing.assert_allclose(one, other, atol=1e-5)
        logs = step.policy[at : at + len(self.log_std)]
        np.testing.assert_allclose(logs, self.log_std.detach().numpy(), atol=1e-5)


@pytest.mark.parametrize(
    "settings",
    [
        ["bounded_mean=true", "epochs=2", "value_epochs=3"],
        ["bounded_mean=false", "entropy_weight=0.01", "epochs=3", "activation=elu"],
    ],
    ids=["bounded", "free"],
)
def test_an_update_is_that_of_pytorch(settings: list[str]) -> None:
    compiled = CompiledScenario("hover_learn", ["stepping.horizon=30"])
    # Constant learning rate and a learned noise without a schedule: no hyper-parameter changes
    # between the steps.
    common = ["envs=20", "rollout_steps=16", "minibatch=64", "hidden=24,16"]
    common += ["final_learning_rate=1", "final_log_std=0", "normalize_rewards=true"]
    hyper = with_settings(preset("hover_learn", "fast-ppo").hyper, [*common, *settings])
    watched = Watched(compiled, hyper)
    learner = FastPpo(compiled, hyper, 1, 1, TOTAL, watched)
    learner.iterate()
    steps = watched.steps
    assert len(steps) == 5 * max(hyper.epochs, hyper.value_epochs)  # of 320 rows
    oracle = Oracle(hyper, steps[0], (22, 4), 5)
    policy_steps = 0
    for now, after in pairwise(steps):
        oracle.take(watched.rollout, now)
        oracle.check(after)
        policy_steps += now.wants[0]
    assert policy_steps > 5
