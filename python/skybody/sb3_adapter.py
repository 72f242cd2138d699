"""Any Gymnasium vector environment with same-step autoreset as a Stable-Baselines3 `VecEnv`."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from .extras import missing_package

try:
    from .sb3_uniform import UniformVecEnv, end_info
except ModuleNotFoundError as error:
    raise missing_package("sb3_adapter", error) from error


class VectorEnvForSb3(UniformVecEnv):
    """A `PythonTaskVectorEnv` (or another vector environment) for Stable-Baselines3.

    For tasks in C++ use `skybody.sb3.SkybodyVecEnv`. Infos of ended episodes have
    `terminal_observation`, and `TimeLimit.truncated`: True if its value is to be bootstrapped,
    which excludes faults.

    Raises:
        ValueError: the environment's autoreset mode is not SAME_STEP.
    """

    def __init__(self, envs: VectorEnv[Any, Any, Any]) -> None:
        mode = envs.metadata.get("autoreset_mode")
        if mode is not AutoresetMode.SAME_STEP:
            raise ValueError(
                f"autoreset is {mode}; Stable-Baselines3 needs autoreset='same_step': an ended "
                "episode's environment must be reset within the same step"
            )
        self.envs = envs
        super().__init__(envs.num_envs, envs.single_observation_space, envs.single_action_space)

    def reset(self) -> NDArray[np.float32]:
        """Begins new episodes; under a new seed after `seed(...)`. Observations (num_envs, O)."""
        observation: NDArray[np.float32] = self.envs.reset(seed=self._seeds[0])[0]
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return observation

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Keeps the actions for `step_wait`."""
        self._actions = np.asarray(actions, np.float32)

    def step_wait(
        self,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Observations (num_envs, O), rewards, dones (num_envs,), infos."""
        observation, reward, terminated, truncated, given = self.envs.step(self._actions)
        dones = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        fault, reasons = given.get("fault", np.zeros_like(dones)), given.get("fault_reason")
        for i in np.flatnonzero(dones).tolist():
            infos[i] = end_info(given["final_obs"][i], terminated, fault, reasons, i)
        return observation, np.asarray(reward, np.float32), dones, infos

    def attribute(self, name: str) -> Any:
        """An attribute of the underlying environment. Raises AttributeError if there is none."""
        return getattr(self.envs, name)

    def close(self) -> None:
        """Closes the underlying environment."""
        self.envs.close()
