"""Stable-Baselines3's methods on single environments, for environments without own objects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices

from .arguments import check_seed


def end_info(observation: Any, terminated: Any, fault: Any, reasons: Any, i: int) -> dict[str, Any]:
    """Info of environment `i`, whose episode ended with the last `observation`.

    Args:
        terminated, fault: (num_envs,) bool.
        reasons: of the faults, by environment; None: there are none.
    """
    info = {
        "terminal_observation": observation,
        "TimeLimit.truncated": not (terminated[i] or fault[i]),
        "fault": bool(fault[i]),
    }
    if reasons is not None and fault[i]:
        info["fault_reason"] = reasons[i]
    return info


class UniformVecEnv(VecEnv):
    """A `VecEnv` whose environments are identical and have no Python objects of their own."""

    def attribute(self, name: str) -> Any:
        """An attribute that all environments share. Raises AttributeError if there is none."""
        return getattr(self, name)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Sets the seed of the next `reset`: environment i draws from (seed, i). None: random.

        Returns:
            the seed, num_envs times.
        """
        first = super().seed(check_seed(seed))[0]
        self._seeds = [first] * self.num_envs
        return self._seeds

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """An attribute, once per environment."""
        value = None if attr_name == "render_mode" else self.attribute(attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Raises AttributeError."""
        raise AttributeError(f"environments have no attribute `{attr_name}` to set")

    def env_method(
        self,
        method_name: str,
        *method_args: Any,
        indices: VecEnvIndices = None,
        **method_kwargs: Any,
    ) -> list[Any]:
        """Raises AttributeError: there is no such method."""
        raise AttributeError(f"environments have no method `{method_name}`")

    def env_is_wrapped(self, wrapper_class: Any, indices: VecEnvIndices = None) -> list[bool]:
        """False, once per environment."""
        return [False for _ in self._get_indices(indices)]
