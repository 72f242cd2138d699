"""PyBullet: a direct loop over quadrotors, in one process and in two.

The fastest settings, found by experiment: no shapes, one force and one moment per vehicle (the
rotors' sum) instead of four forces, arguments by position, no damping; its "maximal coordinates"
gain nothing. Environments with one robot share a PyBullet world, which saves calls: without shapes
they do not interact. More than some tens in one world get slower, and so do many worlds.
"""

from __future__ import annotations

import functools
import importlib.metadata

import measure
import numpy as np
import processes
import pybullet
import vehicle

DIFFERS = "no contact; no rotor lag; no reward, ends or resets; thrusts as commands"
MIXER = np.array(vehicle.qdrone2().mixer())
ZERO = (0.0, 0.0, 0.0)
STILL = (0.0, 0.0, 0.0, 1.0)  # a quaternion, x y z w


def peer() -> measure.Peer:
    version = importlib.metadata.version("pybullet")
    return measure.Peer("PyBullet", version, f"Bullet (PyBullet {version})", DIFFERS)


def together(envs: int) -> int:
    """Number of environments in one PyBullet world, with one robot each; tried: 1 to 1024."""
    return 8 if envs <= 64 else 32


def make_vehicle(client: int, robot: int, payload: bool) -> int:
    """A free body; with a payload two more below it, on ball joints without motors."""
    base, load = vehicle.qdrone2().base, vehicle.payload()
    parts = [(load.rod, load.rod_joint), (load.bob, load.bob_joint)] if payload else []
    body = pybullet.createMultiBody(
        baseMass=base.mass,
        basePosition=vehicle.place(robot),
        baseInertialFramePosition=base.center,
        linkMasses=[part.mass for part, _ in parts],
        linkCollisionShapeIndices=[-1 for _ in parts],
        linkVisualShapeIndices=[-1 for _ in parts],
        linkPositions=[joint for _, joint in parts],
        linkOrientations=[STILL for _ in parts],
        linkInertialFramePositions=[part.center for part, _ in parts],
        linkInertialFrameOrientations=[STILL for _ in parts],
        linkParentIndices=list(range(len(parts))),
        linkJointTypes=[pybullet.JOINT_SPHERICAL for _ in parts],
        linkJointAxis=[(0, 0, 1) for _ in parts],
        physicsClientId=client,
    )
    for link, part in enumerate([base, *(part for part, _ in parts)], start=-1):
        pybullet.changeDynamics(
            body,
            link,
            localInertiaDiagonal=part.inertia,
            linearDamping=0,
            angularDamping=0,
            jointDamping=0,
            physicsClientId=client,
        )
    for joint in range(len(parts)):  # each has a motor by default
        pybullet.setJointMotorControlMultiDof(
            body,
            joint,
            pybullet.POSITION_CONTROL,
            targetPosition=STILL,
            positionGain=0,
            velocityGain=0,
            force=ZERO,
            physicsClientId=client,
        )
    return int(body)


class Quadrotors:
    """A number of environments with a number of robots each, in PyBullet worlds of this process."""

    def __init__(self, envs: int, robots: int, payload: bool) -> None:
        self.payload = payload
        a_world = robots if robots > 1 else together(envs)
        self.bodies: list[tuple[int, int]] = []  # of each robot: PyBullet's client and body
        self.clients: list[int] = []
        for robot in range(envs * robots):
            if robot % a_world == 0:
                self.clients.append(self.connect())
            client = self.clients[-1]
            self.bodies.append((client, make_vehicle(client, robot % robots, payload)))

    @staticmethod
    def connect() -> int:
        client = pybullet.connect(pybullet.DIRECT)
        measure.require(client >= 0, "PyBullet has no more clients")
        pybullet.setGravity(0, 0, -vehicle.GRAVITY, physicsClientId=client)
        pybullet.setTimeStep(vehicle.DT, physicsClientId=client)
        return int(client)

    def step(self, commands: processes.Array, states: processes.Array) -> None:
        self.push(commands)
        step = pybullet.stepSimulation
        for client in self.clients:
            step(client)
        self.read(states)

    def push(self, commands: processes.Array) -> None:
        frame = pybullet.LINK_FRAME
        force, moment = pybullet.applyExternalForce, pybullet.applyExternalTorque
        wrenches = (commands.reshape(-1, 4) @ MIXER.T).tolist()
        for (client, body), (thrust, x, y, z) in zip(self.bodies, wrenches, strict=True):
            force(body, -1, (0.0, 0.0, thrust), ZERO, frame, client)
            moment(body, -1, (x, y, z), frame, client)

    def read(self, states: processes.Array) -> None:
        pose, velocity = pybullet.getBasePositionAndOrientation, pybullet.getBaseVelocity
        joints = pybullet.getJointStatesMultiDof
        rows = []
        for client, body in self.bodies:
            position, quaternion = pose(body, client)
            linear, angular = velocity(body, client)
            row = (*position, *quaternion, *linear, *angular)
            if self.payload:
                for rotation, spin, *_ in joints(body, (0, 1), client):
                    row += (*rotation, *spin)
            rows.append(row)
        states[:] = np.reshape(rows, states.shape)


def row(
    effort: measure.Effort, envs: int, cores: int, robots: int = 1, payload: bool = False
) -> None:
    load = vehicle.payload().mass if payload else 0.0
    commands = np.full((envs, robots, 4), vehicle.qdrone2().hover_thrust(load))
    make = functools.partial(Quadrotors, robots=robots, payload=payload)
    batch = processes.Batch(make, commands, (robots, 27 if payload else 13), cores)
    packed = f", {together(envs // cores)} environments in a PyBullet world"
    try:
        peer().row(
            batch,
            effort,
            mode=f"direct loop, {cores} process{'es' if cores > 1 else ''}"
            + (packed if robots == 1 and envs > 1 else ""),
            cores=cores,
            envs=envs,
            robots=robots,
            task="payload" if payload else "hover" if robots == 1 else "robots",
            check=functools.partial(check, batch),
        )
    finally:
        batch.close()


def check(batch: processes.Batch) -> None:
    measure.require(bool(np.abs(batch()[..., 2] - 1.5).max() < 0.5), "a vehicle did not hover")
    before = batch()[..., 9].copy()
    batch.commands *= 1.1
    measure.require_climb((batch()[..., 9] - before).min(), vehicle.DT)


def main() -> None:
    effort = measure.parse(__doc__)
    measure.use_cores(2)
    attempt, some = peer().attempt, functools.partial
    for envs, cores in ((1, 1), (16, 1), (16, 2), (64, 2), (1024, 2)):
        attempt(f"hover, {envs}", some(row, effort, envs, cores))
    for envs, cores in ((1, 1), (16, 2), (64, 2)):
        attempt(f"payload, {envs}", some(row, effort, envs, cores, payload=True))
    for robots in measure.ROBOTS:
        attempt(f"{robots} robots", some(row, effort, measure.ROBOT_WORLDS, 2, robots=robots))


if __name__ == "__main__":
    main()
