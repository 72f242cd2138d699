"""The QDrone2 as parameters of RotorPy, with RotorPy's own attitude loop."""

from __future__ import annotations

import importlib.metadata
import warnings
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from rotorpy.vehicles.multirotor import BatchedMultirotor, BatchedMultirotorParams

from research.transfer import rotation
from research.transfer.conditions import Truth
from research.transfer.inner_loop import DAMPING, STIFFNESS
from research.transfer.observation import Motion
from research.transfer.quadrotor import Quadrotor

Reals = NDArray[np.float64]
CPU = torch.device("cpu")
ABSENT = ("c_Dx", "c_Dy", "c_Dz", "k_z", "k_h", "k_flap", "Ixy", "Iyz", "Ixz", "motor_noise_std")


def parameters(
    quad: Quadrotor, mass: float, inertia: Reals, thrust: float, lag: float
) -> dict[str, Any]:
    """A parameter file of RotorPy. Its motors lag by the mean of ours, up and down."""
    principal = quad.inertia * inertia
    return dict.fromkeys(ABSENT, 0.0) | {
        "mass": float(quad.mass * mass),
        "Ixx": float(principal[0]),
        "Iyy": float(principal[1]),
        "Izz": float(principal[2]),
        "num_rotors": 4,
        "rotor_pos": {f"r{k + 1}": hub for k, hub in enumerate(quad.hubs)},
        "rotor_directions": -quad.turns,
        "k_eta": float(quad.thrust * thrust),
        "k_m": float(quad.moment * thrust),
        "k_d": quad.drag,
        "tau_m": float(0.5 * (quad.tau_up + quad.tau_down) * lag),
        "rotor_speed_min": 0.0,
        "rotor_speed_max": quad.max_speed,
        "kp_att": STIFFNESS[0],
        "kd_att": DAMPING[0],
    }


class Engine:
    """N vehicles as a batch, by RK4."""

    name = f"RotorPy {importlib.metadata.version('rotorpy')}"

    def __init__(self, quad: Quadrotor, truth: Truth, dt: float) -> None:
        warnings.simplefilter("ignore")
        torch.set_default_dtype(torch.float64)
        torch.set_num_threads(1)
        self.quad, self.dt, self.count = quad, dt, len(truth.mass)
        # RotorPy's rotors are equal: differences between rotors become shares of their commands.
        mean = truth.thrust.mean(axis=1)
        self.shares = np.sqrt(truth.thrust / mean[:, None])
        true = [
            parameters(quad, truth.mass[k], truth.inertia[k], mean[k], truth.lag[k])
            for k in range(self.count)
        ]
        nominal = [parameters(quad, 1.0, np.ones(3), 1.0, 1.0)] * self.count
        self.everyone = torch.arange(self.count)
        self.vehicles = self._batch(true, "cmd_motor_speeds")
        self.autopilots = self._batch(nominal, "cmd_acc")

    def _batch(self, constants: list[dict[str, Any]], commands: str) -> Any:
        nothing = {"x": torch.zeros(self.count, 3)}
        batch = BatchedMultirotorParams(constants, self.count, CPU)
        return BatchedMultirotor(batch, self.count, nothing, CPU, commands, True, "rk4")

    def start(self, position: Reals) -> None:
        """At rest and level, rotors at their hover speed."""
        level = torch.zeros(self.count, 4)
        level[:, 3] = 1.0
        self.state = {
            "x": torch.from_numpy(position.copy()),
            "v": torch.zeros(self.count, 3),
            "q": level,
            "w": torch.zeros(self.count, 3),
            "wind": torch.zeros(self.count, 3),
            "rotor_speeds": torch.full((self.count, 4), self.quad.hover_speed),
        }
        self._read()

    @torch.inference_mode()
    def step(self, commands: Reals, wind: Reals) -> None:
        """One step of physics. commands: (N, 4) [rad/s]; wind: W (N, 3) [m/s]."""
        self.state["wind"] = torch.from_numpy(wind.copy())
        control = {"cmd_motor_speeds": torch.from_numpy(commands * self.shares)}
        self.state = self.vehicles.step(self.state, control, self.dt, self.everyone)
        self._read()

    def _read(self) -> None:
        position, velocity, rates = (self.state[name].numpy() for name in ("x", "v", "w"))
        attitude = rotation.matrix(self.state["q"].numpy()[:, [3, 0, 1, 2]])
        self.motion = Motion(position, velocity, attitude, rates)

    @torch.inference_mode()
    def inner_loop(self, force: Reals, attitude: Reals, rates: Reals) -> Reals:
        """Rotor speeds for a force, by RotorPy's `cmd_acc` with nominal constants."""
        state = {
            "q": torch.from_numpy(rotation.of_matrix(attitude)[:, [1, 2, 3, 0]]),
            "w": torch.from_numpy(rates.copy()),
        }
        control = {"cmd_acc": torch.from_numpy(force / self.quad.mass)}
        speeds: Reals = self.autopilots.get_cmd_motor_speeds(state, control, self.everyone).numpy()
        return np.clip(speeds, 0.0, self.quad.max_speed)

    def close(self) -> None:
        """Nothing to close."""
