"""Environments for RLlib's new API stack: one pool per runner, stepped in C++.

    from ray.rllib.algorithms.ppo import PPOConfig
    from skybody.ray import rllib

    config = rllib.environments(PPOConfig(), "hover_learn", envs=64)

`examples/rllib_ppo.py` is a complete program.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from skybody.arguments import Scenario
from skybody.env import SkybodyEnv
from skybody.vector import SkybodyVectorEnv

NAME = "skybody"  # of the environment in RLlib's registry


class RllibVectorEnv(SkybodyVectorEnv):
    """A `SkybodyVectorEnv` for RLlib: the first action after an episode's end resets.

    RLlib has two ends of an episode, termination and truncation, and bootstraps the value of the
    last observation of a truncated one. Nothing may be learned from the observation after a fault,
    so a fault is a termination here.
    """

    def __init__(self, scenario: Scenario, num_envs: int, **options: Any) -> None:
        super().__init__(scenario, num_envs, autoreset="next_step", **options)

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Any, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        observations, rewards, terminated, truncated, infos = super().step(
            np.asarray(actions, np.float32)
        )
        fault = infos["fault"]
        return observations, rewards, terminated | fault, truncated & ~fault, infos


class RllibEnv(SkybodyEnv):
    """One environment, for RLlib's evaluation outside of runners; faults as above."""

    def step(self, action: NDArray[np.float32]) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        observation, reward, terminated, truncated, info = super().step(
            np.asarray(action, np.float32)
        )
        fault = bool(info["fault"])
        return observation, reward, terminated or fault, truncated and not fault, info


def make_env(context: Any) -> RllibVectorEnv | RllibEnv:
    """The environment function of RLlib, called in each runner with `env_config`: `scenario`, and
    options of `SkybodyVectorEnv`; RLlib adds `num_envs` for a vector environment.
    """
    options = dict(context)
    if "num_envs" in options:
        return RllibVectorEnv(**options)
    for name in ("num_threads", "infos"):
        options.pop(name, None)
    return RllibEnv(**options)


def environments(
    config: Any, scenario: str, envs: int, threads: int = 1, runners: int = 0, **options: Any
) -> Any:
    """Sets our environments in the configuration of an algorithm.

    Args:
        config: an `AlgorithmConfig` of RLlib's new API stack, such as `PPOConfig()`.
        scenario: name of a shipped scenario, or a YAML file that all machines can read.
        envs: environments of each runner.
        threads: threads that step them.
        runners: processes that collect; 0: RLlib's own process.
        options: further options of `SkybodyVectorEnv`, such as `overrides`.

    Returns:
        `config`, changed.
    """
    from ray.tune import register_env

    register_env(NAME, make_env)
    settings = {"scenario": scenario, "num_threads": threads, "infos": False, **options}
    return config.environment(NAME, env_config=settings).env_runners(
        num_env_runners=runners,
        num_envs_per_env_runner=envs,
        num_cpus_per_env_runner=threads,
        gym_env_vectorize_mode=gymnasium.VectorizeMode.VECTOR_ENTRY_POINT,
    )
