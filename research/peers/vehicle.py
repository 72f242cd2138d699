"""The QDrone2, by itself, with its payload and several in a world, as plain numbers and as MJCF.

All numbers are read from scenarios/models/, so that every peer flies the same vehicle as Skybody.
The rotors are merged into the base by the parallel-axis theorem, as in Skybody.
"""

from __future__ import annotations

import functools
import math
import pathlib
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass

from measure import GRAVITY

MODELS = pathlib.Path(__file__).resolve().parents[2] / "scenarios" / "models"
DT = 0.001  # [s]
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Body:
    """A rigid body; its axes are principal axes in these models."""

    mass: float  # [kg]
    center: Vector  # of mass, from the body's origin [m]
    inertia: Vector  # about the centre of mass, diagonal [kg m^2]


@dataclass(frozen=True)
class Rotor:
    position: Vector  # of the hub, from the base's origin [m]
    direction: (
        int  # +1: turns counterclockwise seen from above, so that it turns the body clockwise
    )


@dataclass(frozen=True)
class Vehicle:
    base: Body  # with its rotors merged
    rotors: tuple[Rotor, ...]
    thrust_constant: float  # [N s^2/rad^2]
    moment_constant: float  # [N m s^2/rad^2]
    max_speed: float  # [rad/s]
    tau_up: float  # [s]
    tau_down: float  # [s]

    def mixer(self) -> list[list[float]]:
        """Maps rotor thrusts [N] to thrust along z [N] and moments about the base's axes [N m]."""
        return [
            [1.0 for _ in self.rotors],
            [rotor.position[1] for rotor in self.rotors],
            [-rotor.position[0] for rotor in self.rotors],
            [-rotor.direction * self.moment_ratio for rotor in self.rotors],
        ]

    @property
    def moment_ratio(self) -> float:
        """Reaction moment per thrust [m]."""
        return self.moment_constant / self.thrust_constant

    def hover_thrust(self, load: float = 0.0) -> float:
        """Thrust of each rotor at hover, with a mass `load` below [N]."""
        return (self.base.mass + load) * GRAVITY / len(self.rotors)

    def hover_speed(self, load: float = 0.0) -> float:
        """Rotor speed at hover [rad/s]."""
        return math.sqrt(self.hover_thrust(load) / self.thrust_constant)


@dataclass(frozen=True)
class Payload:
    """A rod below the base and a bob below the rod, ball joints between them."""

    rod: Body
    bob: Body
    rod_joint: Vector  # from the base's origin [m]
    bob_joint: Vector  # from the rod's origin, which is the upper joint [m]

    @property
    def mass(self) -> float:
        return self.rod.mass + self.bob.mass


def vector(text: str | None) -> Vector:
    x, y, z = (float(part) for part in (text or "0 0 0").split())
    return x, y, z


def read_body(root: ElementTree.Element, link: str) -> Body:
    inertial = root.find(f"link[@name='{link}']/inertial")
    assert inertial is not None
    origin, mass, inertia = (inertial.find(tag) for tag in ("origin", "mass", "inertia"))
    assert origin is not None and mass is not None and inertia is not None
    diagonal = tuple(float(inertia.attrib[axis]) for axis in ("ixx", "iyy", "izz"))
    return Body(
        float(mass.attrib["value"]),
        vector(origin.get("xyz")),
        (diagonal[0], diagonal[1], diagonal[2]),
    )


def joint_origin(root: ElementTree.Element, joint: str) -> Vector:
    origin = root.find(f"joint[@name='{joint}']/origin")
    return vector(None if origin is None else origin.get("xyz"))


def moved(body: Body, origin: Vector) -> Body:
    x, y, z = (a + b for a, b in zip(body.center, origin, strict=True))
    return Body(body.mass, (x, y, z), body.inertia)


def merged(bodies: list[Body]) -> Body:
    """One rigid body. Products of inertia must cancel, as for rotors in pairs."""
    mass = sum(body.mass for body in bodies)
    center = [sum(body.mass * body.center[k] for body in bodies) / mass for k in range(3)]
    inertia = [0.0, 0.0, 0.0]
    for body in bodies:
        arm = [body.center[k] - center[k] for k in range(3)]
        square = sum(a * a for a in arm)
        for k in range(3):
            inertia[k] += body.inertia[k] + body.mass * (square - arm[k] ** 2)
    return Body(mass, (center[0], center[1], center[2]), (inertia[0], inertia[1], inertia[2]))


def model(name: str) -> ElementTree.Element:
    return ElementTree.parse(MODELS / name / f"{name}.urdf").getroot()


@functools.cache
def qdrone2() -> Vehicle:
    root, text = model("qdrone2"), (MODELS / "qdrone2" / "rotors.yaml").read_text()
    constants = {
        key: float(value) for key, value in re.findall(r"^  (\w+): ([-+.\de]+)$", text, re.M)
    }
    lines = re.findall(r"link: (\w+), .*direction: (ccw|cw)", text)
    hubs = [joint_origin(root, f"{link}_joint") for link, _ in lines]
    bodies = [moved(read_body(root, link), hub) for (link, _), hub in zip(lines, hubs, strict=True)]
    return Vehicle(
        base=merged([read_body(root, "base_link"), *bodies]),
        rotors=tuple(
            Rotor(hub, 1 if direction == "ccw" else -1)
            for (_, direction), hub in zip(lines, hubs, strict=True)
        ),
        thrust_constant=constants["thrust_constant"],
        moment_constant=constants["moment_constant"],
        max_speed=constants["max_speed"],
        tau_up=constants["tau_up"],
        tau_down=constants["tau_down"],
    )


@functools.cache
def payload() -> Payload:
    root = model("qdrone2_payload")
    return Payload(
        rod=read_body(root, "rod"),
        bob=read_body(root, "bob"),
        rod_joint=joint_origin(root, "rod_joint_x"),
        bob_joint=joint_origin(root, "bob_joint_x"),
    )


def place(robot: int) -> Vector:
    """Initial position of a robot in a team: as in scenarios/formation/formation.yaml [m]."""
    return 0.7 * robot, 0.7 * robot, 1.5


# --- MJCF ---------------------------------------------------------------------------------------


# Stages of MuJoCo's step that are not needed in these worlds (its names, from 3.4 on).
MJCF_UNUSED = (
    *("contact", "constraint", "equality", "frictionloss", "limit", "spring", "damper"),
    *("clampctrl", "warmstart", "sensor", "eulerdamp", "autoreset", "midphase"),
)


def words(values: tuple[float, ...]) -> str:
    return " ".join(repr(value) for value in values)


def mjcf_inertial(body: Body) -> str:
    return (
        f'<inertial mass="{body.mass!r}" pos="{words(body.center)}" '
        f'diaginertia="{words(body.inertia)}"/>'
    )


def mjcf_load(load: Payload) -> str:
    return f"""
      <body pos="{words(load.rod_joint)}">
        <joint type="ball"/>{mjcf_inertial(load.rod)}
        <body pos="{words(load.bob_joint)}">
          <joint type="ball"/>{mjcf_inertial(load.bob)}
        </body>
      </body>"""


def mjcf_robot(vehicle: Vehicle, robot: int, load: Payload | None, motors: bool) -> str:
    sites = "".join(
        f'<site name="rotor{robot}_{k}" pos="{words(rotor.position)}"/>'
        for k, rotor in enumerate(vehicle.rotors if motors else ())
    )
    return f"""
    <body name="quad{robot}" pos="{words(place(robot))}">
      <freejoint/>{mjcf_inertial(vehicle.base)}{sites}{mjcf_load(load) if load else ""}
    </body>"""


def mjcf_rotors(vehicle: Vehicle, robot: int) -> str:
    return "".join(
        f'\n    <motor site="rotor{robot}_{k}" '
        f'gear="0 0 1 0 0 {-rotor.direction * vehicle.moment_ratio!r}"/>'
        for k, rotor in enumerate(vehicle.rotors)
    )


def mjcf(robots: int = 1, with_payload: bool = False, motors: bool = True) -> str:
    """A world of several quadrotors, in the form that is fastest in MuJoCo.

    It has no shapes, so no contacts; no limits, no springs. MuJoCo's Euler integrator is
    semi-implicit and has no damping to treat implicitly here. All stages that such a world does not
    need are off.

    With motors, controls are thrusts [N], four per robot, on sites at the hubs. Without, the caller
    writes each robot's wrench into `qfrc_applied`, which is faster in MuJoCo.
    """
    vehicle, load = qdrone2(), payload() if with_payload else None
    bodies = "".join(mjcf_robot(vehicle, k, load, motors) for k in range(robots))
    actuators = "".join(mjcf_rotors(vehicle, k) for k in range(robots)) if motors else ""
    return f"""<mujoco>
  <option timestep="{DT}" gravity="0 0 {-GRAVITY}" integrator="Euler">
    <flag {" ".join(f'{stage}="disable"' for stage in MJCF_UNUSED)}/>
  </option>
  <worldbody>{bodies}
  </worldbody>
  <actuator>{actuators}
  </actuator>
</mujoco>
"""


if __name__ == "__main__":
    print(qdrone2())
    print(mjcf(2, with_payload=True))
