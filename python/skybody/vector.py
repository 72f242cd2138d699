"""All environments of a scenario as one `gymnasium.vector.VectorEnv`, stepped in C++."""

from __future__ import annotations

from enum import Enum
from typing import Any, Never

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from . import _native, options, spaces
from .agents import JointLayout
from .arguments import Scenario, check_array, check_seed, flag, load, shape_error
from .display import NO_MODE, SIZE, Display
from .infos import InfoChannels, scattered_rows
from .observations import Observations, row_of
from .options import autoreset_word, refuse_unknown
from .pooled import PooledEnvironments, drain, make_native
from .registration import SpecWithHorizon


def autoreset_mode(autoreset: str | Enum) -> AutoresetMode:
    """Gymnasium's mode for "next_step", "same_step", "disabled", or for a mode or its value.

    Raises:
        ValueError: an unknown mode.
    """
    return AutoresetMode[autoreset_word(autoreset).upper()]


def reset_mask(options: dict[str, Any] | None, num_envs: int) -> NDArray[np.bool_] | None:
    """The mask (num_envs,) in the reset options; None: there are no options.

    Raises:
        TypeError: the mask is not a bool array.
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


class SkybodyVectorEnv(
    SpecWithHorizon, PooledEnvironments, VectorEnv[Any, NDArray[np.float32], NDArray[Any]]
):
    """`num_envs` environments of one scenario as one vector environment.

    Observations, rewards, ends and infos are views of memory owned by C++. They keep their values
    until the second next `step`, and for as long as any of them is referenced.

    Infos are arrays with Gymnasium's `_name` masks:

    * one per info value of the task;
    * `fault` (num_envs,) bool: action, observation or reward was not finite, or the physics
      diverged (beyond 1e6 in SI units). A fault ends the episode as truncated; its value must not
      be bootstrapped. Other environments continue;
    * if values of actions were outside [-1, 1] (such as rad/s or newtons), `clipped` (num_envs,)
      int32: their number; the attribute `clipped` is the sum so far;
    * with several agents, `agent_reward` (num_envs, agents) float32 of the transition, like the
      reward;
    * with privileged columns, `privileged` (num_envs, privileged_size) float32, which belongs to
      the
      observations: for a critic only.

    With SAME_STEP, `fault` belongs to the ended episode (as do terminations and truncations), while
    the other infos belong to the new episode.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `CompiledScenario`.
        num_envs: number of environments.
        render_mode: "rgb_array": `render` gives a picture of each environment; None: nothing is
            drawn.
        max_episode_steps: the scenario's horizon or None; `gymnasium.make_vec` passes the value of
            the specification.
        overrides and the other keywords: see `skybody.options`.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: a number is out of range, joint for agents that are not identical, joint with
            dictionaries or images, or another max_episode_steps.
    """

    def __init__(
        self,
        scenario: Scenario,
        num_envs: int,
        *,
        max_episode_steps: int | None = None,
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
        joint: options.Joint = False,
        render_mode: str | None = None,
        render_size: options.RenderSize = SIZE,
        render_camera: options.RenderCamera = "orbit",
        **unknown: Never,
    ) -> None:
        refuse_unknown(SkybodyVectorEnv, unknown)
        self._mode = autoreset_mode(autoreset)
        self.compiled = load(scenario, overrides, plugin_path)
        if max_episode_steps not in (None, self.compiled.horizon):
            raise ValueError(
                f"max_episode_steps is {max_episode_steps}; `{self.compiled.name}` flies "
                f"{self.compiled.horizon}: overrides=['stepping.horizon={max_episode_steps}']"
            )
        self.native = make_native(
            self.compiled,
            num_envs,
            seed=seed,
            num_threads=num_threads,
            pin_threads=pin_threads,
            keep_hash=keep_hash,
            order="fixed",
            autoreset=autoreset_word(self._mode),
            infos=infos,
            debug=debug,
        )
        self.num_envs = num_envs
        modes = ["rgb_array"]  # a window for each of many environments is no use
        self._display = Display(self.compiled, render_mode, render_size, render_camera, modes)
        self.metadata = {**self._display.metadata, "autoreset_mode": self._mode}
        self.render_mode = render_mode
        self._same_step = self._mode is AutoresetMode.SAME_STEP
        self._joint = JointLayout(self.compiled) if flag("joint", joint) else None
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

    @property
    def autoreset_mode(self) -> AutoresetMode:
        """The mode, as in Gymnasium's own vector environments."""
        return self._mode

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins new episodes.

        Args:
            seed: restarts the episode counters, under this seed; None: the next episodes.
            options: {"reset_mask": (num_envs,) bool array} resets only these environments; the
                rows of the others repeat their last observations.

        Returns:
            observations (num_envs, observation_size) float32 (a dictionary with
            dict_observations), and infos.

        Raises:
            TypeError: a list of seeds, or the mask is not a bool array.
            ValueError: a mask of another shape or without a True, both a seed and a mask, or an
                unknown option.
        """
        mask = reset_mask(options, self.num_envs)
        value = check_seed(seed)
        if mask is not None and value is not None:
            raise ValueError("a seed restarts all environments: leave out `reset_mask`")
        if mask is not None:
            self.native.refuse_interrupted()  # otherwise transitions of others are lost
        super().reset(seed=value)
        drain(self.native)
        self.native.send_reset(mask, value)
        batch = self.native.recv()
        if mask is None:
            return self._observations.of(batch), self._channels.masked(batch, self._all)
        begun = scattered_rows(batch, self.num_envs, batch.env_id)
        return self.observations(), self._channels.masked(*begun)

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[Any, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Makes one transition of all environments.

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
            Error: the previous step was interrupted: reset first.
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
        """SyncVectorEnv's entries for ended episodes: an object array, and a dictionary."""
        if ended.size == 0:
            return
        final = self._observations.final_of(batch)
        rows = np.full(self.num_envs, None, dtype=object)
        for i in ended:
            rows[i] = row_of(final, i)
        infos["final_obs"] = rows
        last, mask = scattered_rows(batch, self.num_envs, ended, ended)
        infos["final_info"] = self._channels.masked(last, mask)
        infos["_final_obs"] = infos["_final_info"] = mask

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Pictures of all environments as they are, with the trails of states rendered before.

        Returns:
            (height, width, 3) uint8 of each environment; None without a render_mode.

        Raises:
            ValueError: an environment is not yet reset.
        """
        if self.render_mode is None:
            gymnasium.logger.warn(NO_MODE)
            return None
        return tuple(self._display.frames(self.native, self.num_envs))

    def close_extras(self, **_: Any) -> None:
        """Finishes a recording, ends the threads and frees the memory; called by `close`."""
        self._display.close()
        self.native.close()
