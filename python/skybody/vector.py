"""All environments of a scenario as one `gymnasium.vector.VectorEnv`, stepped in C++."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, cast, get_args

import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from . import _native, spaces
from .agents import JointLayout
from .arguments import Scenario, check_array, check_seed, load, shape_error
from .infos import InfoChannels, ScatteredRows
from .observations import Observations, row_of
from .pool import Autoreset, Order
from .pooled import PooledEnvironments, drain, make_native

_MODES: dict[str, AutoresetMode] = {
    "next_step": AutoresetMode.NEXT_STEP,
    "same_step": AutoresetMode.SAME_STEP,
    "disabled": AutoresetMode.DISABLED,
}


def autoreset_mode(autoreset: str | AutoresetMode) -> AutoresetMode:
    """Gymnasium's mode for "next_step", "same_step", "disabled", or for a mode or its value.

    Raises:
        ValueError: none of these.
    """
    if isinstance(autoreset, AutoresetMode):
        return autoreset
    for name, mode in _MODES.items():
        if autoreset in (name, mode.value):
            return mode
    raise ValueError(f"autoreset is {autoreset!r}; it must be one of {', '.join(_MODES)}")


def reset_mask(options: dict[str, Any] | None, num_envs: int) -> NDArray[np.bool_] | None:
    """The mask (num_envs,) that reset options have; None: there are no options.

    Raises:
        TypeError: a mask that is no bool array.
        ValueError: another shape, no True, or an unknown option.
    """
    if not options:
        return None
    unknown = sorted(set(options) - {"reset_mask"})
    if unknown:
        raise ValueError(f"unknown reset option `{unknown[0]}`; there is `reset_mask`")
    mask = options["reset_mask"]
    if not isinstance(mask, np.ndarray):
        raise TypeError(f"reset_mask is {type(mask).__name__}; it must be a NumPy array of bool")
    check_array("reset_mask", mask, (num_envs,), np.bool_)
    if not mask.any():
        raise ValueError("reset_mask has no True; leave it out to reset all environments")
    return mask


class SkybodyVectorEnv(PooledEnvironments, VectorEnv[Any, NDArray[np.float32], NDArray[Any]]):
    """`num_envs` environments of one scenario as one vector environment.

    Observations, rewards, ends and infos are views of memory that C++ owns. They keep their values
    until the second next `step`, and for as long as any of them is held.

    Infos are arrays with Gymnasium's `_name` masks: one per info value of the task, and `fault`
    (num_envs,) bool: action, observation or reward was not finite, or the physics diverged (beyond
    1e6 in SI units). A fault ends the episode, truncated; its value must not be bootstrapped. Other
    environments go on.
    With SAME_STEP, `fault` is the ended episode's (as are the flags beside it), while the other
    infos are the new episode's. With several agents there is also `agent_reward`
    (num_envs, agents) float32: the transition's, like the reward. With privileged columns there is
    `privileged` (num_envs, privileged_size) float32, which belongs to the observations: for a
    critic only.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `CompiledScenario`.
        num_envs: number of environments.
        num_threads: threads that step, the caller's counted; 0: one per processor.
        seed: key of all random numbers until a `reset(seed=...)`; environment i draws from
            (seed, i).
        order: as for `make_pool`. A vector environment waits for all of its rows, and they stand
            in the order of the environments with either.
        autoreset: "next_step", "same_step", "disabled", or Gymnasium's AutoresetMode.
        overrides: "PATH=VALUE" each, as for `skybody run --set`.
        plugin_path: folders that are searched for plugins before the default ones.
        joint: several robots that are alike: observations are (num_envs, agents, width) and
            actions (num_envs, agents, width), views of the same memory, with the team's reward.
        dict_observations: observations are dictionaries with an array (num_envs, *shape) for each
            column, by name: views of the same memory; with images they always are.
        pin_threads: each worker on a processor of its own, where the system allows it.
        keep_hash: chain a trajectory hash per environment, for `hash`.
        infos: whether infos hold the task's info values; without, tasks need not compute them.
        debug: raise BufferError where memory that is still held would be recycled, and fill what
            is recycled with NaN.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: a number is out of range, joint for agents that are not alike, or joint with
            dictionaries.
    """

    def __init__(
        self,
        scenario: Scenario,
        num_envs: int,
        *,
        num_threads: int = 0,
        seed: int = 0,
        order: Order = "fixed",
        autoreset: str | AutoresetMode = "next_step",
        overrides: Iterable[str] = (),
        plugin_path: Iterable[str | os.PathLike[str]] = (),
        joint: bool = False,
        dict_observations: bool = False,
        pin_threads: bool = False,
        keep_hash: bool = False,
        infos: bool = True,
        debug: bool = False,
    ) -> None:
        if order not in get_args(Order):
            raise ValueError(f"order is {order!r}; it must be one of {', '.join(get_args(Order))}")
        self.compiled = load(scenario, overrides, plugin_path)
        self._mode = autoreset_mode(autoreset)
        names = {mode: name for name, mode in _MODES.items()}
        self.native = make_native(
            self.compiled,
            num_envs,
            num_threads,
            seed,
            order="fixed",
            autoreset=cast(Autoreset, names[self._mode]),
            pin_threads=pin_threads,
            keep_hash=keep_hash,
            info=infos,
            debug=debug,
        )
        self.num_envs = num_envs
        self.metadata = {"render_modes": [], "autoreset_mode": self._mode}
        self._same_step = self._mode is AutoresetMode.SAME_STEP
        self._joint = JointLayout(self.compiled) if joint else None
        joint_shape = self._joint.observation_shape if self._joint is not None else None
        self._observations = Observations(self.compiled, dict_observations, joint_shape)
        self._channels = InfoChannels(self.compiled, infos)
        self._all = np.ones(num_envs, np.bool_)
        self._all.setflags(write=False)  # one mask in all infos
        self._define_spaces()

    def _define_spaces(self) -> None:
        observation = spaces.space_of(self.compiled, self._observations)
        action = spaces.action_space(self.compiled)
        if self._joint is not None and isinstance(observation, Box):
            observation = spaces.reshape(observation, self._joint.observation_shape)
            action = spaces.reshape(action, self._joint.action_shape)
        self.single_observation_space = observation
        self.single_action_space = action
        self.observation_space = spaces.batched(observation, self.num_envs)
        self.action_space = spaces.batch(action, self.num_envs)
        self._action_shape = (self.num_envs, *action.shape)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins new episodes.

        Args:
            seed: starts the episode counters again, under this seed; None: the next episodes.
            options: {"reset_mask": (num_envs,) bool array} resets only these environments; the
                rows of the others are their last observations again.

        Returns:
            observations (num_envs, observation_size) float32 (a dictionary with
            dict_observations), and infos.

        Raises:
            TypeError: a list of seeds, or a mask that is no bool array.
            ValueError: a mask of another shape or without a True, a seed and a mask, or an unknown
                option.
        """
        mask = reset_mask(options, self.num_envs)
        value = check_seed(seed)
        if mask is not None and value is not None:
            raise ValueError("a seed restarts all environments: leave out `reset_mask`")
        if mask is not None:
            self.native.refuse_interrupted()  # others' transitions would be lost
        super().reset(seed=value)
        drain(self.native)
        self.native.send_reset(mask, value)
        batch = self.native.recv()
        if mask is None:
            return self._observations.of(batch), self._channels.masked(batch, self._all)
        begun = ScatteredRows(batch, self.num_envs, batch.env_id, ended=False)
        return self.observations(), self._channels.masked(begun, begun.mask)

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Any, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """One transition of all environments.

        Args:
            actions: (num_envs, action_size) float32 in [-1, 1] (clipped). A row that is not finite
                makes that environment fault. With NEXT_STEP the rows of ended episodes are
                ignored.

        Returns:
            observations (num_envs, observation_size) float32 (a dictionary with
            dict_observations), rewards (num_envs,) float32,
            terminations, truncations (num_envs,) bool, and infos.

        Raises:
            TypeError: another dtype.
            Error: the step before was interrupted: reset first.
            ValueError: another shape; an environment that is not yet reset, or (DISABLED) whose
                episode has ended.
        """
        if self._joint is not None:
            actions = self._joint_rows(actions)
        batch = self.native.step(actions)
        terminated, truncated = batch.terminated, batch.truncated
        infos = self._channels.masked(batch, self._all)
        if self._same_step:
            self._add_final(infos, batch, np.flatnonzero(terminated | truncated))
        return self._observations.of(batch), batch.reward, terminated, truncated, infos

    def _joint_rows(self, actions: NDArray[np.float32]) -> NDArray[np.float32]:
        rows = np.ascontiguousarray(actions)
        if rows.shape != self._action_shape:
            raise shape_error("actions", rows, self._action_shape)
        return rows.reshape(self.num_envs, -1)

    def _add_final(
        self, infos: dict[str, Any], batch: _native.Batch, ended: NDArray[np.intp]
    ) -> None:
        """What SyncVectorEnv adds where episodes have ended: an object array, and a dictionary."""
        if ended.size == 0:
            return
        final = self._observations.final_of(batch)
        rows = np.full(self.num_envs, None, dtype=object)
        for i in ended:
            rows[i] = row_of(final, i)
        infos["final_obs"] = rows
        last = ScatteredRows(batch, self.num_envs, ended, ended=True)
        infos["final_info"] = self._channels.masked(last, last.mask)
        infos["_final_obs"] = infos["_final_info"] = last.mask

    def close_extras(self, **_: Any) -> None:
        """Finishes a recording, gives threads and memory back; called by `close`."""
        self.native.close()
