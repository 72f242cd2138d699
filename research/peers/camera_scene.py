"""The scene of camera_mujoco.py and camera_pybullet.py, as camera_peers.py writes it, in JSON.

    {"shapes": [{"kind": "box", "size": [...], "position": [...], "rotation": [w, x, y, z],
                 "instance": 3}, ...],
     "poses": [[x, y, z, w, x, y, z], ...], "camera": [x, y, z], "pixels": 64,
     "field_of_view": 90.0, "farthest": 20.0, "substeps": 20, "ground": 1}

One pose of a vehicle for each environment; gates are four boxes of one instance.
"""

from __future__ import annotations

import functools
import json
import pathlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import measure
import numpy as np
import processes
import vehicle

from research.common.machine import processor_seconds

CORES = 2
HOVER_TOLERANCE = 0.02  # of the mean depth and of the seen share, from the first image to the last


@dataclass(frozen=True)
class Scene:
    """Shapes, poses of vehicles, and their cameras."""

    shapes: list[dict[str, Any]]
    poses: processes.Array
    camera: list[float]  # its place on the vehicle; it looks forward [m]
    pixels: int
    field_of_view: float  # [degrees]
    farthest: float  # [m]
    substeps: int  # physics steps of a frame
    ground: int  # instance

    def instances(self) -> processes.Array:
        """Instances of the ground, and of all shapes."""
        return np.array([self.ground, *(shape["instance"] for shape in self.shapes)], float)


def read(description: str | None) -> tuple[measure.Effort, Scene, Any]:
    """The command line: the effort, the scene of --scene, and all options."""
    parser = measure.parser(description)
    parser.add_argument("--scene", type=pathlib.Path, required=True, help="the file of JSON")
    parser.add_argument("--gl", default="egl", help="of MuJoCo: egl or osmesa")
    options = parser.parse_args()
    found = json.loads(options.scene.read_text(encoding="utf-8"))
    scene = Scene(**found | {"poses": np.array(found["poses"])})
    return measure.effort(parser, options), scene, options


def views(images: processes.Array, scene: Scene) -> tuple[float, float]:
    """The share of pixels that see a shape, and the mean depth of those that see anything [m]."""
    depth, instance = images[:, 0], images[:, 1]
    near = depth < 0.999 * scene.farthest
    return float((near & (instance > scene.ground)).mean()), float(depth[near].mean())


def rates(batch: processes.Batch, effort: measure.Effort) -> tuple[float, float]:
    """Frames per second, and per second of processor time, each of its best trial."""
    best = (0.0, 0.0)
    for _ in range(effort.trials):
        frames, start, computed = 0, time.perf_counter(), processor_seconds()
        while (taken := time.perf_counter() - start) < effort.seconds:
            frames += len(batch())
        computed = processor_seconds() - computed
        best = max(best[0], frames / taken), max(best[1], frames / max(computed, 1e-9))
    return best


def row(
    peer: measure.Peer,
    effort: measure.Effort,
    scene: Scene,
    make: Callable[[Scene, processes.Array], processes.Worlds],
    mode: str,
) -> None:
    """Measures frames per second of all environments in two processes; prints the row."""
    thrusts = np.full((len(scene.poses), 4), vehicle.qdrone2().hover_thrust())
    commands = np.concatenate([thrusts, scene.poses], axis=1)
    batch = processes.Batch(
        functools.partial(_Share, scene=scene, make=make),
        commands,
        (2, scene.pixels, scene.pixels),
        CORES,
    )
    try:
        first = views(batch(), scene)
        rate, by_processor = rates(batch, effort)
        seen, depth = views(batch(), scene)
    finally:
        batch.close()
    measure.require(
        np.allclose((seen, depth), first, rtol=HOVER_TOLERANCE), "the vehicles did not hover"
    )
    peer.line(
        rate=rate,
        by_processor=by_processor,
        mode=mode,
        cores=CORES,
        envs=len(scene.poses),
        substeps=scene.substeps,
        differs=peer.differs,
        seen=seen,
        depth=depth,
    )


class _Share:
    """A process's worlds, made at the first step, when their commands are known."""

    def __init__(
        self,
        count: int,
        scene: Scene,
        make: Callable[[Scene, processes.Array], processes.Worlds],
    ) -> None:
        self.count, self.scene, self.make = count, scene, make
        self.worlds: processes.Worlds | None = None

    def step(self, commands: processes.Array, states: processes.Array) -> None:
        """Steps all worlds: thrusts (envs, 4) to images (envs, 2, pixels, pixels)."""
        if self.worlds is None:
            self.worlds = self.make(self.scene, commands[:, 4:])
        self.worlds.step(commands[:, :4], states)
