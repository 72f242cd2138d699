"""Expected behaviour of environments, written by hand over `Simulation`, one world at a time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skybody._native import CompiledScenario, Simulation

SEED = 7
STEPS = 120


def short_hover(*more: str) -> CompiledScenario:
    """Hover with episodes of at most 40 steps, many of which end earlier, by tilting."""
    overrides = [
        "stepping.action_repeat=10",
        "stepping.horizon=40",
        "task.parameters.tilt_max=0.4",
        *more,
    ]
    return CompiledScenario("hover", overrides)


def actions(step: int, num_envs: int, size: int = 4) -> NDArray[np.float32]:
    """Actions about hover thrust; they depend on step and environment only. Odd ones tilt soon."""
    env, k = np.mgrid[0:num_envs, 0:size]
    steady = 0.21 + 0.03 * (env % 2) * ((k % 2) * 2 - 1) * (k < 2)
    return (steady + 0.01 * np.sin(0.7 * step + env + 2 * k)).astype(np.float32)


@dataclass
class Row:
    """One transition, and the reset after it if the episode ended."""

    observation: NDArray[np.float32]
    reward: float
    terminated: bool
    truncated: bool
    first_of_next: NDArray[np.float32] | None


class Rollout:
    """One environment, reset as soon as its episode has ended."""

    def __init__(self, compiled: CompiledScenario, env: int, seed: int = SEED) -> None:
        self.simulation = Simulation(compiled, seed=seed, env_id=env)
        self.simulation.reset()
        self.first = self.simulation.observation.copy()

    def step(self, action: NDArray[np.float32]) -> Row:
        simulation = self.simulation
        simulation.step(action)
        row = Row(
            simulation.observation.copy(),
            simulation.reward,
            simulation.terminated,
            simulation.truncated,
            None,
        )
        if row.terminated or row.truncated:
            simulation.reset()
            row.first_of_next = simulation.observation.copy()
        return row
