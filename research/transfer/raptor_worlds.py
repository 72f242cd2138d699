"""The same quadrotors in two engines: ours, and L2F, which shares no code with it."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from skybody import CompiledScenario
from skybody._native import Pool

from research.transfer.raptor_vehicles import Fleet, Motion, Reals, fleet_of
from research.transfer.rotation import matrix

SERVER = Path(__file__).resolve().parents[1] / "peers/raptor_server.py"


class World(Protocol):
    """n vehicles, numbered as in a fleet."""

    period: float  # of actions [s]

    def motion(self) -> Motion:
        """Their present states."""

    def step(self, throttles: Reals) -> None:
        """Holds throttles (n, 4) in [0, 1], shares of the largest speeds, for a period."""


class Ours:
    """Vehicles in a pool of ours, with changed constants of robot `quad` if `changes` names some.

    Values of `changes` are factors, of all rotors if a path contains `[*]`.
    """

    def __init__(
        self,
        scenario: str,
        overrides: Sequence[str],
        n: int,
        seed: int,
        changes: Mapping[str, float] | None = None,
    ) -> None:
        self.compiled = CompiledScenario(scenario, list(overrides))
        self.pool = Pool(self.compiled, n, seed=seed, info=False)
        self.pool.send_reset()
        self.pool.recv()
        for path, factor in (changes or {}).items():
            self._scale(f"robots.quad.{path}", factor)
        self.fleet = fleet_of(self.pool, self.compiled)
        self.period = self.compiled.dt * self.compiled.action_repeat

    def _scale(self, path: str, factor: float) -> None:
        parts = range(len(self.compiled.rotors)) if "[*]" in path else (0,)
        for env in range(self.pool.num_envs):
            for k in parts:
                name = path.replace("[*]", f"[{k}]")
                self.pool.set_param(env, name, factor * self.pool.param(env, name))

    def motion(self) -> Motion:
        """As World.motion."""
        state = {
            name: self.pool.state(f"robots.quad.base.{name}")
            for name in ("position", "rotation", "velocity", "angular_velocity")
        }
        rotation = matrix(state["rotation"])
        return Motion(state["position"], rotation, state["velocity"], state["angular_velocity"])

    def rotor_speeds(self) -> Reals:
        """Shares (n, 4) of the largest speeds."""
        speeds = self.pool.state("robots.quad.rotors.speed")
        largest = [
            [
                self.pool.param(env, f"robots.quad.rotors[{k}].max_speed")
                for k in range(speeds.shape[1])
            ]
            for env in range(self.pool.num_envs)
        ]
        return np.asarray(speeds / np.array(largest))

    def step(self, throttles: Reals) -> None:
        """As World.step."""
        self.pool.step((2.0 * throttles - 1.0).astype(np.float32))


class Peer:
    """The program of RAPTOR's policy and of L2F, in its own virtual environment."""

    def __init__(self, python: Path) -> None:
        self.process = subprocess.Popen(
            [python, "-P", SERVER],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "OMP_NUM_THREADS": "1"},  # its threads spin where cores are busy
        )

    def ask(self, request: Mapping[str, Any], *arrays: NDArray[Any]) -> NDArray[np.float32]:
        """The answer to a request of raptor_server.py."""
        source, sink = self.process.stdout, self.process.stdin
        assert source is not None and sink is not None
        shapes = [array.shape for array in arrays]
        sink.write(json.dumps({**request, "shapes": shapes}).encode() + b"\n")
        for array in arrays:
            sink.write(np.ascontiguousarray(array, np.float32).tobytes())
        sink.flush()
        shape = json.loads(source.readline())
        values = np.frombuffer(source.read(4 * int(np.prod(shape))), np.float32)
        return values.reshape(shape)

    def close(self) -> None:
        """Ends the program."""
        if self.process.stdin is not None:
            self.process.stdin.close()
        self.process.wait()


class L2f:
    """A fleet in L2F, which starts with the states of another world.

    Args:
        speeds: of rotors, (n, 4) shares of the largest ones.
        period: of actions [s].
        dt: of a step [s].
    """

    def __init__(
        self, peer: Peer, fleet: Fleet, start: Motion, speeds: Reals, period: float, dt: float
    ) -> None:
        self.peer, self.period, self.count = peer, period, round(period / dt)
        self.states = peer.ask(
            {
                "do": "world",
                "vehicles": [vehicle_of_l2f(fleet, k) for k in range(len(fleet.mass))],
                "starts": [start_of_l2f(start, speeds, k) for k in range(len(fleet.mass))],
                "dt": dt,
            }
        )

    def motion(self) -> Motion:
        """As World.motion."""
        parts = np.split(self.states.astype(np.float64), [3, 12, 15], axis=1)
        return Motion(parts[0], parts[1].reshape(-1, 3, 3), parts[2], parts[3])

    def step(self, throttles: Reals) -> None:
        """As World.step."""
        self.states = self.peer.ask({"do": "step", "count": self.count}, throttles)


def vehicle_of_l2f(fleet: Fleet, k: int) -> dict[str, Any]:
    """Changes of L2F's parameters for vehicle k: rotor speeds range from 0 to 1 there."""
    inertia = fleet.inertia[k]
    return {
        "rotor_positions": fleet.hubs[k].tolist(),
        "rotor_torque_directions": [[0.0, 0.0, -float(turn)] for turn in fleet.directions],
        "rotor_thrust_coefficients": [[0.0, 0.0, float(thrust)] for thrust in fleet.full_thrust[k]],
        "rotor_torque_constants": fleet.moment_arm[k].tolist(),
        "rotor_time_constants_rising": fleet.tau_up[k].tolist(),
        "rotor_time_constants_falling": fleet.tau_down[k].tolist(),
        "mass": float(fleet.mass[k]),
        "gravity": [0.0, 0.0, -fleet.gravity],
        "J": inertia.tolist(),
        "J_inv": np.linalg.inv(inertia).tolist(),
        "hovering_throttle_relative": float(fleet.hover[k]),
    }


def start_of_l2f(start: Motion, speeds: Reals, k: int) -> dict[str, list[float]]:
    """L2F's state of vehicle k."""
    return {
        "position": start.position[k].tolist(),
        "orientation": quaternions(start.rotation[k : k + 1])[0].tolist(),
        "linear_velocity": start.velocity[k].tolist(),
        "angular_velocity": start.rates[k].tolist(),
        "rpm": speeds[k].tolist(),
    }


def quaternions(rotation: Reals) -> Reals:
    """Quaternions w x y z (n, 4) with w >= 0 of rotation matrices (n, 3, 3)."""
    trace = np.trace(rotation, axis1=1, axis2=2)
    diagonal = np.diagonal(rotation, axis1=1, axis2=2)
    squares = np.column_stack([1 + trace, 1 + 2 * diagonal - trace[:, None]])
    found = 0.5 * np.sqrt(np.maximum(squares, 0.0))
    found[:, 1] = np.copysign(found[:, 1], rotation[:, 2, 1] - rotation[:, 1, 2])
    found[:, 2] = np.copysign(found[:, 2], rotation[:, 0, 2] - rotation[:, 2, 0])
    found[:, 3] = np.copysign(found[:, 3], rotation[:, 1, 0] - rotation[:, 0, 1])
    return np.asarray(found)
