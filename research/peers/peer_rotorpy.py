"""RotorPy: its batched vehicle (PyTorch, RK4) and its single one (SciPy), stepped by themselves.

Aerodynamics are off, since there is no wind here. The batched vehicle uses double precision.
PyTorch needs no gradients; it is tried with one thread and with two.
"""

from __future__ import annotations

import functools
import importlib.metadata
import warnings
from typing import Any

import measure
import numpy as np
import torch
import vehicle
from rotorpy.vehicles.multirotor import BatchedMultirotor, BatchedMultirotorParams, Multirotor

DIFFERS = "no contact; no reward, ends or resets; one motor time constant (ours has two)"
STATES = ("x", "q", "v", "w")
HEIGHT = 1.5  # [m]
CPU = torch.device("cpu")
NO_AERODYNAMICS = ("c_Dx", "c_Dy", "c_Dz", "k_d", "k_z", "k_h", "k_flap")


def peer() -> measure.Peer:
    version = importlib.metadata.version("rotorpy")
    return measure.Peer("RotorPy", version, f"PyTorch {torch.__version__}", DIFFERS)


def qdrone2() -> dict[str, Any]:
    """The QDrone2 as its parameters. Its motors have one time constant: the one for speeding up."""
    quad = vehicle.qdrone2()
    ixx, iyy, izz = quad.base.inertia
    parameters: dict[str, Any] = {
        "mass": quad.base.mass,
        "Ixx": ixx,
        "Iyy": iyy,
        "Izz": izz,
        "Ixy": 0.0,
        "Iyz": 0.0,
        "Ixz": 0.0,
        "num_rotors": len(quad.rotors),
        "rotor_pos": {f"r{k}": np.array(rotor.position) for k, rotor in enumerate(quad.rotors)},
        "rotor_directions": np.array([-rotor.direction for rotor in quad.rotors]),
        "k_eta": quad.thrust_constant,
        "k_m": quad.moment_constant,
        "tau_m": quad.tau_up,
        "rotor_speed_min": 0.0,
        "rotor_speed_max": quad.max_speed,
        "motor_noise_std": 0.0,
    }
    return parameters | dict.fromkeys(NO_AERODYNAMICS, 0.0)


def hovering() -> dict[str, np.ndarray]:
    """A state in the air."""
    return {
        "x": np.array([0.0, 0.0, HEIGHT]),
        "v": np.zeros(3),
        "q": np.array([0.0, 0.0, 0.0, 1.0]),
        "w": np.zeros(3),
        "wind": np.zeros(3),
        "rotor_speeds": np.full(4, vehicle.qdrone2().hover_speed()),
    }


class Single:
    """One quadrotor. SciPy's RK45 is adaptive: with the whole step as first step, it takes one."""

    def __init__(self) -> None:
        self.state = hovering()
        self.vehicle = Multirotor(
            qdrone2(),
            self.state,
            aero=False,
            integrator_kwargs={"method": "RK45", "first_step": vehicle.DT},
        )
        self.commands = self.state["rotor_speeds"].copy()

    def __call__(self) -> np.ndarray:
        control = {"cmd_motor_speeds": self.commands}
        self.state = self.vehicle.step(self.state, control, vehicle.DT)
        return np.concatenate([self.state[name] for name in STATES])[None]


class Batch:
    """A batch of quadrotors."""

    def __init__(self, envs: int) -> None:
        self.state = {
            name: torch.from_numpy(np.tile(value, (envs, 1))) for name, value in hovering().items()
        }
        parameters = BatchedMultirotorParams([qdrone2()] * envs, envs, CPU)
        self.vehicle = BatchedMultirotor(
            parameters, envs, self.state, CPU, aero=False, integrator="rk4"
        )
        self.commands = self.state["rotor_speeds"].numpy().copy()
        self.everyone = torch.arange(envs)  # the default, a list, halves the speed

    @torch.inference_mode()
    def __call__(self) -> np.ndarray:
        control = {"cmd_motor_speeds": torch.from_numpy(self.commands)}
        self.state = self.vehicle.step(self.state, control, vehicle.DT, self.everyone)
        return torch.cat([self.state[name] for name in STATES], 1).numpy()


@torch.inference_mode()
def check(worlds: Single | Batch) -> None:
    before = worlds()
    measure.require(bool(np.abs(before[:, 2] - HEIGHT).max() < 0.5), "a vehicle did not hover")
    worlds.commands *= 1.1**0.5
    worlds.state["rotor_speeds"][:] *= 1.1**0.5  # at once: a lag would take many slow steps
    steps = 5
    for _ in range(steps):
        after = worlds()
    measure.require_climb((after[:, 9] - before[:, 9]).min(), steps * vehicle.DT)


def single(effort: measure.Effort) -> None:
    worlds = Single()
    peer().row(
        worlds,
        effort,
        mode="Multirotor.step",
        cores=1,
        differs="adaptive RK45",
        check=functools.partial(check, worlds),
    )


def batch(effort: measure.Effort, envs: int, threads: int) -> None:
    torch.set_num_threads(threads)
    worlds = Batch(envs)
    peer().row(
        worlds,
        effort,
        mode=f"BatchedMultirotor.step, {threads} thread{'s' if threads > 1 else ''}",
        cores=threads,
        envs=envs,
        differs="RK4",
        check=functools.partial(check, worlds),
    )


def main() -> None:
    effort = measure.parse(__doc__)
    measure.use_cores(2)
    warnings.simplefilter("ignore")
    peer().attempt("hover, 1", functools.partial(single, effort))
    for envs in effort.sizes(8192):
        for threads in (1, 2):
            peer().attempt(
                f"hover, {envs}, {threads} threads",
                functools.partial(batch, effort, envs, threads),
            )


if __name__ == "__main__":
    main()
