"""L2F (rl-tools) through its Python module: batches whose size is fixed at compile time.

It steps into a second batch of states, so two batches alternate, as in its own example.
Its environments are distributed over OpenMP threads: measured on one and on two. States are
returned as its observation: 82 numbers, including the last 16 actions; a second row omits that.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.metadata
import json

import l2f
import measure
import numpy as np
import vehicle

DIFFERS = "RK4, float32; no contact; no ends or resets"
SIZES = (1, 16, 128, 256, 512, 1024, 2048, 4096, 8192)
QUICK_SIZES = (1, 256, 1024, 4096)
HEIGHT = 1.5  # [m]


def peer() -> measure.Peer:
    version = importlib.metadata.version("l2f")
    return measure.Peer("L2F", version, f"L2F {version}", DIFFERS)


def use_threads(count: int) -> None:
    """Number of OpenMP threads for later calls: the module itself has no such setting."""
    ctypes.CDLL("libgomp.so.1").omp_set_num_threads(count)


def diagonal(values: list[float]) -> list[list[float]]:
    return [[value * (i == j) for j in range(3)] for i, value in enumerate(values)]


def qdrone2(text: str) -> str:
    """Its parameters as JSON, with the QDrone2's numbers. Rotor speeds range from 0 to 1 there."""
    quad, parameters = vehicle.qdrone2(), json.loads(text)
    rotors, inertia = range(len(quad.rotors)), quad.base.inertia
    parameters["integration"]["dt"] = vehicle.DT
    parameters["dynamics"] |= {
        "rotor_positions": [rotor.position for rotor in quad.rotors],
        "rotor_torque_directions": [[0, 0, -rotor.direction] for rotor in quad.rotors],
        "rotor_thrust_coefficients": [
            [0, 0, quad.thrust_constant * quad.max_speed**2] for _ in rotors
        ],
        "rotor_torque_constants": [quad.moment_ratio for _ in rotors],
        "rotor_time_constants_rising": [quad.tau_up for _ in rotors],
        "rotor_time_constants_falling": [quad.tau_down for _ in rotors],
        "mass": quad.base.mass,
        "gravity": [0, 0, -vehicle.GRAVITY],
        "J": diagonal(list(inertia)),
        "J_inv": diagonal([1 / value for value in inertia]),
        "hovering_throttle_relative": quad.hover_speed() / quad.max_speed,
    }
    return json.dumps(parameters)


class Batch:
    """A batch of hovering quadrotors."""

    def __init__(self, envs: int, observe: bool) -> None:
        self.kind = getattr(l2f, f"vector{envs}")
        self.device, self.observe = l2f.Device(), observe
        self.rng, self.env = self.kind.VectorRng(), self.kind.VectorEnvironment()
        self.parameters = self.kind.VectorParameters()
        self.now, self.next = self.kind.VectorState(), self.kind.VectorState()
        self.kind.initialize_rng(self.device, self.rng, 0)
        self.kind.initialize_environment(self.device, self.env)
        self.kind.initial_parameters(self.device, self.env, self.parameters)
        self.set_vehicle()
        self.kind.initial_state(self.device, self.env, self.parameters, self.now)
        for state in self.now.states:
            state.position = [0, 0, HEIGHT]
        self.actions = np.empty((envs, 4), np.float32)
        self.command(vehicle.qdrone2().hover_speed())
        self.observation = np.zeros((envs, self.env.OBSERVATION_DIM), np.float32)

    def set_vehicle(self) -> None:
        environments, parameters = self.env.environments, self.parameters.parameters
        text = qdrone2(l2f.parameters_to_json(self.device, environments[0], parameters[0]))
        for compiled, own in zip(environments, parameters, strict=True):
            l2f.parameters_from_json(self.device, compiled, text, own)

    def command(self, speed: float) -> None:
        """Sets rotor speeds [rad/s]; actions range from -1 at zero to 1 at the maximum."""
        self.actions[:] = 2 * speed / vehicle.qdrone2().max_speed - 1

    def __call__(self) -> None:
        self.kind.step(
            self.device, self.env, self.parameters, self.now, self.actions, self.next, self.rng
        )
        self.now, self.next = self.next, self.now
        if self.observe:
            self.kind.observe(
                self.device, self.env, self.parameters, self.now, self.observation, self.rng
            )

    def check(self) -> None:
        last = self.now.states[-1]
        measure.require(abs(last.position[2] - HEIGHT) < 0.5, "a vehicle did not hover")
        before, steps = last.linear_velocity[2], 500
        self.command(1.1**0.5 * vehicle.qdrone2().hover_speed())
        for _ in range(steps):
            self()
        climbed = self.now.states[-1].linear_velocity[2] - before
        measure.require_climb(climbed, steps * vehicle.DT)


def row(effort: measure.Effort, envs: int, threads: int, observe: bool) -> None:
    use_threads(threads)
    batch = Batch(envs, observe)
    peer().row(
        batch,
        effort,
        mode=("step, observe" if observe else "step")
        + f", {threads} thread{'s' if threads > 1 else ''}",
        cores=threads,
        envs=envs,
        differs="82 numbers observed" if observe else "states not returned",
        check=batch.check,
    )


def main() -> None:
    effort = measure.parse(__doc__)
    measure.use_cores(2)
    sizes = QUICK_SIZES if effort.quick else SIZES
    for threads in (1, 2):
        for envs in sizes[-1:] if effort.quick and threads > 1 else sizes:
            for observe in (False, True):
                peer().attempt(
                    f"hover, {envs}, {threads} threads",
                    functools.partial(row, effort, envs, threads, observe),
                )


if __name__ == "__main__":
    main()
