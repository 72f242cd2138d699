"""One environment as a `gymnasium.Env`."""

from __future__ import annotations

from typing import Any, Never

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from . import _native, options, spaces
from .arguments import Scenario, check_seed, integer, load, shape_error
from .display import MODES, NO_MODE, SIZE, Display
from .infos import InfoChannels
from .observations import Observations, row_of
from .options import refuse_unknown
from .pooled import drain
from .registration import SpecWithHorizon


class SkybodyEnv(SpecWithHorizon, gymnasium.Env[Any, NDArray[np.float32]]):
    """One environment of a scenario. For more than a few, `make_vec` is much faster.

    The info dictionary has:

    * info values (the task's, then those of other plugins): np.float32 each, or (count,) arrays;
    * `fault` (bool): action, observation or reward was not finite, or the physics diverged (beyond
      1e6 in SI units). The episode is then truncated; its value must not be bootstrapped;
    * with several agents, `agent_reward` (agents,) float32;
    * with privileged columns, `privileged` (privileged_size,) float32, for a critic only;
    * if values of the action were outside [-1, 1], `clipped` (int): their number.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `CompiledScenario`.
        render_mode: "rgb_array": `render` gives a picture; "human": a window shows the flight at
            the speed of its own time; None: nothing is drawn.
        overrides and the other keywords: see `skybody.options`.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: an unknown render_mode or camera, or a size out of range.
        skybody.Error: "human" without a display.
    """

    metadata = {"render_modes": MODES}  # noqa: RUF012 (Gymnasium's own declaration)

    def __init__(
        self,
        scenario: Scenario,
        *,
        render_mode: str | None = None,
        overrides: options.Overrides = (),
        plugin_path: options.PluginPath = (),
        seed: options.SeedOrNone = None,
        env_id: options.EnvId = 0,
        dict_observations: options.DictObservations = False,
        render_size: options.RenderSize = SIZE,
        render_camera: options.RenderCamera = "orbit",
        **unknown: Never,
    ) -> None:
        refuse_unknown(SkybodyEnv, unknown)
        self.compiled = load(scenario, overrides, plugin_path)
        self._display = Display(self.compiled, render_mode, render_size, render_camera)
        self.metadata = self._display.metadata
        self.render_mode = render_mode
        self._observations = Observations(self.compiled, dict_observations)
        self.observation_space = spaces.space_of(self.compiled, self._observations)
        self.action_space: Box[np.float32] = spaces.action_space(self.compiled)
        self._seed = check_seed(seed)
        self._env_id = integer("env_id", env_id)
        self._channels = InfoChannels(self.compiled)
        self._pool = self._new_pool()

    def _new_pool(self) -> _native.Pool:
        return _native.Pool(
            self.compiled,
            num_envs=1,
            num_threads=1,
            seed=self._seed or 0,
            first_env_id=self._env_id,
            autoreset="disabled",
        )

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy: the complete state, so that the copy continues identically."""
        return {**self.__dict__, "_pool": self._pool.save()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._pool = self._new_pool()
        self._pool.restore(state["_pool"])

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins an episode: the first one under `seed`, or without a seed the next one.

        Returns:
            observation (observation_size,) float32 (a dictionary with dict_observations), and info.

        Raises:
            ValueError: `options` is not empty; there are no reset options.
        """
        if options:
            raise ValueError(f"unknown reset option `{next(iter(options))}`; there are none")
        value = check_seed(seed)
        super().reset(seed=value)
        if value is None and self._seed is None:
            value = int(self.np_random.integers(2**63))
        if value is not None:
            self._seed = value
        drain(self._pool)
        self._pool.send_reset(None, value)
        batch = self._pool.recv()
        if self.render_mode == "human":
            self._display.show(self._pool)
        return row_of(self._observations.of(batch), 0), self._info(batch)

    def step(self, action: NDArray[np.float32]) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Makes one transition.

        Args:
            action: (action_size,) float32 in [-1, 1] (clipped). A value that is not finite is a
                fault.

        Returns:
            observation (observation_size,) float32 (a dictionary with dict_observations),
            reward, terminated, truncated, info.

        Raises:
            TypeError: another dtype.
            Error: the previous step was interrupted: reset first.
            ValueError: another shape, `reset` was not called yet, or the episode has ended.
        """
        row = np.ascontiguousarray(action)
        if row.shape != self.action_space.shape:
            raise shape_error("action", row, self.action_space.shape)
        batch = self._pool.step(row[np.newaxis])
        if self.render_mode == "human":
            self._display.show(self._pool)
        return (
            row_of(self._observations.of(batch), 0),
            float(batch.reward[0]),
            bool(batch.terminated[0]),
            bool(batch.truncated[0]),
            self._info(batch),
        )

    def _info(self, batch: _native.Batch) -> dict[str, Any]:
        info = self._channels.of_row(batch, 0)
        info["fault"] = bool(batch.fault[0])
        if (reasons := batch.fault_reasons) is not None:
            info["fault_reason"] = reasons[0]
        if (clipped := batch.clipped) is not None:
            info["clipped"] = int(clipped[0])
        if len(self.compiled.agents) > 1:
            info["agent_reward"] = batch.agent_reward[0].copy()
        return info

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the present state, with the trails of the states rendered before.

        Returns:
            (height, width, 3) uint8 for "rgb_array"; None for "human", whose window every step
            renews, and without a render_mode.

        Raises:
            ValueError: `reset` was not called yet.
        """
        if self.render_mode is None:
            gymnasium.logger.warn(NO_MODE)
        if self.render_mode != "rgb_array":
            return None
        return self._display.frames(self._pool)[0]

    def row(self) -> NDArray[np.float32]:
        """The last row of observations (observation_size,), without images; a copy."""
        row: NDArray[np.float32] = self._pool.observations()[0]
        return row

    def save(self) -> bytes:
        """The complete state of the environment: motion, drawn values, counters, random key."""
        return self._pool.save()

    def restore(self, saved: bytes) -> Any:
        """Restores the state of a `save`. Returns its observation.

        Raises:
            ValueError: `saved` comes from another scenario.
        """
        self._pool.restore(saved)
        self._display.forget()
        return row_of(self._observations.now(self._pool), 0)

    def param(self, path: str) -> float:
        """Value of a randomizable parameter (`compiled.param_paths`)."""
        return self._pool.param(0, path)

    def set_param(self, path: str, value: float) -> None:
        """Sets a randomizable parameter, in the unit of `compiled.param_info(path)`.

        Raises:
            ValueError: an unknown path, or a value out of its bounds.
        """
        self._pool.set_param(0, path, value)

    def close(self) -> None:
        """Frees the memory, and closes the window. Later calls raise."""
        self._display.close()
        self._pool.close()
