"""The asynchronous pool: send actions, receive what has finished first."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._native import Environment
from .infos import InfoChannels

Scenario = str | os.PathLike[str] | Environment
Order = Literal["fixed", "arrival"]
Autoreset = Literal["next_step", "same_step", "disabled"]
Transition = tuple[
    NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]
]


def load(
    scenario: Scenario,
    overrides: Iterable[str] = (),
    plugin_path: Iterable[str | os.PathLike[str]] = (),
) -> Environment:
    """Loads a scenario: a shipped one's name, or a YAML file. One that is loaded already is shared.

    Args:
        overrides: "PATH=VALUE" each, as for `skybody run --set`.
        plugin_path: folders that are searched for plugins before the default ones.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: overrides or plugin_path for an environment that is loaded already.
    """
    paths = [os.fspath(folder) for folder in plugin_path]
    changes = list(overrides)
    if isinstance(scenario, Environment):
        if changes or paths:
            raise ValueError(
                f"`{scenario.name}` is loaded already, overrides and plugin_path come too late: "
                "give them to Environment(...), or give the scenario's name here"
            )
        return scenario
    return Environment(os.fspath(scenario), changes, paths)


def refuse_interrupted(pool: _native.Pool) -> None:
    """Raises Error where a step was interrupted (Ctrl-C) and its transitions are under way."""
    if pool.in_flight == 0:
        return
    raise _native.Error(
        f"the last step was interrupted and {pool.in_flight} environments are still in flight: "
        "reset(), which waits for them and begins anew"
    )


def check_seed(seed: Any) -> int | None:
    """A seed as an int from 0 to 2**64 - 1, or None.

    Raises:
        TypeError: it is a list, or no integer.
        ValueError: it is out of range.
    """
    if seed is None:
        return None
    try:
        value = operator.index(seed)
    except TypeError:
        raise TypeError(
            f"seed is a {type(seed).__name__}; give one integer for all environments: environment "
            "i draws its own numbers from (seed, i)"
        ) from None
    if not 0 <= value < 2**64:
        raise ValueError(f"seed is {value}; it must be from 0 to 2**64 - 1")
    return value


def env_ids(ids: ArrayLike) -> NDArray[np.int32]:
    """Ids of environments, (n,) int32. Raises TypeError if they are not integers."""
    given = np.asarray(ids)
    if given.size == 0:
        return np.empty(0, np.int32)
    if not np.issubdtype(given.dtype, np.integer):
        raise TypeError(f"ids of environments are {given.dtype}; they must be integers")
    if given.dtype != np.int32:
        given = np.clip(given, -1, 2**31 - 1)  # no id out of range becomes one within
    return np.ascontiguousarray(given, np.int32)


class Pool:
    """Many environments of one scenario, stepped on several threads.

    `send` hands actions over and returns; `recv` waits for `batch_size` finished environments,
    and steps others meanwhile. What an environment does depends on the seed, its id and its
    actions alone: not on threads, batches or order.

    Arrays from `recv` are views of the pool's memory. They keep their values until the second
    next `recv`, and for as long as any of them is held (the pool then takes fresh memory and
    counts it in `fresh_buffers`; with debug=True it raises BufferError instead).

    `native` is the `_native.Pool` underneath, for what is not wrapped here.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `Environment`.
        num_envs: number of environments, N_E.
        batch_size: rows that one `recv` waits for, at most num_envs; 0: num_envs.
        num_threads: threads that step, the caller's counted; 0: one per processor.
        seed: key of all random numbers; environment i draws from (seed, i).
        order: "arrival": first finished, first served; "fixed": by id, cyclically, so that
            partial batches come out the same in every run.
        autoreset: what happens where an episode has ended. "next_step": the next action sent is
            ignored and the environment reset; "same_step": reset at once, the ended episode's last
            observation is in info["final_obs"]; "disabled": the caller resets.
        overrides: "PATH=VALUE" each, as for `skybody run --set`.
        plugin_path: folders that are searched for plugins before the default ones.
        pin_threads: each worker on a processor of its own, where the system allows it.
        keep_hash: chain a trajectory hash per environment, for `hash`.
        debug: raise BufferError where memory that is still held would be recycled, and fill what
            is recycled with NaN.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: a number is out of range.
    """

    def __init__(
        self,
        scenario: Scenario,
        num_envs: int,
        *,
        batch_size: int = 0,
        num_threads: int = 0,
        seed: int = 0,
        order: Order = "arrival",
        autoreset: Autoreset = "next_step",
        overrides: Iterable[str] = (),
        plugin_path: Iterable[str | os.PathLike[str]] = (),
        pin_threads: bool = False,
        keep_hash: bool = False,
        debug: bool = False,
    ) -> None:
        self.environment = load(scenario, overrides, plugin_path)
        self.native = _native.Pool(
            self.environment,
            num_envs,
            batch_size=batch_size,
            num_threads=num_threads,
            order=order,
            autoreset=autoreset,
            seed=check_seed(seed) or 0,
            pin_threads=pin_threads,
            keep_hash=keep_hash,
            debug=debug,
        )
        self._channels = InfoChannels(self.environment)
        self._same_step = autoreset == "same_step"

    def async_reset(self, mask: NDArray[np.bool_] | None = None, seed: int | None = None) -> None:
        """Begins new episodes without waiting; `recv` gives their first observations.

        Args:
            mask: (num_envs,) bool: which environments; None: all.
            seed: starts the episode counters of all environments again, under this seed.

        Raises:
            ValueError: one of them is in flight, a mask of another shape, or a mask and a seed.
        """
        self.native.send_reset(mask, check_seed(seed))

    def reset(
        self, mask: NDArray[np.bool_] | None = None, seed: int | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """`async_reset`, then the first batch of it: observations and infos as from `recv`.

        With batch_size < num_envs further calls of `recv` give the others.
        """
        self.async_reset(mask, seed)
        observation, _, _, _, info = self.recv()
        return observation, info

    def send(
        self,
        actions: NDArray[np.float32],
        env_id: ArrayLike | None = None,
    ) -> None:
        """Hands over one action row per environment; rows are copied before it returns.

        Args:
            actions: (n, action_size) float32 in [-1, 1] (clipped). A row that is not finite makes
                its transition a fault.
            env_id: (n,) integers: which environments, each at most once; None: all in order.

        Raises:
            TypeError: another dtype.
            ValueError: another shape; an id that is out of range or there twice; an environment
                that is in flight, not yet reset, or (autoreset="disabled") whose episode has
                ended. Nothing was sent then.
        """
        ids = None if env_id is None else env_ids(env_id)
        self.native.send(np.ascontiguousarray(actions), ids)

    def recv(self) -> Transition:
        """Waits for up to batch_size finished environments (fewer where fewer are in flight).

        Returns:
            observation (n, observation_size) float32, reward (n,) float32, terminated (n,) bool,
            truncated (n,) bool, and info, a dictionary of arrays:

            * `env_id` (n,) int32: which environment each row is of;
            * `was_reset` (n,) bool: the row begins an episode; its reward is 0 and the action that
              was sent had no effect;
            * `fault` (n,) bool: the action was not finite, or the physics left the finite numbers.
              The row is truncated; its value must not be bootstrapped;
            * `agent_reward` (n, agents) float32;
            * one entry per info value of the task, (n,) or (n, count) float32;
            * with autoreset="same_step" also `final_obs` (n, observation_size) and `final_info`
              (a dictionary as above), valid in rows where terminated or truncated.

        Raises:
            ValueError: nothing is in flight.
            BufferError: (debug=True) the arrays of the last but one batch are still held.
        """
        batch = self.native.recv()
        info: dict[str, Any] = {
            "env_id": batch.env_id,
            "was_reset": batch.was_reset,
            "fault": batch.fault,
            "agent_reward": batch.agent_reward,
        }
        info.update(self._channels.columns(batch.info))
        if self._same_step:
            info["final_obs"] = batch.final_observation
            info["final_info"] = self._channels.columns(batch.final_info)
        return batch.observation, batch.reward, batch.terminated, batch.truncated, info

    def step(self, actions: NDArray[np.float32], env_id: ArrayLike | None = None) -> Transition:
        """`send`, then `recv`."""
        self.send(actions, env_id)
        return self.recv()

    def save(self) -> bytes:
        """Everything of all environments. Raises skybody.Error while some are in flight."""
        return self.native.save()

    def restore(self, saved: bytes) -> None:
        """Puts all environments where they were at `save`; `observations` are then as they were.

        Raises:
            ValueError: `saved` is of another scenario or number of environments, or some
                environments are in flight.
        """
        self.native.restore(saved)

    def fork(self, source: int, targets: ArrayLike, rekey: bool = False) -> None:
        """Makes environments copies of `source`: same motion, drawn values and future.

        Args:
            rekey: each copy draws random numbers of its own from here on.

        Raises:
            ValueError: an id is out of range or in flight.
        """
        self.native.fork(source, env_ids(targets), rekey)

    def observations(self) -> NDArray[np.float32]:
        """Last observation of every environment, a new array (num_envs, observation_size)."""
        return self.native.observations()

    def param(self, env: int, path: str) -> float:
        """Value of a randomizable parameter (`environment.param_paths`) in one environment."""
        return self.native.param(env, path)

    def set_param(self, env: int, path: str, value: float) -> None:
        """Sets one, in the unit of `environment.param_info(path)`.

        Raises:
            ValueError: unknown, or outside its bounds.
        """
        self.native.set_param(env, path, value)

    def hash(self, env: int | None = None) -> int:
        """Trajectory hash of one environment, or of all. Needs keep_hash=True."""
        return self.native.hash() if env is None else self.native.hash(env)

    def record(self, path: str | os.PathLike[str], states: bool = False) -> None:
        """Writes everything that happens from now on to an HDF5 file, for `skybody replay`.

        `stop_recording` or `close` finishes it; until then it is complete up to the last burst of
        about 4 MiB. Trajectory hashes are kept meanwhile, also without keep_hash.

        Args:
            path: the file; one that is there is replaced.
            states: all state words of every transition as well (8 bytes each), so that a replay
                which parts can name those that differ.

        Raises:
            skybody.Error: some environments are in flight, the pool is recorded already, or the
                file cannot be written. Where writing fails later (no space), `send` or `recv`
                raises it, and the recording is over.
        """
        self.native.record(os.fspath(path), states)

    def stop_recording(self) -> None:
        """Finishes the file of `record`; what is in flight is not in it.

        Raises:
            skybody.Error: nothing was being recorded, or the file cannot be finished.
        """
        self.native.stop_recording()

    @property
    def num_envs(self) -> int:
        return self.native.num_envs

    @property
    def batch_size(self) -> int:
        return self.native.batch_size

    @property
    def num_threads(self) -> int:
        """Threads that step, the caller's counted."""
        return self.native.num_threads

    @property
    def in_flight(self) -> int:
        """Environments that were sent and not yet received."""
        return self.native.in_flight

    @property
    def fresh_buffers(self) -> int:
        """Batches that took fresh memory because arrays of an old one were still held."""
        return self.native.fresh_buffers

    @property
    def faults(self) -> int:
        """Faulted transitions received so far."""
        return self.native.faults

    def close(self) -> None:
        """Finishes a recording, waits for steps under way, gives threads and memory back.

        Further calls raise, `close` itself excepted.
        """
        self.native.close()

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
