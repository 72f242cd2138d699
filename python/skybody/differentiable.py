"""Environments whose transitions have derivatives, for gradients through the dynamics."""

from __future__ import annotations

from typing import Never

import numpy as np
from numpy.typing import NDArray

from . import _native, options
from .arguments import MOST_ENVS, Scenario, check_seed, integer, integer_within, load
from .options import refuse_unknown

_TERMINATED, _TRUNCATED = 1, 2  # bits of the status
_MOST_STEPS = 1_000_000

Floats = NDArray[np.float32]
Flags = NDArray[np.bool_]


class DifferentiableEnv(_native.DifferentiableEnv):
    """Environments that record their transitions, and go back through them by `pull_back`.

    They give the gradient of any sum over observations and rewards by all actions: the derivative
    of the engine's own steps, without contact (docs/python.md has all limits). N environments, A
    values of an action, O of an observation. All calls run on the caller's thread, 32 environments
    at once in vector lanes; one Python thread at a time.

    An environment whose episode has ended stands still until `reset`: its observation repeats, its
    reward is 0, and its actions have no effect.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `CompiledScenario`.
        num_envs: N; multiples of 32 use the processor best.
        steps: 1 to 10^6. The record has the state before each of their physics steps, in groups of
            32 environments: 22 MB for `hover_learn`, 50 steps of 20 physics steps.
        overrides and the other keywords: see `skybody.options`.

    Raises:
        skybody.InputError: a mistake in the scenario, or a plugin without derivatives, with its
            name, file:line:column and the remedy.
        skybody.Error: the integrator or the dynamics have no derivatives.
        ValueError: a number out of range.
    """

    def __init__(
        self,
        scenario: Scenario,
        num_envs: int = 1,
        *,
        steps: options.Steps = 50,
        overrides: options.Overrides = (),
        plugin_path: options.PluginPath = (),
        seed: options.Seed = 0,
        **unknown: Never,
    ) -> None:
        refuse_unknown(DifferentiableEnv, unknown)
        super().__init__(
            load(scenario, overrides, plugin_path),
            integer_within("num_envs", num_envs, 1, MOST_ENVS),
            integer_within("steps", steps, 1, _MOST_STEPS),
            check_seed(seed) or 0,
        )

    def reset(self, seed: int | None = None) -> Floats:
        """Begins the next episode of all environments, and empties the record.

        Args:
            seed: begins episode 1 under this key instead.

        Returns:
            observations (N, O).
        """
        return super().reset(check_seed(seed))

    def step(  # type: ignore[override]
        self, actions: Floats
    ) -> tuple[Floats, Floats, Flags, Flags]:
        """One recorded transition of all environments.

        Args:
            actions: (N, A) float32 in [-1, 1] (clipped; a clipped value has the derivative 0).

        Returns:
            observations (N, O), rewards (N,), and whether the episode has been terminated by the
            task (N,) or truncated by the horizon, the task or a fault (N,), all new arrays.

        Raises:
            TypeError: another dtype.
            ValueError: another shape.
            skybody.Error: before `reset`, or after `steps` transitions.
        """
        observations, rewards, status = super().step(actions)
        has = [(status & np.uint64(bit)) != 0 for bit in (_TERMINATED, _TRUNCATED)]
        return observations, rewards, has[0], has[1]

    def pull_back(
        self,
        transition: int,
        d_observation: Floats | None = None,
        d_reward: Floats | None = None,
        d_state: NDArray[np.float64] | None = None,
    ) -> tuple[Floats, NDArray[np.float64]]:
        """Derivatives of a sum by the action of one transition and by the state before it.

        Go from the last transition to the first one, and hand each `d_state` on to the next call.

        Args:
            transition: its number, the value of `transition` before its `step`.
            d_observation: (N, O) float32, derivatives of the sum by its observations; None: 0.
            d_reward: (N,) float32, by its rewards; None: 0.
            d_state: (N, state_size) float64, by the state after it: the result of the call for the
                next transition; None: 0, no later transition counts.

        Returns:
            d_action (N, A) float32, and d_state (N, state_size) float64, by the state before it.
            Both are 0 in environments that did not fly or that a fault ended in this transition.

        Raises:
            TypeError: another dtype.
            ValueError: another shape.
            skybody.Error: the transition is before the last `reset`, or not made yet.
        """
        n, width = self.num_envs, self.compiled.observation_size
        return super().pull_back(
            integer("transition", transition),
            np.zeros((n, width), np.float32) if d_observation is None else d_observation,
            np.zeros(n, np.float32) if d_reward is None else d_reward,
            np.zeros((n, self.state_size)) if d_state is None else d_state,
        )
