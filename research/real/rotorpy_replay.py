"""Flies RotorPy's Crazyflie through windows: a program of the environment .peers/rotorpy.

    python rotorpy_replay.py INPUT.npz OUTPUT.npz

INPUT: start (windows, 13): position, quaternion w x y z, velocity (W), rates (B); commands
(windows, steps, 4): rotor speeds [rad/s] in the order front right, back right, back left, front
left; warm_up, marks: numbers of steps; step [s].
OUTPUT: states (windows, marks, 13), and constants; without windows the constants alone.
"""

from __future__ import annotations

import sys

import numpy as np
import torch
from rotorpy.vehicles.crazyflie_params import quad_params
from rotorpy.vehicles.multirotor import BatchedMultirotor, BatchedMultirotorParams

RPY = [3, 0, 1, 2]  # of the commands: its r1 is front left, then clockwise


def state_of(start: np.ndarray, speeds: np.ndarray) -> dict[str, torch.Tensor]:
    """A state of RotorPy."""
    values = {
        "x": start[:, :3],
        "q": start[:, [4, 5, 6, 3]],
        "v": start[:, 7:10],
        "w": start[:, 10:],
        "wind": np.zeros((len(start), 3)),
        "rotor_speeds": speeds,
    }
    return {name: torch.from_numpy(np.ascontiguousarray(v)) for name, v in values.items()}


def row_of(state: dict[str, torch.Tensor]) -> np.ndarray:
    """The 13 values of a state of RotorPy."""
    parts = [state[name].numpy() for name in ("x", "q", "v", "w")]
    parts[1] = parts[1][:, [3, 0, 1, 2]]
    return np.concatenate(parts, axis=1)


@torch.inference_mode()
def main() -> None:
    torch.set_default_dtype(torch.float64)
    torch.set_num_threads(1)
    given = np.load(sys.argv[1])
    commands, step = given["commands"][..., RPY], float(given["step"])
    count = len(commands)
    own = {**quad_params, "motor_noise_std": 0.0}
    constants = {"mass": own["mass"], "thrust_constant": own["k_eta"]}
    if count == 0:
        np.savez(sys.argv[2], **constants)
        return
    parameters = BatchedMultirotorParams([own] * count, count, torch.device("cpu"))
    state = state_of(given["start"], commands[:, 0])
    cpu = torch.device("cpu")
    vehicle = BatchedMultirotor(parameters, count, state, cpu, integrator="rk4")
    everyone = torch.arange(count)
    states = []
    for k in range(commands.shape[1]):
        if k == given["warm_up"]:  # the rotors turn as commanded; the body starts here
            state = state_of(given["start"], state["rotor_speeds"].numpy())
        control = {"cmd_motor_speeds": torch.from_numpy(np.ascontiguousarray(commands[:, k]))}
        state = vehicle.step(state, control, step, everyone)
        if k + 1 - given["warm_up"] in given["marks"]:
            states.append(row_of(state))
    np.savez(sys.argv[2], states=np.stack(states, axis=1), **constants)


if __name__ == "__main__":
    main()
