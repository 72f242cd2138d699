"""All environments of a scenario as a Stable-Baselines3 `VecEnv`, stepped in C++."""

from __future__ import annotations

from typing import Any, Never

import numpy as np
from numpy.typing import NDArray

from . import _native, options, spaces
from .arguments import Scenario, check_seed, load
from .extras import missing_package
from .infos import InfoChannels, ValueRows, final_values
from .observations import Observations, copy_of, row_of
from .options import refuse_unknown
from .pooled import PooledEnvironments, drain, make_native

try:
    from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices

    from .sb3_uniform import UniformVecEnv, end_info
except ModuleNotFoundError as error:
    raise missing_package("sb3", error) from error

_PER_ENV_METHODS = ("param", "set_param")


class SkybodyVecEnv(PooledEnvironments, UniformVecEnv):
    """`num_envs` environments of one scenario for Stable-Baselines3.

    An environment is reset within the step that ends its episode, as Stable-Baselines3 expects.
    Its info then has

    * `terminal_observation` (observation_size,) float32: the last one before the reset, a copy;
    * `TimeLimit.truncated`: True if the value of that observation is to be bootstrapped: for a
      truncation that is neither a termination nor a fault;
    * `fault`: action, observation or reward was not finite, or the physics diverged;
    * info values (the task's, then those of other plugins) at the end, for
      `VecMonitor(info_keywords=...)`.

    Infos of other environments are empty; `last_info` has their values, as arrays.

    Observations and rewards are copies: Stable-Baselines3 keeps the last observations, adds
    bootstrapped values to the rewards in place, and its callbacks keep both.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `CompiledScenario`.
        num_envs: number of environments.
        overrides and the other keywords: see `skybody.options`.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: a number is out of range.
    """

    def __init__(
        self,
        scenario: Scenario,
        num_envs: int,
        *,
        overrides: options.Overrides = (),
        plugin_path: options.PluginPath = (),
        seed: options.Seed = 0,
        num_threads: options.NumThreads = 0,
        pin_threads: options.PinThreads = False,
        dict_observations: options.DictObservations = False,
        keep_hash: options.KeepHash = False,
        **unknown: Never,
    ) -> None:
        refuse_unknown(SkybodyVecEnv, unknown)
        self.compiled = load(scenario, overrides, plugin_path)
        self.native = make_native(
            self.compiled,
            num_envs,
            seed=seed,
            num_threads=num_threads,
            pin_threads=pin_threads,
            keep_hash=keep_hash,
            order="fixed",
            autoreset="same_step",
        )
        self._observations = Observations(self.compiled, dict_observations)
        self._channels = InfoChannels(self.compiled)
        self._last = ValueRows(
            np.zeros((num_envs, self.compiled.info_size), np.float32),
            np.zeros((num_envs, self.compiled.privileged_size), np.float32),
        )
        super().__init__(
            num_envs,
            spaces.space_of(self.compiled, self._observations),
            spaces.action_space(self.compiled),
        )

    def reset(self) -> Any:
        """Begins new episodes; under a new seed after `seed(...)`, otherwise the next ones.

        Returns:
            observations (num_envs, observation_size) float32 (a dictionary with
            dict_observations). `reset_infos` has the info values of each.
        """
        drain(self.native)
        self.native.send_reset(None, check_seed(self._seeds[0]))
        self._reset_seeds()
        self._reset_options()
        batch = self.native.recv()
        self._remember(batch)
        self.reset_infos = [self._channels.of_row(self._last, i) for i in range(self.num_envs)]
        return copy_of(self._observations.of(batch))

    def _remember(self, batch: _native.Batch) -> None:
        self._last = ValueRows(batch.info.copy(), batch.privileged.copy())

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Hands the actions over: (num_envs, action_size) in [-1, 1] (clipped).

        Raises Error if the previous step was interrupted: reset first.
        """
        self.native.refuse_interrupted()
        self.native.send(np.ascontiguousarray(actions, np.float32), None)

    def step_wait(
        self,
    ) -> tuple[Any, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Observations (num_envs, observation_size), rewards, dones (num_envs,), infos."""
        batch = self.native.recv()
        self._remember(batch)
        dones = batch.terminated | batch.truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if dones.any():
            self._tell_ends(batch, dones, infos)
        observation = copy_of(self._observations.of(batch))
        return observation, batch.reward.copy(), dones, infos

    def _tell_ends(
        self, batch: _native.Batch, dones: NDArray[np.bool_], infos: list[dict[str, Any]]
    ) -> None:
        terminated, fault = batch.terminated, batch.fault
        final = self._observations.final_of(batch)
        last = final_values(batch)
        reasons = batch.fault_reasons
        for i in np.flatnonzero(dones).tolist():
            ended = end_info(row_of(final, i), terminated, fault, reasons, i)
            infos[i] = self._channels.of_row(last, i) | ended

    @property
    def last_info(self) -> dict[str, NDArray[np.float32]]:
        """Info values after the last step (or its reset): (num_envs,) each.

        With privileged columns also `privileged` (num_envs, privileged_size), for a critic only.
        """
        return self._channels.columns(self._last)

    def set_options(self, options: list[dict[str, Any]] | dict[str, Any] | None = None) -> None:
        """There are no reset options. Raises ValueError if any is given."""
        given = options if isinstance(options, list) else [options or {}]
        for each in given:
            if each:
                raise ValueError(f"unknown reset option `{next(iter(each))}`; there are none")

    def close(self) -> None:
        """Ends the threads and frees the memory. Later calls raise."""
        self.native.close()

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Raises AttributeError with the way to set physical values."""
        raise AttributeError(
            f"environments have no attribute `{attr_name}` to set; physical values are set by "
            'env_method("set_param", PATH, VALUE)'
        )

    def env_method(
        self,
        method_name: str,
        *method_args: Any,
        indices: VecEnvIndices = None,
        **method_kwargs: Any,
    ) -> list[Any]:
        """Calls `param(path)` or `set_param(path, value)` of some environments.

        Raises:
            AttributeError: another method.
        """
        if method_name not in _PER_ENV_METHODS:
            raise AttributeError(
                f"environments have no method `{method_name}`; there are "
                f"{', '.join(_PER_ENV_METHODS)}"
            )
        method = getattr(self.native, method_name)
        return [method(i, *method_args, **method_kwargs) for i in self._get_indices(indices)]
