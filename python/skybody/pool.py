"""The asynchronous pool: send actions, receive the environments that finish first."""

from __future__ import annotations

from typing import Any, Never

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import options
from .arguments import MOST_ENVS, Scenario, check_seed, env_ids, integer_within, load
from .infos import InfoChannels, add_fault_reasons, final_values
from .observations import Observations
from .options import autoreset_word, order_word, refuse_unknown
from .pooled import PooledEnvironments, make_native

Transition = tuple[Any, NDArray[np.float32], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]


class Pool(PooledEnvironments):
    """Many environments of one scenario, stepped on several threads.

    `send` hands actions over and returns; `recv` waits for `batch_size` finished environments,
    and steps others meanwhile. The result of an environment depends only on the seed, its id and
    its actions, not on threads, batches or order.

    Arrays from `recv` are views of the pool's memory. They keep their values until the second
    next `recv`, and for as long as any of them is referenced. In the latter case the pool allocates
    new memory and counts it in `fresh_buffers`; with debug=True it raises BufferError instead.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `CompiledScenario`.
        num_envs: number of environments, N_E.
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
        autoreset: options.AutoresetOption = "next_step",
        infos: options.Infos = True,
        debug: options.Debug = False,
        order: options.OrderOption = "arrival",
        batch_size: options.BatchSize = 0,
        **unknown: Never,
    ) -> None:
        refuse_unknown(Pool, unknown)
        self.compiled = load(scenario, overrides, plugin_path)
        ending = autoreset_word(autoreset)
        count = integer_within("num_envs", num_envs, 1, MOST_ENVS)
        self.native = make_native(
            self.compiled,
            count,
            seed=seed,
            num_threads=num_threads,
            pin_threads=pin_threads,
            keep_hash=keep_hash,
            batch_size=integer_within("batch_size", batch_size, 0, count),
            order=order_word(order),
            autoreset=ending,
            infos=infos,
            debug=debug,
        )
        self._observations = Observations(self.compiled, dict_observations)
        self._channels = InfoChannels(self.compiled, infos)
        self._same_step = ending == "same_step"

    def async_reset(self, mask: NDArray[np.bool_] | None = None, seed: int | None = None) -> None:
        """Begins new episodes without waiting; `recv` returns their first observations.

        Args:
            mask: (num_envs,) bool, the environments; None: all.
            seed: restarts the episode counters of all environments, under this seed.

        Raises:
            ValueError: one of the environments is in flight, a mask of another shape, or both a
                mask and a seed.
        """
        self.native.send_reset(mask, check_seed(seed))

    def reset(
        self, mask: NDArray[np.bool_] | None = None, seed: int | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """`async_reset`, then its first batch: observations and infos as from `recv`.

        If batch_size < num_envs, further calls of `recv` return the other environments.
        """
        self.async_reset(mask, seed)
        observation, _, _, _, info = self.recv()
        return observation, info

    def send(
        self,
        actions: NDArray[np.float32],
        env_id: ArrayLike | None = None,
    ) -> None:
        """Hands over one action row per environment; the rows are copied before it returns.

        Args:
            actions: (n, action_size) float32 in [-1, 1] (clipped). A row that is not finite makes
                its transition a fault.
            env_id: (n,) integers, the environments, each at most once; None: all in order.

        Raises:
            TypeError: another dtype.
            ValueError: another shape; an id that is out of range or duplicate; an environment that
                is in flight, not yet reset, or (autoreset="disabled") whose episode has ended. In
                all these cases nothing is sent.
        """
        ids = None if env_id is None else env_ids(env_id)
        self.native.send(np.ascontiguousarray(actions), ids)

    def recv(self) -> Transition:
        """Waits for up to batch_size finished environments (fewer if fewer are in flight).

        Returns:
            observation (n, observation_size) float32 (with dict_observations a dictionary of
            (n, *shape) arrays), reward (n,) float32, terminated (n,) bool,
            truncated (n,) bool, and info, a dictionary of arrays:

            * `env_id` (n,) int32: the environment of each row;
            * `was_reset` (n,) bool: the row begins an episode; its reward is 0 and the action that
              was sent had no effect;
            * `fault` (n,) bool: action, observation or reward was not finite, or the physics
              diverged (beyond 1e6 in SI units). The row is truncated; its value must not be
              bootstrapped. If there is such a row, `fault_reason` (n,) has the reasons as strings,
              and `_fault_reason` is `fault`;
            * if values of actions were outside [-1, 1]: `clipped` (n,) int32, their number per row;
            * `agent_reward` (n, agents) float32;
            * one entry per info value of the task, (n,) or (n, count) float32;
            * with privileged columns `privileged` (n, privileged_size) float32, for a critic only;
            * with autoreset="same_step" also `final_obs` (n, observation_size) and `final_info`
              (a dictionary as above), valid in rows that are terminated or truncated.

        Raises:
            ValueError: nothing is in flight.
            BufferError: (debug=True) the arrays of the last but one batch are still referenced.
        """
        batch = self.native.recv()
        info: dict[str, Any] = {
            "env_id": batch.env_id,
            "was_reset": batch.was_reset,
            "fault": batch.fault,
            "agent_reward": batch.agent_reward,
        }
        if (reasons := batch.fault_reasons) is not None:
            add_fault_reasons(info, reasons)
        if (clipped := batch.clipped) is not None:
            info["clipped"] = clipped
        info.update(self._channels.columns(batch))
        if self._same_step:
            info["final_obs"] = self._observations.final_of(batch)
            info["final_info"] = self._channels.columns(final_values(batch))
        observation = self._observations.of(batch)
        return observation, batch.reward, batch.terminated, batch.truncated, info

    def step(self, actions: NDArray[np.float32], env_id: ArrayLike | None = None) -> Transition:
        """`send`, then `recv`."""
        self.send(actions, env_id)
        return self.recv()

    @property
    def num_envs(self) -> int:
        return self.native.num_envs

    @property
    def batch_size(self) -> int:
        return self.native.batch_size

    @property
    def num_threads(self) -> int:
        """Number of threads that step, including the caller's."""
        return self.native.num_threads

    @property
    def in_flight(self) -> int:
        """Number of environments that were sent and not yet received."""
        return self.native.in_flight

    @property
    def fresh_buffers(self) -> int:
        """Batches that allocated memory because arrays of an old batch were still referenced."""
        return self.native.fresh_buffers

    def close(self) -> None:
        """Finishes a recording, waits for running steps, ends the threads and frees the memory.

        Later calls raise, except `close` itself.
        """
        self.native.close()

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
