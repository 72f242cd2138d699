"""Several robots as a PettingZoo `ParallelEnv`: each robot is an agent."""

from __future__ import annotations

import copy
from typing import Any, Never

import numpy as np
from gymnasium.spaces import Box, Dict
from numpy.typing import NDArray

from . import options, spaces
from .agents import commanded_by, observed_by
from .arguments import Scenario, check_array
from .display import SIZE
from .env import SkybodyEnv
from .extras import missing_package
from .observations import key_of, policy_columns
from .options import refuse_unknown

try:
    import pettingzoo  # type: ignore[import-untyped]
except ModuleNotFoundError as error:
    raise missing_package("multi_agent", error) from error

Observations = dict[str, Any]
Infos = dict[str, dict[str, Any]]


class ParallelEnv(
    pettingzoo.ParallelEnv[str, Any, NDArray[np.float32]],  # type: ignore[misc]
):
    """One environment with several robots as a PettingZoo `ParallelEnv`.

    Each robot that takes actions is an agent, under its name in the scenario. All agents begin and
    end together. Each agent observes its own columns and the global ones. Each agent's info has the
    info values, `fault` and `privileged`, as in `SkybodyEnv`.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `CompiledScenario`.
        render_mode: as of `SkybodyEnv`.
        overrides and the other keywords: see `skybody.options`.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError, skybody.Error: as of `SkybodyEnv`.
    """

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
        refuse_unknown(ParallelEnv, unknown)
        self._env = SkybodyEnv(
            scenario,
            overrides=overrides,
            plugin_path=plugin_path,
            seed=seed,
            env_id=env_id,
            dict_observations=dict_observations,
            render_mode=render_mode,
            render_size=render_size,
            render_camera=render_camera,
        )
        self.compiled = self._env.compiled
        self.metadata: dict[str, Any] = {"name": self.compiled.name, **self._env.metadata}
        self.render_mode = render_mode
        robots, agents = self.compiled.robots, self.compiled.agents
        self.possible_agents = [robots[robot] for robot in agents]
        self.agents: list[str] = []
        self._observation: Any = None
        self._seen = {robots[r]: observed_by(self.compiled, r) for r in agents}
        self._commanded = {robots[r]: commanded_by(self.compiled, r) for r in agents}
        self._keys: dict[str, list[str]] = {}  # keys of dictionary observations
        self.observation_spaces = {robots[robot]: self._space_of(robot) for robot in agents}
        self.action_spaces = {
            agent: spaces.select(self._env.action_space, commanded)
            for agent, commanded in self._commanded.items()
        }

    def __copy__(self) -> ParallelEnv:
        return copy.deepcopy(self)  # the copy has its own environment

    def _space_of(self, robot: int) -> Box[np.float32] | Dict:
        agent = self.compiled.robots[robot]
        if not isinstance(self._env.observation_space, Dict):
            return spaces.select(spaces.observation_space(self.compiled), self._seen[agent])
        columns = [c for c in policy_columns(self.compiled) if c.robot in (robot, -1)]
        self._keys[agent] = [key_of(column) for column in columns]
        return spaces.dict_space(columns)

    def observation_space(self, agent: str) -> Box[np.float32] | Dict:
        """Observations: (width,) float32, or with dict_observations a Dict of columns."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Box[np.float32]:
        """An agent's actions: (width,) float32 in [-1, 1]."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, Infos]:
        """Begins an episode of all agents: the first under `seed`, or without a seed the next.

        Args:
            options: not used; PettingZoo's own tests pass some.
        """
        self._observation, info = self._env.reset(seed=seed)
        info.pop("agent_reward", None)
        self.agents = list(self.possible_agents)
        return self._observations(), self._infos(info)

    def step(
        self, actions: dict[str, NDArray[np.float32]]
    ) -> tuple[Observations, dict[str, float], dict[str, bool], dict[str, bool], Infos]:
        """Makes one transition.

        Args:
            actions: one (width,) float32 array in [-1, 1] per agent.

        Returns:
            observations, rewards, terminations, truncations and infos, each by agent.

        Raises:
            TypeError: another dtype.
            ValueError: an agent's action is missing or has another shape; an action of an unknown
                agent; `reset` was not called yet, or the episode has ended.
        """
        self._observation, reward, terminated, truncated, info = self._env.step(
            self._joined(actions)
        )
        if terminated or truncated:
            self.agents = []
        rewards = info.pop("agent_reward", [reward])
        return (
            self._observations(),
            {a: float(r) for a, r in zip(self.possible_agents, rewards, strict=True)},
            dict.fromkeys(self.possible_agents, terminated),
            dict.fromkeys(self.possible_agents, truncated),
            self._infos(info),
        )

    def _joined(self, actions: dict[str, NDArray[np.float32]]) -> NDArray[np.float32]:
        unknown = next((agent for agent in actions if agent not in self._commanded), None)
        if unknown is not None:
            raise ValueError(
                f"an action for `{unknown}`, which is no agent; there must be one for each of "
                f"{', '.join(self.possible_agents)}"
            )
        row = np.empty(self.compiled.action_size, np.float32)
        for agent, commanded in self._commanded.items():
            if agent not in actions:
                raise ValueError(
                    f"no action for agent `{agent}`; there must be one for each of "
                    f"{', '.join(self.possible_agents)}"
                )
            name = f"the action of agent `{agent}`"
            row[commanded] = check_array(name, actions[agent], commanded.shape, np.float32)
        return row

    def _observations(self) -> Observations:
        if not self._keys:
            return {agent: self._observation[seen] for agent, seen in self._seen.items()}
        return {
            agent: {key: self._observation[key].copy() for key in keys}
            for agent, keys in self._keys.items()
        }

    def _infos(self, info: dict[str, Any]) -> Infos:
        return {agent: dict(info) for agent in self.possible_agents}

    def render(self) -> NDArray[np.uint8] | None:
        """A picture of the present state, as `SkybodyEnv.render` gives it."""
        return self._env.render()

    def state(self) -> NDArray[np.float32]:
        """The whole row of observations (observation_size,), for a centralised critic."""
        return self._env.row()

    def close(self) -> None:
        """Frees the memory. Later calls raise."""
        self._env.close()
