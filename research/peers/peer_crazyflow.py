"""Crazyflow on the CPU, by its functional interface: one compiled call sets rotor speeds, steps,
and returns the 13 states.

Besides the usual way it has sharding: worlds are distributed over devices, here over two devices
that JAX makes of the two cores. Compiling is not measured. The data that a call replaces are
donated to it, so that it need not allocate new ones. Precision is JAX's default, single.
"""

from __future__ import annotations

import contextlib
import functools
import importlib.metadata
import math
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import measure

CORES = measure.use_cores(2)  # before JAX starts its threads
os.environ["JAX_PLATFORMS"] = "cpu"
os.environ["XLA_FLAGS"] = f"--xla_force_host_platform_device_count={CORES}"

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
import vehicle  # noqa: E402

with contextlib.redirect_stdout(sys.stderr):  # it prints missing packages there
    import crazyflow.sim.functional as functional
    from crazyflow.control import Control
    from crazyflow.dynamics import Dynamics
    from crazyflow.sim import Sim
    from crazyflow.sim.integration import Integrator
    from crazyflow.sim.sharding import shard, world_mesh

DIFFERS = "float32; floor, but no contact; no reward, ends or resets"
HEIGHT = 1.5  # [m]
RPM = 60 / (2 * math.pi)  # of 1 rad/s


def peer() -> measure.Peer:
    version = importlib.metadata.version("crazyflow")
    return measure.Peer("Crazyflow", version, f"JAX {jax.__version__}", DIFFERS)


@dataclass(frozen=True)
class Work:
    """One row."""

    envs: int
    robots: int = 1
    substeps: int = 1
    sharded: bool = False

    @property
    def mode(self) -> str:
        return f"jitted call, worlds on {CORES} devices" if self.sharded else "jitted call"


def all_work(effort: measure.Effort) -> Iterator[Work]:
    """Compiling a row takes seconds: quick runs have only the best of each kind."""
    yield Work(1)
    if effort.quick:
        yield from (Work(1024), Work(65536, sharded=True))
        yield Work(8192, substeps=100, sharded=True)
    else:
        for envs in effort.sizes()[1:]:
            for sharded in (False, True):
                yield Work(envs, sharded=sharded)
                yield Work(envs, substeps=100, sharded=sharded)
    robots_of_rows = (measure.ROBOTS[0], measure.ROBOTS[-1]) if effort.quick else measure.ROBOTS
    for robots in robots_of_rows:
        yield Work(measure.ROBOT_WORLDS, robots=robots)
        if not effort.quick:
            yield Work(1024, robots=robots, sharded=True)


def qdrone2() -> dict[str, jax.Array]:
    """The QDrone2 as parameters of Crazyflow. Rotor speeds are in rpm there, and the mixing matrix
    contains the arms themselves, so that the common arm length is 1.
    """
    quad = vehicle.qdrone2()
    inertia = np.diag(quad.base.inertia)
    signs = [-rotor.direction for rotor in quad.rotors]
    values = {
        "mass": [quad.base.mass],
        "L": [1.0],
        "prop_inertia": [0.0],
        "gravity_vec": [0.0, 0.0, -vehicle.GRAVITY],
        "J": inertia,
        "J_inv": np.linalg.inv(inertia),
        "rpm2thrust": [[0.0, 0.0, quad.thrust_constant / RPM**2]],
        "rpm2torque": [[0.0, 0.0, quad.moment_constant / RPM**2]],
        "mixing_matrix": [*quad.mixer()[1:3], signs],
        "drag_matrix": np.zeros((3, 3)),
        "rotor_dyn_coef": [[1 / quad.tau_up, 0.0, 1 / quad.tau_down, 0.0]],
    }
    return {name: jnp.asarray(value, jnp.float32) for name, value in values.items()}


def hovering(sim: Sim) -> Any:
    """Data of Crazyflow with hovering QDrone2s."""
    data = sim.data
    speed = vehicle.qdrone2().hover_speed() * RPM
    states = data.states.replace(
        pos=data.states.pos.at[..., 2].set(HEIGHT),
        rotor_vel=jnp.full_like(data.states.rotor_vel, speed),
    )
    return data.replace(states=states, params=data.params.replace(**qdrone2()))


class Worlds:
    def __init__(self, work: Work) -> None:
        sim = Sim(
            n_worlds=work.envs,
            n_drones=work.robots,
            dynamics=Dynamics.first_principles,
            control=Control.rotor_vel,
            integrator=Integrator.symplectic_euler,
            freq=round(1 / vehicle.DT),
            device="cpu",
            fused_mjx_model=True,
        )
        self.data = hovering(sim)
        if work.sharded:
            self.data = shard(self.data, world_mesh(jax.devices()))
        self.commands = np.empty((work.envs, work.robots, 4), np.float32)
        self.commands[:] = vehicle.qdrone2().hover_speed() * RPM
        step = sim.build_step_fn()

        @functools.partial(jax.jit, donate_argnums=0)
        def fly(data: Any, commands: jax.Array) -> tuple[Any, jax.Array]:
            data = step(functional.rotor_vel_control(data, commands), work.substeps)
            now = data.states
            return data, jnp.concatenate([now.pos, now.quat, now.vel, now.ang_vel], -1)

        self.fly, self.substeps = fly, work.substeps

    def __call__(self) -> np.ndarray:
        """13 states of all robots, (envs, robots, 13)."""
        self.data, states = self.fly(self.data, self.commands)
        return np.asarray(states)

    def check(self) -> None:
        before = self()
        measure.require(bool(np.abs(before[..., 2] - HEIGHT).max() < 0.5), "a drone did not hover")
        self.commands *= 1.1**0.5
        calls = math.ceil(500 / self.substeps)
        for _ in range(calls):
            after = self()
        seconds = calls * self.substeps * vehicle.DT
        measure.require_climb((after[..., 9] - before[..., 9]).min(), seconds)


def row(effort: measure.Effort, work: Work) -> None:
    worlds = Worlds(work)
    peer().row(
        worlds,
        effort,
        mode=work.mode,
        cores=1 if work.envs == 1 else CORES,
        envs=work.envs,
        robots=work.robots,
        substeps=work.substeps,
        task="hover" if work.robots == 1 else "robots",
        check=worlds.check,
    )


def main() -> None:
    effort = measure.parse(__doc__)
    for work in all_work(effort):
        peer().attempt(str(work), functools.partial(row, effort, work))


if __name__ == "__main__":
    main()
