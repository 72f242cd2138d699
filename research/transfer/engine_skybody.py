"""The same flights in Skybody: whether an error comes from the policy or from the other engine."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from skybody import CompiledScenario, SimulationPool, versions

from research.common.places import ROOT
from research.transfer import rotation
from research.transfer.conditions import Truth
from research.transfer.inner_loop import rotor_speeds
from research.transfer.observation import Motion
from research.transfer.quadrotor import Quadrotor

Reals = NDArray[np.float64]
SCENARIO = ROOT / "research/transfer/scenarios/own_engine.yaml"
BASE = "robots.quad.links.base_link"
LAGS = ("tau_up", "tau_down")


class Engine:
    """N environments under direct control."""

    name = f"Skybody {versions()['skybody']}"

    def __init__(self, quad: Quadrotor, truth: Truth, dt: float) -> None:
        self.quad, self.truth = quad, truth
        self.pool = SimulationPool(CompiledScenario(SCENARIO), len(truth.mass), num_threads=1)
        self.steps = round(dt / 0.001)

    def start(self, position: Reals) -> None:
        """At rest and level, rotors at their hover speed."""
        self.pool.reset(seed=1)
        for k, place in enumerate(position):
            self._change(k)
            self.pool.teleport(k, position=place)
        self._read()

    def _change(self, k: int) -> None:
        """Sets the true constants of environment k."""
        factors = {f"{BASE}.mass": self.truth.mass[k]}
        factors |= {f"{BASE}.inertia[{i}]": self.truth.inertia[k, i] for i in range(3)}
        for i, thrust in enumerate(self.truth.thrust[k]):
            rotor = f"robots.quad.rotors[{i}]"
            factors |= {f"{rotor}.{name}_constant": thrust for name in ("thrust", "moment")}
            factors |= {f"{rotor}.{name}": self.truth.lag[k] for name in LAGS}
        for path, factor in factors.items():
            self.pool.set_param(k, path, self.pool.param(k, path) * float(factor))

    def step(self, commands: Reals, wind: Reals) -> None:
        """One step of physics. commands: (N, 4) [rad/s]; wind: W (N, 3) [m/s]."""
        for k, air in enumerate(wind.tolist()):
            for axis in range(2):
                self.pool.set_param(k, f"effects.wind.velocity[{axis}]", air[axis])
        self.pool.command(commands)
        self.pool.advance(self.steps)
        self._read()

    def _read(self) -> None:
        pool = self.pool
        self.motion = Motion(
            pool.positions[:, 0].copy(),
            pool.velocities[:, 0].copy(),
            rotation.matrix(pool.rotations[:, 0]),
            pool.angular_velocities[:, 0].copy(),
        )

    def inner_loop(self, force: Reals, attitude: Reals, rates: Reals) -> Reals:
        """Rotor speeds for a force."""
        return rotor_speeds(self.quad, force, attitude, rates)

    def close(self) -> None:
        """Ends the environments."""
        self.pool.close()
