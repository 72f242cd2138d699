"""Direct control of one environment or of many: physical commands, physics steps, states."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, Never

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native, options
from ._native import CompiledScenario
from .arguments import (
    MOST_ENVS,
    MOST_THREADS,
    Scenario,
    check_array,
    check_seed,
    env_ids,
    flag,
    integer,
    integer_within,
    load,
    text,
)
from .options import refuse_unknown
from .requests import Change, When, at_reset, request_lines

CONTROL_MODES: dict[str, str] = {
    "rotor_speed": "[{plugin: rotor_speed}]",
    "srt": "[{plugin: srt}]",
    "throttle": "[{plugin: throttle}]",
    "ctbt": "[{plugin: ctbt}]",
    "ctbr": "[{plugin: ctbr}]",
    "wrench": "[{plugin: wrench}]",
    "velocity": "[{plugin: velocity}]",
    "pose": "[{plugin: velocity, parameters: {form: position}}]",
    "attitude": "[{plugin: attitude}, {plugin: ctbr}]",
    "force": "[{plugin: force}, {plugin: attitude}, {plugin: ctbr}]",
    "acceleration": "[{plugin: acceleration}, {plugin: force}, {plugin: attitude}, {plugin: ctbr}]",
    "velocity_tracking": "[{plugin: velocity_tracking}, {plugin: acceleration}, {plugin: force}, "
    "{plugin: attitude}, {plugin: ctbr}]",
    "position": "[{plugin: position}, {plugin: attitude}, {plugin: ctbr}]",
    "trajectory": "[{plugin: geometric}, {plugin: ctbt}]",
}
"""Controllers of each value of `control`; for their commands see docs/control-modes.md."""

_TERMINATED, _TRUNCATED, _FAULT = 1, 2, 4  # bits of `status`


def load_with_control(
    scenario: Scenario,
    control: str | None,
    overrides: Iterable[str],
    plugin_path: Iterable[str | os.PathLike[str]],
) -> CompiledScenario:
    """Loads a scenario and replaces the controllers of all its robots.

    Args:
        control: one of CONTROL_MODES, or a list of controllers as in a scenario's YAML; None: the
            scenario's own.
        overrides: applied after `control`.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        TypeError: control is not a string.
        ValueError: an unknown mode, or changes to a compiled scenario.
    """
    if control is None:
        return load(scenario, overrides, plugin_path)
    if not isinstance(control, str):
        raise TypeError(
            f"control is {control!r}; it must be a text: one of {', '.join(CONTROL_MODES)}, or a "
            "list as in YAML"
        )
    chain = CONTROL_MODES.get(control, control)
    if not chain.lstrip().startswith("["):
        raise ValueError(
            f"control is {control!r}; it must be one of {', '.join(CONTROL_MODES)}, or a list as "
            "in YAML, such as '[{plugin: ctbr, parameters: {apply: body}}]'"
        )
    if isinstance(scenario, CompiledScenario):
        raise ValueError(
            f"`{scenario.name}` is loaded already, control comes too late: give the scenario's name"
        )
    robots = load(scenario, (), plugin_path).robots
    chains = [f"robots.{robot}.controllers={chain}" for robot in robots]
    return load(scenario, [*chains, *overrides], plugin_path)


def _floats(values: ArrayLike | None) -> NDArray[np.float64] | None:
    return None if values is None else np.asarray(values, np.float64)


class Simulation(_native.Simulation):
    """One environment under direct control.

    Step it like a learner, by `step(action)`, or by hand: `command(values)` in the units of the
    control mode, `advance(n)` physics steps, `evaluate()` to evaluate the task.
    Frames: world (z up), body (x forward, y left, z up); SI units. One Python thread at a time.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `CompiledScenario`.
        control: one of `CONTROL_MODES` ("ctbr", "position", ...) for all robots, or a list of
            controllers as in YAML; None: the scenario's own.
        overrides and the other keywords: see `skybody.options`.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: an unknown mode, or a seed out of range.
    """

    def __init__(
        self,
        scenario: Scenario,
        control: str | None = None,
        *,
        overrides: options.Overrides = (),
        plugin_path: options.PluginPath = (),
        seed: options.Seed = 0,
        env_id: options.EnvId = 0,
        **unknown: Never,
    ) -> None:
        refuse_unknown(Simulation, unknown)
        compiled = load_with_control(scenario, control, overrides, plugin_path)
        super().__init__(compiled, check_seed(seed) or 0, env_id)

    def command(self, values: ArrayLike, robot: str = "") -> None:
        """Sets the commands of a robot's controller chains, in order; held until the next command.

        Args:
            values: (command_size,), in the units of the control mode. Controllers limit them to
                the robot's capabilities. A reset sets zeros, a `step` its own commands.
            robot: optional if there is only one.

        Raises:
            ValueError: another shape, a value that is not finite, no such robot, before `reset`.
        """
        super().command(np.asarray(values, np.float64), robot)

    def teleport(
        self,
        position: ArrayLike | None = None,
        rotation: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        angular_velocity: ArrayLike | None = None,
        robot: str = "",
    ) -> None:
        """Sets the state of a robot's floating base. Omitted values are unchanged, as are joints,
        rotors, other robots and the sensors' last outputs.

        Args:
            position: (3,) world [m].
            rotation: (4,) quaternion w x y z, world from body, any length but 0.
            velocity: (3,) world [m/s].
            angular_velocity: (3,) body axes [rad/s].
            robot: optional if there is only one.

        Raises:
            ValueError: another shape, a value that is not finite, a fixed base, before `reset`.
        """
        super().teleport(
            _floats(position),
            _floats(rotation),
            _floats(velocity),
            _floats(angular_velocity),
            robot,
        )

    def set_mass_properties(
        self,
        link: str,
        *,
        mass: float | None = None,
        com: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
        robot: str = "",
    ) -> None:
        """Changes the body of a link; controllers keep using the nominal values.

        Args:
            mass: [kg].
            com: (3,) centre of mass in the body's frame [m].
            inertia: (3, 3) about the centre of mass, body axes [kg m^2].

        Raises:
            ValueError: the values are not physical for a rigid body, or no such link.
        """
        super().set_mass_properties(
            link, mass=mass, com=_floats(com), inertia=_floats(inertia), robot=robot
        )

    def image(self, column: str) -> NDArray[Any]:
        """An image that the scenario observes, as its sensor last made it; a copy.

        Args:
            column: its name in the observation, such as `front.depth`.

        Returns:
            (height, width, channels), in the type of the column.

        Raises:
            ValueError: no such image.
        """
        images = {c.name: c for c in self.compiled.observation_columns if c.image >= 0}
        if column not in images:
            raise ValueError(f"no image `{column}`; there are: {', '.join(images) or 'none'}")
        found = images[column]
        pixels: NDArray[Any] = self.image_bytes(found.image).view(found.dtype)
        return pixels.reshape(found.shape)

    def request(self, changes: Mapping[str, Change], when: When = "next_step") -> None:
        """Requests values of randomizable parameters, applied with the next `step` or `advance`, or
        in the next `reset`. Values and errors: `skybody.vector.SkybodyVectorEnv.request`.
        """
        super().request_lines(request_lines(self.compiled, changes), at_reset(when))

    def state_paths(self) -> dict[str, _native.StateValue]:
        """All paths of `state`: path -> unit, frame, shape and meaning."""
        return self.compiled.state_values

    def fork(self, rekey: bool = False) -> Simulation:
        """A copy with the same future; with `rekey` it draws its own random numbers."""
        copy = type(self)(self.compiled)
        copy.restore(super().fork(rekey).save())
        return copy


class EnvStates(NamedTuple):
    """States of some environments, one row each; float64, copies. B bodies, R rotors each."""

    positions: NDArray[np.float64]
    """(n, B, 3): origins of the bodies, world axes [m]."""
    rotations: NDArray[np.float64]
    """(n, B, 4): unit quaternions w x y z, world from body."""
    velocities: NDArray[np.float64]
    """(n, B, 3): velocities of the origins, world axes [m/s]."""
    angular_velocities: NDArray[np.float64]
    """(n, B, 3): body axes [rad/s]."""
    rotor_speeds: NDArray[np.float64]
    """(n, R) [rad/s]."""
    times: NDArray[np.float64]
    """(n,): time since each environment's reset [s]."""


class SimulationPool(_native.SimulationPool):
    """Environments of one scenario under direct control, on several threads, with batched calls.

    Calls that step or reset environments run on all threads, without the GIL, and wait for all
    environments. If one fails the others finish; the error names the first that failed. No
    environment resets itself. The result of an environment depends only on its key and its own
    calls.

    `envs` is always None for all, a (num_envs,) bool mask, or indices, each at most once.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `CompiledScenario`.
        num_envs: number of environments.
        control: as for `Simulation`.
        overrides and the other keywords: see `skybody.options`.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: an unknown mode, or a number out of range.
    """

    def __init__(
        self,
        scenario: Scenario,
        num_envs: int,
        control: str | None = None,
        *,
        overrides: options.Overrides = (),
        plugin_path: options.PluginPath = (),
        seed: options.Seed = 0,
        num_threads: options.NumThreads = 0,
        pin_threads: options.PinThreads = False,
        first_env_id: options.FirstEnvId = 0,
        **unknown: Never,
    ) -> None:
        refuse_unknown(SimulationPool, unknown)
        compiled = load_with_control(scenario, control, overrides, plugin_path)
        super().__init__(
            compiled,
            integer_within("num_envs", num_envs, 1, MOST_ENVS),
            check_seed(seed) or 0,
            first_env_id,
            flag("pin_threads", pin_threads),
            integer_within("num_threads", num_threads, 0, MOST_THREADS),
        )

    def _ids(self, envs: ArrayLike | None) -> NDArray[np.int32] | None:
        if envs is None:
            return None
        given = np.asarray(envs)
        if given.dtype != np.bool_:
            return env_ids(given)
        mask = check_array("envs", given, (self.num_envs,))
        return np.flatnonzero(mask).astype(np.int32)

    def reset(self, envs: ArrayLike | None = None, seed: int | None = None) -> None:
        """Begins the next episode of some environments, or with a seed episode 1 under it."""
        super().reset(self._ids(envs), check_seed(seed))

    def step(self, actions: ArrayLike, envs: ArrayLike | None = None) -> None:
        """One step of each environment: action_repeat physics steps under an action.

        Args:
            actions: (n, action_size) in [-1, 1] (clipped). A value that is not finite ends the
                environment's episode as a fault.
        """
        super().step(np.asarray(actions, np.float32), self._ids(envs))

    def command(self, values: ArrayLike, robot: str = "", envs: ArrayLike | None = None) -> None:
        """Sets the command of a robot's controller chains; held until the next command.

        Args:
            values: (n, command_size), or (command_size,) for all of them, in the units of the
                control mode.

        Raises:
            ValueError: another shape, a value that is not finite, no such robot, before `reset`.
        """
        ids = self._ids(envs)
        rows = np.asarray(values, np.float64)
        if rows.ndim == 1:
            rows = np.tile(rows, (self.num_envs if ids is None else ids.size, 1))
        super().command(rows, robot, ids)

    def advance(self, physics_steps: int = 1, envs: ArrayLike | None = None) -> None:
        """Makes physics steps of each environment under its commands, without action and task.

        If the physics of an environment diverges, its episode ends as a fault: see `faults`.
        """
        super().advance(integer("physics_steps", physics_steps), self._ids(envs))

    def evaluate(self, envs: ArrayLike | None = None) -> None:
        """Ends a transition made by command and advance: evaluates the scenario's task."""
        super().evaluate(self._ids(envs))

    def teleport(
        self,
        env: int,
        position: ArrayLike | None = None,
        rotation: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        angular_velocity: ArrayLike | None = None,
        robot: str = "",
    ) -> None:
        """`Simulation.teleport` in one environment."""
        super().teleport(
            env,
            _floats(position),
            _floats(rotation),
            _floats(velocity),
            _floats(angular_velocity),
            robot,
        )

    def states(self, envs: ArrayLike | None = None) -> EnvStates:
        """Motion of all bodies and rotors of some environments."""
        of_all = (
            self.positions,
            self.rotations,
            self.velocities,
            self.angular_velocities,
            self.rotor_speeds,
            self.times,
        )
        ids = self._ids(envs)
        if ids is None:
            return EnvStates(*of_all)
        return EnvStates(*(values[ids] for values in of_all))

    def state(self, path: str, envs: ArrayLike | None = None) -> NDArray[np.float64]:
        """A value of some environments' state, a new array (n, *shape), as `make_vec(...).state`.

        Raises:
            ValueError: no such path; the nearest ones are named.
        """
        values, ids = super().state(text("path", path)), self._ids(envs)
        return values if ids is None else values[ids]

    def state_paths(self) -> dict[str, _native.StateValue]:
        """All paths of `state`: path -> unit, frame, shape and meaning."""
        return self.compiled.state_values

    def _has(self, bit: int) -> NDArray[np.bool_]:
        mask: NDArray[np.bool_] = (self.status & np.uint64(bit)) != 0
        return mask

    @property
    def terminated(self) -> NDArray[np.bool_]:
        """(num_envs,): the scenario's task ended the episode."""
        return self._has(_TERMINATED)

    @property
    def truncated(self) -> NDArray[np.bool_]:
        """(num_envs,): horizon, task or fault ended the episode."""
        return self._has(_TRUNCATED)

    @property
    def faults(self) -> NDArray[np.bool_]:
        """(num_envs,): the physics diverged, or an action was not finite."""
        return self._has(_FAULT)
