"""Tasks written in Python: observation, reward and end in NumPy, over a pool of simulations.

Environments are stepped in C++, all at the same time; the task reads all of them at once, as
arrays. This is the quick way to try an idea. A task in C++ (docs/plugins.md) is faster and also
runs in `skybody run`.
"""

from __future__ import annotations

from typing import Any, Never

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import ArrayLike, NDArray

from . import _native, options, spaces
from .arguments import Scenario, check_array, check_seed
from .options import refuse_unknown
from .simulation import EnvStates, SimulationPool
from .vector import autoreset_mode, reset_mask


class PythonTask:
    """Base class of tasks in Python. n: number of environments in the arrays.

    The scenario's own task is not used; its randomizers are.
    """

    control: str | None = None
    """Control mode of all robots, as for `Simulation`; None: the scenario's own controllers."""
    physics_steps: int = 10
    """Physics steps for each action, >= 1."""
    horizon: int = 1000
    """Actions after which an episode is truncated, >= 1."""
    observation_space: Box[np.float32]
    """Of one environment."""
    action_space: Box[np.float32]
    """Of one environment. Actions are clipped to it."""

    def setup(self, pool: SimulationPool) -> None:
        """Called once, before all other methods. Use it to look up constants or to keep the pool;
        its `state(path)` returns values that `states` does not contain.
        """

    def begin(
        self, pool: SimulationPool, envs: NDArray[np.int32], rng: np.random.Generator
    ) -> None:
        """Called after a reset of some environments. Use it to teleport them, to draw goals, or to
        clear the task's own state.
        """

    def command(self, actions: NDArray[np.float32], states: EnvStates) -> ArrayLike:
        """Commands (n, command_size), in the units of the control mode, from actions (n, A)."""
        raise self._lacks("command")

    def observation(self, states: EnvStates) -> ArrayLike:
        """The learner's observations, (n, O)."""
        raise self._lacks("observation")

    def reward(self, states: EnvStates, actions: NDArray[np.float32]) -> ArrayLike:
        """Rewards (n,) of the states after these actions (n, A)."""
        raise self._lacks("reward")

    def terminated(self, states: EnvStates) -> ArrayLike:
        """Episodes that the task ends here, (n,) bool."""
        return np.zeros(len(states.times), np.bool_)

    def info(self, states: EnvStates) -> dict[str, NDArray[Any]]:
        """Additional values, (n, ...) each."""
        return {}

    def _lacks(self, method: str) -> NotImplementedError:
        name = type(self).__name__
        return NotImplementedError(f"{name} has no method `{method}`: define {name}.{method}")


def _check_task(task: PythonTask) -> None:
    """Raises TypeError if it is not a task, ValueError for numbers out of range."""
    if isinstance(task, type):
        raise TypeError(f"task is the class {task.__name__}; give an object: {task.__name__}()")
    if not isinstance(task, PythonTask):
        raise TypeError(
            f"task is a {type(task).__name__}; it must be an object of a class that derives from "
            "PythonTask"
        )
    for name in ("observation_space", "action_space"):
        if not hasattr(task, name):
            raise TypeError(f"{type(task).__name__} has no `{name}`: give it a gymnasium Box")
    for name in ("physics_steps", "horizon"):
        if getattr(task, name) < 1:
            raise ValueError(f"the task's {name} is {getattr(task, name)}; it must be >= 1")


def _command_size(compiled: _native.CompiledScenario) -> int:
    """Command size of the only robot; 0 with several robots, or if none takes commands."""
    found = [compiled.state_values.get(f"robots.{robot}.command") for robot in compiled.robots]
    return found[0].shape[0] if len(found) == 1 and found[0] is not None else 0


def _demand_finite(bad: NDArray[np.bool_]) -> None:
    """Raises ValueError if the first observation of an episode is not finite."""
    if bad.any():
        raise ValueError(f"the first observation of environment {np.argmax(bad)} is not finite")


class PythonTaskVectorEnv(VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[Any]]):
    """A task in Python as a `gymnasium.vector.VectorEnv` over a `SimulationPool`.

    `fault` in the infos (num_envs,) bool marks episodes that end because the physics diverged or
    because an action, observation or reward was not finite. They are truncated, with reward 0 and
    the last finite observation; their value must not be bootstrapped. Other environments continue.
    With SAME_STEP, `fault` belongs to the ended episode, other infos to the new one; `final_info`
    has all infos of the ended one.

    An exception in the task propagates from `step` or `reset`. A `reset()` then begins anew, and
    `close` still works.

    Args:
        task: the task; one object for all environments.
        scenario: name of a shipped scenario, a YAML file, or (if the task keeps the scenario's
            controllers) a loaded `CompiledScenario`.
        num_envs: number of environments.
        overrides and the other keywords: see `skybody.options`.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        TypeError: the task is a class, or is not a PythonTask.
        ValueError: a number is out of range, or an unknown mode.
    """

    def __init__(
        self,
        task: PythonTask,
        scenario: Scenario,
        num_envs: int,
        *,
        overrides: options.Overrides = (),
        plugin_path: options.PluginPath = (),
        seed: options.Seed = 0,
        num_threads: options.NumThreads = 0,
        pin_threads: options.PinThreads = False,
        autoreset: options.AutoresetOption = "next_step",
        **unknown: Never,
    ) -> None:
        refuse_unknown(PythonTaskVectorEnv, unknown)
        _check_task(task)
        self._mode = autoreset_mode(autoreset)
        self.task = task
        self.pool = SimulationPool(
            scenario,
            num_envs,
            task.control,
            overrides=overrides,
            plugin_path=plugin_path,
            seed=seed,
            num_threads=num_threads,
            pin_threads=pin_threads,
        )
        self.num_envs = num_envs
        self.metadata = {"render_modes": [], "autoreset_mode": self._mode}
        self.single_observation_space = task.observation_space
        self.single_action_space = task.action_space
        self.observation_space = spaces.batch(task.observation_space, num_envs)
        self.action_space = spaces.batch(task.action_space, num_envs)
        self._action_shape = (num_envs, *task.action_space.shape)
        self._low, self._high = task.action_space.low, task.action_space.high
        self._command_size = _command_size(self.pool.compiled)
        self._steps = np.zeros(num_envs, np.int64)
        self._ended = np.zeros(num_envs, np.bool_)
        self._last = np.zeros((num_envs, *task.observation_space.shape), np.float32)
        self._rng = np.random.default_rng(check_seed(seed))
        self._ready = False
        try:
            task.setup(self.pool)
        except BaseException:
            self.pool.close()
            raise

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins new episodes; under a seed, its first ones.

        Args:
            options: {"reset_mask": (num_envs,) bool array} resets only these environments.

        Raises:
            TypeError: the mask is not a bool array.
            ValueError: a mask of another shape or without a True, with a seed, or after an
                exception; an unknown option.
        """
        mask = reset_mask(options, self.num_envs)
        if mask is None:
            mask = np.ones(self.num_envs, np.bool_)
        elif seed is not None or not self._ready:
            raise ValueError("reset all environments: leave out `reset_mask`")
        self._ready = False
        if seed is not None:
            self._rng = np.random.default_rng(check_seed(seed))
        self._begin(mask, seed)
        observation, bad = self._observation(self.pool.states(), mask)
        _demand_finite(bad)
        self._last = observation
        self._ready = True
        return observation.copy(), self._infos(mask, np.zeros(self.num_envs, np.bool_))

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.float32],
        NDArray[np.bool_],
        NDArray[np.bool_],
        dict[str, Any],
    ]:
        """One action in every environment; environments whose episode ended before are reset
        instead.

        Args:
            actions: (num_envs, A) float32, clipped to the task's action space.

        Raises:
            TypeError: another dtype.
            ValueError: another shape, an array of the task has a wrong shape, or the first
                observation of an episode is not finite.
            gymnasium.error.ResetNeeded: before `reset`, or after an exception.
        """
        if not self._ready:
            raise gymnasium.error.ResetNeeded("call reset() first: nothing is under way")
        given = check_array("actions", actions, self._action_shape, np.float32)
        if self._mode is AutoresetMode.DISABLED and self._ended.any():
            raise ValueError(
                f"the episode of environment {np.argmax(self._ended)} has ended: reset it by "
                'reset(options={"reset_mask": ...})'
            )
        self._ready = False
        fresh = self._ended.copy()
        flying = ~fresh
        if fresh.any():
            self._begin(fresh, None)
        bad = flying & ~np.isfinite(given).all(axis=1)
        given = np.clip(np.where(bad[:, None], 0, given), self._low, self._high)
        if flying.any():
            self._fly(given, flying)
        outcome = self._outcome(given, flying, bad)
        self._ready = True
        return outcome

    def _begin(self, mask: NDArray[np.bool_], seed: int | None) -> None:
        self.pool.reset(mask, seed)
        self.task.begin(self.pool, np.flatnonzero(mask).astype(np.int32), self._rng)
        self._steps[mask] = 0
        self._ended[mask] = False

    def _fly(self, actions: NDArray[np.float32], flying: NDArray[np.bool_]) -> None:
        commands = np.asarray(self.task.command(actions, self.pool.states()), np.float64)
        if self._command_size == 0:
            self.pool.command(commands)  # raises the error with the reason
        check_array("command()", commands, (self.num_envs, self._command_size))
        self.pool.command(commands[flying], envs=flying)
        self.pool.advance(self.task.physics_steps, flying)
        self._steps[flying] += 1

    def _outcome(
        self, actions: NDArray[np.float32], flying: NDArray[np.bool_], bad: NDArray[np.bool_]
    ) -> tuple[Any, ...]:
        states = self.pool.states()
        observation, unseen = self._observation(states, np.ones(self.num_envs, np.bool_))
        _demand_finite(unseen & ~flying)
        reward = self._float32("reward", self.task.reward(states, actions), (self.num_envs,))
        ends = check_array("terminated()", self.task.terminated(states), (self.num_envs,))
        fault = flying & (bad | unseen | ~np.isfinite(reward) | self.pool.faults)
        reward = np.where(flying & ~fault, reward, np.float32(0))
        terminated = ends.astype(np.bool_) & flying & ~fault
        truncated = fault | (flying & ~terminated & (self._steps >= self.task.horizon))
        self._last = observation
        self._ended = terminated | truncated
        final: dict[str, Any] = {}
        if self._mode is AutoresetMode.SAME_STEP and self._ended.any():
            final, states = self._begin_at_once(fault, states)
        infos = self._infos(np.ones(self.num_envs, np.bool_), fault, states)
        return self._last.copy(), reward, terminated, truncated, infos | final

    def _begin_at_once(
        self, fault: NDArray[np.bool_], states: EnvStates
    ) -> tuple[dict[str, Any], EnvStates]:
        """SAME_STEP: resets environments whose episode ended. Returns their last infos and the
        current states.
        """
        ended = self._ended.copy()
        rows = np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(ended):
            rows[i] = self._last[i].copy()
        final = {
            "final_obs": rows,
            "_final_obs": ended,
            "final_info": self._infos(ended, fault, states),
            "_final_info": ended,
        }
        self._begin(ended, None)
        states = self.pool.states()
        self._last, bad = self._observation(states, ended)
        _demand_finite(bad)
        return final, states

    def _observation(
        self, states: EnvStates, mask: NDArray[np.bool_]
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Observations of the environments in `mask`, and the last ones of the others. A row that
        is not finite is replaced by the last finite one; the second result marks such rows.
        """
        shape = self._last.shape
        rows = self._float32("observation", self.task.observation(states), shape)
        bad = mask & ~np.isfinite(rows).reshape(self.num_envs, -1).all(axis=1)
        rows[~mask | bad] = self._last[~mask | bad]
        return rows, bad

    @staticmethod
    def _float32(name: str, values: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float32]:
        """A new array; values beyond the range of float32 become infinite, hence a fault."""
        with np.errstate(over="ignore"):
            return check_array(name + "()", values, shape).astype(np.float32)

    def _infos(
        self,
        mask: NDArray[np.bool_],
        fault: NDArray[np.bool_],
        states: EnvStates | None = None,
    ) -> dict[str, Any]:
        infos: dict[str, Any] = {"fault": fault, "_fault": mask.copy()}
        for name, values in self.task.info(states or self.pool.states()).items():
            infos[name], infos[f"_{name}"] = values, mask.copy()
        return infos

    def state(self, path: str) -> NDArray[np.float64]:
        """A value of the state of every environment, (num_envs, *shape), as `make_vec(...).state`.

        Raises:
            ValueError: no such path; the nearest ones are named.
        """
        return self.pool.state(path)

    def state_paths(self) -> dict[str, _native.StateValue]:
        """All paths of `state`: path -> unit, frame, shape and meaning."""
        return self.pool.state_paths()

    def close_extras(self, **_: Any) -> None:
        """Ends the threads; called by `close`."""
        self.pool.close()
