"""The QDrone2 in MuJoCo: MJCF from its URDF, rotors as forces on the base's body."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from research.transfer import rotation
from research.transfer.conditions import Truth
from research.transfer.inner_loop import rotor_speeds
from research.transfer.observation import Motion
from research.transfer.quadrotor import GRAVITY, Quadrotor, Shape

Reals = NDArray[np.float64]
VEHICLE = 1  # its body; gates follow


def words(values: Reals | tuple[float, ...]) -> str:
    """Numbers of an attribute."""
    return " ".join(repr(float(value)) for value in values)


def geom(shape: Shape) -> str:
    """A collision shape without mass."""
    place = f'pos="{words(shape.origin)}" size="{words(shape.size)}"'
    return f'<geom type="{shape.kind}" mass="0" {place}/>'


def mjcf(quad: Quadrotor, dt: float, obstacles: str = "") -> str:
    """A world of one vehicle, above ground."""
    base, *rotors = quad.links
    inertial = '<inertial pos="0 0 0" mass="{}" diaginertia="{}"/>'
    parts = "".join(
        f'<body name="{link.name}" pos="{words(link.origin)}">'
        f"{inertial.format(link.mass, words(link.inertia))}</body>"
        for link in rotors
    )
    return f"""<mujoco>
  <option timestep="{dt}" gravity="0 0 {-GRAVITY}" integrator="implicitfast"/>
  <worldbody>
    <geom type="plane" size="50 50 1"/>
    <body name="{base.name}"><freejoint/>
      {inertial.format(base.mass, words(base.inertia))}
      {"".join(map(geom, quad.shapes))}{parts}
    </body>{obstacles}
  </worldbody>
</mujoco>"""


class Engine:
    """N worlds, one vehicle each."""

    name = f"MuJoCo {mujoco.__version__}"

    def __init__(
        self, quad: Quadrotor, truth: Truth, dt: float, obstacles: Sequence[str] = ()
    ) -> None:
        self.quad, self.truth, self.dt = quad, truth, dt
        self.worlds = []
        for k in range(len(truth.mass)):
            model = mujoco.MjModel.from_xml_string(
                mjcf(quad, dt, obstacles[k] if obstacles else "")
            )
            model.body_mass[1:] *= truth.mass[k]
            model.body_inertia[1:] *= truth.inertia[k]
            data = mujoco.MjData(model)
            mujoco.mj_setConst(model, data)
            self.worlds.append((model, data))

    def start(self, position: Reals, yaw: Reals | None = None) -> None:
        """At rest and level, rotors at their hover speed."""
        half = np.zeros(len(position)) if yaw is None else 0.5 * yaw
        for (model, data), place, turn in zip(self.worlds, position, half, strict=True):
            mujoco.mj_resetData(model, data)
            data.qpos[:7] = [*place, np.cos(turn), 0.0, 0.0, np.sin(turn)]
        self.speeds = np.full((len(position), 4), self.quad.hover_speed)
        self._read()

    def step(self, commands: Reals, wind: Reals) -> None:
        """One step of physics. commands: (N, 4) [rad/s]; wind: W (N, 3) [m/s]."""
        commands = np.clip(commands, 0.0, self.quad.max_speed)
        nominal = np.where(commands > self.speeds, self.quad.tau_up, self.quad.tau_down)
        rest = np.exp(-0.5 * self.dt / (nominal * self.truth.lag[:, None]))
        middle = commands + (self.speeds - commands) * rest
        self.speeds = commands + (self.speeds - commands) * rest * rest
        wrench = self._wrench(middle, wind)
        for (model, data), one in zip(self.worlds, wrench, strict=True):
            data.xfrc_applied[VEHICLE] = one
            mujoco.mj_step(model, data)
        self._read()

    def _wrench(self, speeds: Reals, wind: Reals) -> Reals:
        """Force and torque on the base at its centre of mass, W (N, 6)."""
        quad, m = self.quad, self.motion
        square = self.truth.thrust * speeds**2
        hubs = quad.hubs
        air = np.einsum("nji,nj->ni", m.attitude, m.velocity - wind)
        local = air[:, None] + np.cross(m.rates[:, None], hubs)
        force = -quad.drag * speeds[..., None] * local
        force[..., 2] = quad.thrust * square
        torque = np.cross(hubs, force).sum(axis=1)
        torque[:, 2] -= quad.moment * (square * quad.turns).sum(axis=1)
        spin = quad.links[1].inertia[2] * (speeds * quad.turns).sum(axis=1)
        torque -= np.stack([m.rates[:, 1] * spin, -m.rates[:, 0] * spin, 0.0 * spin], 1)
        both = np.stack([force.sum(axis=1), torque], 1)
        return np.einsum("nij,nkj->nki", m.attitude, both).reshape(-1, 6)

    def touching(self) -> NDArray[np.bool_]:
        """Whether a vehicle touches anything (N)."""
        return np.array([data.ncon > 0 for _, data in self.worlds])

    def _read(self) -> None:
        places = np.array([data.qpos for _, data in self.worlds])
        speeds = np.array([data.qvel for _, data in self.worlds])
        attitude = rotation.matrix(places[:, 3:7])
        self.motion = Motion(places[:, :3], speeds[:, :3], attitude, speeds[:, 3:6])

    def inner_loop(self, force: Reals, attitude: Reals, rates: Reals) -> Reals:
        """Rotor speeds for a force."""
        return rotor_speeds(self.quad, force, attitude, rates)

    def close(self) -> None:
        """Nothing to close."""
