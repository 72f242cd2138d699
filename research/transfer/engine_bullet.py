"""The QDrone2 in Bullet: its own loader reads the URDF; thrusts act at the hubs."""

from __future__ import annotations

import numpy as np
import pybullet
from numpy.typing import NDArray

from research.transfer import rotation
from research.transfer.conditions import Truth
from research.transfer.inner_loop import rotor_speeds
from research.transfer.observation import Motion
from research.transfer.quadrotor import GRAVITY, URDF, Quadrotor

Reals = NDArray[np.float64]


class Engine:
    """N vehicles in one world, without contact between them."""

    name = f"Bullet {pybullet.getAPIVersion()}"

    def __init__(self, quad: Quadrotor, truth: Truth, dt: float) -> None:
        self.quad, self.truth, self.dt = quad, truth, dt
        self.client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0, 0, -GRAVITY, self.client)
        pybullet.setTimeStep(dt, self.client)
        self.bodies = [self._load(k) for k in range(len(truth.mass))]

    def _load(self, k: int) -> int:
        """A vehicle with its true mass and inertia, without Bullet's artificial damping."""
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_MERGE_FIXED_LINKS
        body: int = pybullet.loadURDF(str(URDF), flags=flags, physicsClientId=self.client)
        pybullet.setCollisionFilterGroupMask(body, -1, 0, 0, self.client)
        found = pybullet.getDynamicsInfo(body, -1, self.client)
        pybullet.changeDynamics(
            body,
            -1,
            mass=found[0] * float(self.truth.mass[k]),
            localInertiaDiagonal=(np.array(found[2]) * self.truth.inertia[k]).tolist(),
            linearDamping=0.0,
            angularDamping=0.0,
            physicsClientId=self.client,
        )
        return body

    def start(self, position: Reals) -> None:
        """At rest and level, rotors at their hover speed."""
        for body, place in zip(self.bodies, position.tolist(), strict=True):
            pybullet.resetBasePositionAndOrientation(body, place, [0, 0, 0, 1], self.client)
            pybullet.resetBaseVelocity(body, [0, 0, 0], [0, 0, 0], self.client)
        self.speeds = np.full((len(position), 4), self.quad.hover_speed)
        self._read()

    def step(self, commands: Reals, wind: Reals) -> None:
        """One step of physics. commands: (N, 4) [rad/s]; wind: W (N, 3) [m/s]."""
        quad = self.quad
        commands = np.clip(commands, 0.0, quad.max_speed)
        rising = commands > self.speeds
        tau = np.where(rising, quad.tau_up, quad.tau_down) * self.truth.lag[:, None]
        self.speeds += self.dt / tau * (commands - self.speeds)
        lift = self.truth.thrust * self.speeds**2
        z = self.motion.attitude[:, :, 2]
        arms = np.einsum("nij,kj->nki", self.motion.attitude, quad.hubs)
        spin = np.einsum("nij,nj->ni", self.motion.attitude, self.motion.rates)
        passing = (self.motion.velocity - wind)[:, None] + np.cross(spin[:, None], arms)
        passing -= np.einsum("nki,ni->nk", passing, z)[..., None] * z[:, None]
        force = quad.thrust * lift[..., None] * z[:, None]
        force -= quad.drag * self.speeds[..., None] * passing
        twist = -quad.moment * (lift * quad.turns).sum(axis=1)[:, None] * z
        hubs = self.motion.position[:, None] + arms
        for k, body in enumerate(self.bodies):
            for push, place in zip(force[k].tolist(), hubs[k].tolist(), strict=True):
                pybullet.applyExternalForce(
                    body, -1, push, place, pybullet.WORLD_FRAME, self.client
                )
            pybullet.applyExternalTorque(
                body, -1, twist[k].tolist(), pybullet.WORLD_FRAME, self.client
            )
        pybullet.stepSimulation(self.client)
        self._read()

    def _read(self) -> None:
        poses = [pybullet.getBasePositionAndOrientation(b, self.client) for b in self.bodies]
        twists = np.array([pybullet.getBaseVelocity(b, self.client) for b in self.bodies])
        position = np.array([pose[0] for pose in poses])
        attitude = rotation.matrix(np.array([pose[1] for pose in poses])[:, [3, 0, 1, 2]])
        rates = np.einsum("nji,nj->ni", attitude, twists[:, 1])
        self.motion = Motion(position, twists[:, 0], attitude, rates)

    def inner_loop(self, force: Reals, attitude: Reals, rates: Reals) -> Reals:
        """Rotor speeds for a force."""
        return rotor_speeds(self.quad, force, attitude, rates)

    def close(self) -> None:
        """Ends the world."""
        pybullet.disconnect(self.client)
