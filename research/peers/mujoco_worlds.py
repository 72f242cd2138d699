"""Shared code of MuJoCo's two Python ways: models, and rotor thrusts as forces.

Rotor thrusts are applied by motors on sites, as usual in models of quadrotors, or by
`qfrc_applied`: the caller rotates each robot's thrust into world axes, here with NumPy for all
worlds at once. The latter is faster in MuJoCo, but the forces are constant during a call, so it is
measured with one step per call only.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import measure
import mujoco
import numpy as np
import vehicle
from numpy.typing import NDArray

Array = NDArray[np.float64]
DIFFERS = "no contact; no rotor lag; no reward, ends or resets; thrusts as commands; Euler"
MIXER = np.array(vehicle.qdrone2().mixer())


@dataclass(frozen=True)
class Work:
    """One row: numbers of worlds, of robots and of steps per call, thrusts by motors or not."""

    envs: int
    robots: int = 1
    payload: bool = False
    substeps: int = 1
    motors: bool = False

    @property
    def way(self) -> str:
        return "motors" if self.motors else "qfrc_applied"

    @property
    def task(self) -> str:
        if self.payload:
            return "payload"
        return "hover" if self.robots == 1 else "robots"

    def name(self) -> str:
        return f"{self.task}, {self.envs} x {self.robots}, {self.substeps} steps, {self.way}"

    def row(self) -> dict[str, Any]:
        """The fields of a line of results."""
        return {
            "envs": self.envs,
            "robots": self.robots,
            "substeps": self.substeps,
            "task": self.task,
        }

    def model(self) -> mujoco.MjModel:
        return mujoco.MjModel.from_xml_string(vehicle.mjcf(self.robots, self.payload, self.motors))

    def thrusts(self) -> Array:
        """Commands at which all vehicles hover, (envs, robots, 4) [N]."""
        load = vehicle.payload().mass if self.payload else 0.0
        return np.full((self.envs, self.robots, 4), vehicle.qdrone2().hover_thrust(load))


def batch_work(effort: measure.Effort, most: int) -> Iterator[Work]:
    """All rows of a peer with batches, up to `most` worlds."""
    for payload, envs, motors in itertools.product(
        (False, True), effort.sizes(most), (False, True)
    ):
        yield Work(envs, payload=payload, motors=motors)
    for payload, envs in itertools.product((False, True), (128, 1024)):
        yield Work(envs, payload=payload, substeps=100, motors=True)
    for robots, motors in itertools.product(measure.ROBOTS, (False, True)):
        yield Work(measure.ROBOT_WORLDS, robots=robots, motors=motors)


class Wrenches:
    """Writes generalized forces of free joints: force in world axes, moment in body axes.

    positions and forces are (envs, robots, ...): views of the generalized positions and forces of
    the robots' free joints.
    """

    def __init__(self, robots: int, positions: Array, forces: Array) -> None:
        # The robots of a world are consecutive, each with the same number of values (payload or
        # not).
        self.quaternion = robots_of(positions, robots)[:, :, 3:7]
        self.force = robots_of(forces, robots)

    def write(self, commands: Array) -> None:
        """commands: thrusts (envs, robots, 4) [N]."""
        wrench = commands @ MIXER.T
        w, x, y, z = (self.quaternion[..., k] for k in range(4))
        thrust = wrench[..., 0]
        twice = 2.0 * thrust
        self.force[..., 0] = twice * (x * z + w * y)
        self.force[..., 1] = twice * (y * z - w * x)
        self.force[..., 2] = thrust - twice * (x * x + y * y)
        self.force[..., 3:6] = wrench[..., 1:]


def robots_of(rows: Array, robots: int) -> Array:
    """A view (envs, robots, width) of rows (envs, robots * width)."""
    envs, width = rows.shape
    shape = (envs, robots, width // robots)
    strides = (rows.strides[0], width // robots * rows.strides[1], rows.strides[1])
    return np.lib.stride_tricks.as_strided(rows, shape, strides)


def check_hover(height: Array | float) -> None:
    """Checks that hovering vehicles are still at their initial height."""
    measure.require(bool(np.abs(height - 1.5).max() < 0.5), "a vehicle did not hover")
