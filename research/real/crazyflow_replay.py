"""Flies Crazyflow's Crazyflie through windows: a program of the environment .peers/crazyflow.

    python crazyflow_replay.py INPUT.npz OUTPUT.npz

INPUT as for rotorpy_replay.py, with `dynamics`, the name of a model of Crazyflow. Commands of
first_principles: thrust of each rotor as a share of the greatest; of the others: roll, pitch, yaw
[rad], and the collective thrust as a share of the greatest.
"""

from __future__ import annotations

import contextlib
import os
import sys
from typing import Any

os.environ["JAX_PLATFORMS"] = "cpu"

import jax
import jax.numpy as jnp
import numpy as np

with contextlib.redirect_stdout(sys.stderr):  # it prints missing packages there
    import crazyflow.sim.functional as functional
    from crazyflow.control import Control
    from crazyflow.control.transform import motor_force2rotor_vel, pwm2force
    from crazyflow.drones import Drone
    from crazyflow.dynamics import Dynamics
    from crazyflow.dynamics.core import load_params
    from crazyflow.sim import Sim

DRONE = Drone.cf2x_L250
ROTORS = 4
XYZW, WXYZ = np.array([1, 2, 3, 0]), np.array([3, 0, 1, 2])


def commands_of(model: Dynamics, parameters: dict[str, Any], given: np.ndarray) -> np.ndarray:
    """Commands as the model takes them: speeds [rpm], or angles [rad] and thrust [N]."""
    greatest = float(parameters["thrust_max"])
    if model == Dynamics.first_principles:
        forces = pwm2force(given, greatest, 1.0)
        return np.asarray(motor_force2rotor_vel(forces, np.array([parameters["rpm2thrust"]])))
    thrust = pwm2force(given[..., 3:], ROTORS * greatest, 1.0)
    return np.concatenate([given[..., :3], thrust], axis=-1)


def placed(data: Any, start: np.ndarray) -> Any:
    """The data with the bodies at their starts; the rotors turn as before."""
    parts = {
        "pos": start[:, :3],
        "quat": start[:, 3:7][:, XYZW],
        "vel": start[:, 7:10],
        "ang_vel": start[:, 10:],
    }
    arrays = {name: jnp.asarray(part[:, None], jnp.float32) for name, part in parts.items()}
    return data.replace(states=data.states.replace(**arrays))


def steady(data: Any, model: Dynamics, commands: np.ndarray) -> Any:
    """The data with rotors that have reached the first commands."""
    first = commands[:, 0] if model == Dynamics.first_principles else commands[:, 0, 3:]
    speeds = np.broadcast_to(first, (len(first), ROTORS))
    arrays = jnp.asarray(speeds[:, None], jnp.float32)
    return data.replace(states=data.states.replace(rotor_vel=arrays))


def main() -> None:
    given = np.load(sys.argv[1])
    model = Dynamics(str(given["dynamics"]))
    parameters = load_params(model, DRONE)
    constants = {name: parameters[name] for name in ("mass", "thrust_max")}
    constants["factor"] = parameters.get("cmd_f_coef", 1.0)
    if len(given["start"]) == 0:
        np.savez(sys.argv[2], **constants)
        return
    commands = commands_of(model, parameters, given["commands"])
    is_motor = model == Dynamics.first_principles
    sim = Sim(
        n_worlds=len(commands),
        drone=DRONE,
        dynamics=model,
        control=Control.rotor_vel if is_motor else Control.attitude,
        freq=round(1.0 / float(given["step"])),
        attitude_freq=round(1.0 / float(given["step"])),
        device="cpu",
    )
    control = functional.rotor_vel_control if is_motor else functional.attitude_control
    step = sim.build_step_fn()

    @jax.jit
    def fly(data: Any, row: jax.Array) -> Any:
        return step(control(data, row), 1)

    data = placed(sim.data, given["start"])
    if model != Dynamics.so_rpy:
        data = steady(data, model, commands)
    states = []
    for k in range(commands.shape[1]):
        if k == given["warm_up"]:
            data = placed(data, given["start"])
        data = fly(data, jnp.asarray(commands[:, k, None], jnp.float32))
        if k + 1 - given["warm_up"] in given["marks"]:
            now = data.states
            parts = (now.pos, now.quat[..., WXYZ], now.vel, now.ang_vel)
            states.append(np.asarray(jnp.concatenate(parts, -1), np.float64)[:, 0])
    np.savez(sys.argv[2], states=np.stack(states, axis=1), **constants)


if __name__ == "__main__":
    main()
