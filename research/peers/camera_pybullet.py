"""PyBullet: frames of depth and bodies of many vehicles by its TinyRenderer.

    python camera_pybullet.py --scene FILE [--seconds S] [--trials T] [--quick]

Two processes. First, the vehicles of each share a PyBullet world, which saves calls: without shapes
they do not touch or see each other; without shadows. Second, a world for each vehicle, shadows.
"""

from __future__ import annotations

import functools
import importlib.metadata

import camera_scene
import measure
import numpy as np
import processes
import pybullet
import vehicle
from camera_scene import Scene
from peer_pybullet import Quadrotors, make_vehicle

NEAR = 0.01  # [m]
DIFFERS = "no contact; no rotor lag; no reward, ends or resets; thrusts as commands"


def add_shape(client: int, shape: dict) -> int:
    """A fixed body with a visual shape alone; returns its number."""
    size, kind = shape["size"], shape["kind"]
    of_kind = {
        "box": {"halfExtents": [0.5 * x for x in size]},
        "sphere": {"radius": size[0]},
        "cylinder": {"radius": size[0], "length": size[-1]},
        "capsule": {"radius": size[0], "length": size[-1]},
    }
    number = getattr(pybullet, f"GEOM_{kind.upper()}")
    visual = pybullet.createVisualShape(number, **of_kind[kind], physicsClientId=client)
    w, x, y, z = shape["rotation"]
    return int(
        pybullet.createMultiBody(
            baseVisualShapeIndex=visual,
            basePosition=shape["position"],
            baseOrientation=(x, y, z, w),
            physicsClientId=client,
        )
    )


class World:
    """Environments that share a PyBullet world."""

    shadow = 0

    def __init__(self, scene: Scene, poses: processes.Array) -> None:
        self.scene = scene
        self.client = Quadrotors.connect()
        ground = {"kind": "box", "size": [180, 180, 2], "position": [0, 0, -1]}
        rotation = {"rotation": [1, 0, 0, 0]}
        bodies = [add_shape(self.client, x) for x in (ground | rotation, *scene.shapes)]
        self.vehicles = [make_vehicle(self.client, 0, payload=False) for _ in poses]
        for body, (*position, w, x, y, z) in zip(self.vehicles, poses, strict=True):
            pybullet.resetBasePositionAndOrientation(
                body, position, (x, y, z, w), physicsClientId=self.client
            )
        self.instances = np.zeros(len(bodies) + len(poses) + 1)  # -1: nothing
        self.instances[bodies] = scene.instances()
        self.projection = pybullet.computeProjectionMatrixFOV(
            scene.field_of_view, 1.0, NEAR, scene.farthest
        )

    def step(self, commands: processes.Array, states: processes.Array) -> None:
        """Physics, then an image of each vehicle: depth [m] and instance."""
        frame, force = pybullet.LINK_FRAME, pybullet.applyExternalForce
        moment, client = pybullet.applyExternalTorque, self.client
        wrenches = (commands @ np.transpose(vehicle.qdrone2().mixer())).tolist()
        for _ in range(self.scene.substeps):
            for body, (thrust, x, y, z) in zip(self.vehicles, wrenches, strict=True):
                force(body, -1, (0.0, 0.0, thrust), (0.0, 0.0, 0.0), frame, client)
                moment(body, -1, (x, y, z), frame, client)
            pybullet.stepSimulation(client)
        for body, images in zip(self.vehicles, states, strict=True):
            self.draw(body, images)

    def draw(self, body: int, images: processes.Array) -> None:
        """The camera's image."""
        position, rotation = pybullet.getBasePositionAndOrientation(body, self.client)
        turn = np.reshape(pybullet.getMatrixFromQuaternion(rotation), (3, 3))
        eye = position + turn @ self.scene.camera
        view = pybullet.computeViewMatrix(eye, eye + turn[:, 0], turn[:, 2])
        size, far = self.scene.pixels, self.scene.farthest
        _, _, _, depth, numbers = pybullet.getCameraImage(
            size,
            size,
            view,
            self.projection,
            shadow=self.shadow,
            renderer=pybullet.ER_TINY_RENDERER,
            physicsClientId=self.client,
        )
        images[0] = NEAR * far / (far - np.reshape(depth, (size, size)) * (far - NEAR))
        images[1] = self.instances[np.reshape(numbers, (size, size))]


class Worlds:
    """Environments with a PyBullet world each, with shadows."""

    def __init__(self, scene: Scene, poses: processes.Array) -> None:
        self.worlds = [World(scene, poses[k : k + 1]) for k in range(len(poses))]
        for world in self.worlds:
            world.shadow = 1

    def step(self, commands: processes.Array, states: processes.Array) -> None:
        """As World.step()."""
        for k, world in enumerate(self.worlds):
            world.step(commands[k : k + 1], states[k : k + 1])


def main() -> None:
    effort, scene, _ = camera_scene.read(__doc__)
    measure.use_cores(camera_scene.CORES)
    version = importlib.metadata.version("pybullet")
    peer = measure.Peer("PyBullet", version, f"TinyRenderer (PyBullet {version})", DIFFERS)
    for make, way in ((World, "shared worlds, no shadows"), (Worlds, "a world each, shadows")):
        mode = f"getCameraImage, {way}, 2 processes"
        peer.attempt(mode, functools.partial(camera_scene.row, peer, effort, scene, make, mode))


if __name__ == "__main__":
    main()
