"""The C++ learners `fast-ppo` and `gradient` (learn/) behind the interface of the trainer."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from skybody._native import CompiledScenario, Diverged, Gradient, Ppo
from skybody.train.hyperparameters import Hyperparameters
from skybody.train.learner import Report, Saved
from skybody.train.policy_file import Layer, Policy, policy_of_values

if TYPE_CHECKING:
    import torch
    from numpy.typing import NDArray

TRAINED_SHARE = 0.5  # share of the steps after which contact is checked in `gradient`
FEWEST_ROLLOUTS = 10  # rollouts before the warning
MOST_TOUCHING = 0.05  # share of flights in contact without a warning
PARAMETERS = ("policy", "value")  # blocks of the state; `gradient` has only the first


class NativeLearner:
    """For its methods see learner.Learner. The number of threads changes no bits."""

    _kind: type[Ppo | Gradient]

    def __init__(
        self,
        compiled: CompiledScenario,
        hyper: Hyperparameters,
        seed: int,
        threads: int,
        total_steps: int,
        *slices: object,
    ) -> None:
        self._native = self._kind(compiled, vars(hyper), seed, total_steps, threads, *slices)

    @property
    def steps(self) -> int:
        return self._native.steps

    @property
    def native_hash(self) -> int:
        """Hash of all parameters, as printed by the program `skybody train`."""
        return self._native.parameter_hash

    def iterate(self) -> Report:
        try:
            report = self._native.iterate()
        except Diverged as error:
            raise FloatingPointError(str(error)) from error
        del report["steps"]
        report["episode_returns"] = report["episode_returns"].tolist()
        return Report(**report)

    def parameters(self) -> Mapping[str, torch.Tensor | NDArray[np.int64]]:
        """Bits of the parameters, (words,) int64, two floats per word."""
        return self.save().parameters

    def policy(self) -> Policy:
        policy = policy_of_values(self._native.policy())
        layers = [Layer(*map(_single, dataclasses.astuple(layer))) for layer in policy.layers]
        return dataclasses.replace(policy, layers=layers)

    def save(self) -> Saved:
        blocks, environments = self._native.save()
        state = {name: words.view(np.int64) for name, words in blocks.items()}
        parameters = {name: state[name] for name in PARAMETERS if name in state}
        return Saved(parameters, state, environments.tobytes())

    def restore(self, state: dict[str, Any], environments: bytes) -> None:
        blocks = {name: words.view(np.uint64) for name, words in state.items()}
        self._native.restore((blocks, np.frombuffer(environments, np.uint64)))

    def close(self) -> None:
        """Does nothing: the environments run only during an iteration."""


class FastPpo(NativeLearner):
    """Proximal policy optimisation. `slices`: None, or the object that holds them, as in
    `skybody.ray.slices`.
    """

    _kind = Ppo


class GradientLearner(NativeLearner):
    """Learning through the dynamics."""

    _kind = Gradient

    def __init__(
        self,
        compiled: CompiledScenario,
        hyper: Hyperparameters,
        seed: int,
        threads: int,
        total_steps: int,
    ) -> None:
        super().__init__(compiled, hyper, seed, threads, total_steps)
        self._listens_from = TRAINED_SHARE * total_steps
        self._touching: list[float] | None = []  # shares since then; None: warning printed

    def iterate(self) -> Report:
        report = super().iterate()
        if self._touching is not None and self.steps >= self._listens_from:
            self._touching.append(report.losses["touching_share"])
            self._warn_of_contact(self._touching)
        return report

    def _warn_of_contact(self, shares: list[float]) -> None:
        """Warns once, if flights of a trained policy touch something."""
        if len(shares) < FEWEST_ROLLOUTS:
            return
        share = sum(shares) / len(shares)
        if share > MOST_TOUCHING:
            print(
                f"warning: {100 * share:.0f} % of the flights that `gradient` learns from "
                "touch something, and its derivatives leave contact out; see docs/training.md, or "
                "take --algo fast-ppo",
                file=sys.stderr,
            )
            self._touching = None


def _single(value: Any) -> Any:
    """Converts weights from doubles, as the policy has them, to floats."""
    return value.astype(np.float32) if isinstance(value, np.ndarray) else value
