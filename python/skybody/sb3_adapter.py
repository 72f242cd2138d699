"""Any Gymnasium vector environment with same-step autoreset as a Stable-Baselines3 `VecEnv`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices


class VectorEnvForSb3(VecEnv):
    """A `PythonTaskVecEnv` (or another vector environment) for Stable-Baselines3.

    `skybody.sb3.SkybodyVecEnv` is the one for tasks in C++. Infos of ended episodes have
    `terminal_observation`, and `TimeLimit.truncated`: True where its value is to be bootstrapped,
    so not for faults.

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
        self._actions = actions

    def step_wait(
        self,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Observations (num_envs, O), rewards, dones (num_envs,), infos."""
        observation, reward, terminated, truncated, given = self.envs.step(self._actions)
        dones = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(dones).tolist():
            fault = bool(given["fault"][i]) if "fault" in given else False
            infos[i] = {
                "terminal_observation": given["final_obs"][i],
                "TimeLimit.truncated": bool(truncated[i]) and not (terminated[i] or fault),
                "fault": fault,
            }
        return observation, reward.astype(np.float32), dones, infos

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed for the next `reset`; None: a random one."""
        first = super().seed(seed)[0]
        self._seeds = [first] * self.num_envs
        return self._seeds

    def close(self) -> None:
        """Closes the environment underneath."""
        self.envs.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """An attribute of the environment underneath, once per environment."""
        value = None if attr_name == "render_mode" else getattr(self.envs, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Raises AttributeError: worlds live in C++."""
        raise AttributeError(f"environments have no attribute `{attr_name}` to set")

    def env_method(
        self,
        method_name: str,
        *method_args: Any,
        indices: VecEnvIndices = None,
        **method_kwargs: Any,
    ) -> list[Any]:
        """Raises AttributeError: environments have no methods of their own."""
        raise AttributeError(f"environments have no method `{method_name}`; use `envs` directly")

    def env_is_wrapped(self, wrapper_class: Any, indices: VecEnvIndices = None) -> list[bool]:
        """False, once per environment."""
        return [False for _ in self._get_indices(indices)]
