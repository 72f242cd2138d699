"""The engine's models of the vehicle: the shipped Crazyflie, or the folder of an identified one."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import skybody
from skybody import SimulationPool

from research.real import curves
from research.real.models import MARKS, SPEEDS, WARM_STEPS
from research.real.recorded_flights import MOTORS, Reals, Recorded
from research.real.windows import STEP, Windows

DT = 0.001  # physics step [s]

SCENARIO = f"""
name: replay
stepping: {{dt: {DT}, action_repeat: 1}}
contact: {{ground: false}}
robots:
  - name: vehicle
    model: models/crazyflie/crazyflie.urdf
    pose: {{position: [0, 0, 10]}}
    rotor_speed: hover
    controllers: [{{plugin: rotor_speed}}]
task: {{plugin: watch, parameters: {{link: base_link}}}}
"""


# The shipped model without a part, by titles of tables.
PARTS: dict[str, dict[str, float]] = {
    "no drag of rotors": {"drag_constant": 0.0},
    "hubs at the height of the centre": {"position[2]": 0.0},
    "rotors without lag": {"tau_up": 0.0, "tau_down": 0.0},
    "rotors without inertia": {"inertia": 0.0},
}


class Shipped:
    """The shipped model `crazyflie`.

    Args:
        title: its name in tables.
        changes: values of the rotors' parameters by name, of a model that lacks a part.
    """

    inputs = SPEEDS
    trims = True
    is_damped = True

    def __init__(
        self, title: str = "Skybody `crazyflie`", changes: Mapping[str, float] | None = None
    ) -> None:
        self.title, self.changes = title, changes or {}
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "replay.yaml"
            file.write_text(SCENARIO, encoding="utf-8")
            self.compiled = skybody.CompiledScenario(file)

    def takes(self, flight: Recorded) -> bool:
        return True

    def commands(self, windows: Windows, factors: Reals) -> Reals:
        return windows.on_grid(np.sqrt(factors) * curves.speed(windows.flight.pwm))

    def thrusts(self, flight: Recorded) -> Reals:
        return self.thrusts_of(curves.speed(flight.pwm))

    def thrusts_of(self, speeds: Reals) -> Reals:
        """As `thrusts`, of rotor speeds [rad/s], (rows, 4)."""
        return thrusts(self.compiled, speeds)

    def fly(self, starts: Reals, commands: Reals) -> Reals:
        return fly(self.compiled, starts, commands, self.changes)


def fly(
    compiled: skybody.CompiledScenario,
    starts: Reals,
    commands: Reals,
    changes: Mapping[str, float],
) -> Reals:
    """As Model.fly, by a pool of environments whose robot takes rotor speeds.

    Args:
        commands: speeds in the order of MOTORS [rad/s].
        changes: values of the rotors' parameters by name.
    """
    rows = commands[..., order_of(compiled)]
    steps = round(STEP / compiled.dt)
    states = []
    pool = SimulationPool(compiled, len(starts))
    with pool:
        change(pool, changes)
        begin(pool, rows[:, 0])
        for k in range(rows.shape[1]):
            if k == WARM_STEPS:
                place(pool, starts)
            pool.command(rows[:, k])
            pool.advance(steps)
            if k + 1 - WARM_STEPS in MARKS:
                states.append(now(pool))
    return np.stack(states, axis=1)


def change(pool: SimulationPool, changes: Mapping[str, float]) -> None:
    """Sets parameters of all rotors in all environments."""
    for path in pool.compiled.param_paths:
        _, is_rotor, name = path.partition(".rotors[")
        value = changes.get(name.partition("].")[2])
        if is_rotor and value is not None:
            for env in range(pool.num_envs):
                pool.set_param(env, path, value)


def begin(pool: SimulationPool, speeds: Reals) -> None:
    """Begins episodes with given speeds of the rotors, (environments, rotors)."""
    paths = [path for path in pool.compiled.param_paths if path.endswith("].speed")]
    for env, row in enumerate(speeds):
        for path, speed in zip(paths, row, strict=True):
            pool.set_param(env, path, min(speed, pool.compiled.param_info(path)[2]))
    pool.reset()


def order_of(compiled: skybody.CompiledScenario) -> list[int]:
    """Places in MOTORS of the rotors of the model.

    Raises:
        InputError: its rotors have other names.
    """
    names = [rotor.name.partition(".")[2] for rotor in compiled.rotors]
    if sorted(names) != sorted(MOTORS):
        raise skybody.InputError(
            f"{compiled.file}: has rotors {', '.join(names)}; needed: {', '.join(MOTORS)}"
        )
    return [MOTORS.index(name) for name in names]


def place(pool: SimulationPool, starts: Reals) -> None:
    """Puts the bodies at their starts; the rotors turn as before."""
    for env, start in enumerate(starts):
        pool.teleport(env, start[:3], start[3:7], start[7:10], start[10:])


def now(pool: SimulationPool) -> Reals:
    """States of all bodies as Recorded.states; a diverged one is NaN."""
    s = pool.states()
    parts = (s.positions, s.rotations, s.velocities, s.angular_velocities)
    states = np.concatenate([part[:, 0] for part in parts], axis=1)
    states[pool.faults] = np.nan
    return states


def thrusts(compiled: skybody.CompiledScenario, speeds: Reals) -> Reals:
    """Thrust over mass of each rotor with quadratic thrust [m/s^2], in the order of MOTORS.

    Args:
        speeds: (rows, 4), in the order of MOTORS [rad/s].
    """
    places = [order_of(compiled).index(k) for k in range(len(MOTORS))]
    paths = compiled.param_paths
    constants = np.array([compiled.rotors[k].thrust_constant for k in places])
    limits = [compiled.param_info(path)[0] for path in paths if path.endswith(".max_speed")]
    mass = sum(compiled.param_info(path)[0] for path in paths if path.endswith(".mass"))
    held = np.minimum(speeds, np.array(limits)[places])
    return np.asarray(constants / mass * held**2)
