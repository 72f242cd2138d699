"""The QDrone2 as numbers, read from its URDF and rotors.yaml by a reader of its own.

Only NumPy and Python's XML parser: programs in other environments import it.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Reals = NDArray[np.float64]
FOLDER = Path(__file__).resolve().parents[2] / "scenarios/models/qdrone2"
URDF = FOLDER / "qdrone2.urdf"
GRAVITY = 9.81  # [m/s^2]
BASE = "base_link"


@dataclass(frozen=True)
class Link:
    """A rigid part. Its centre of mass is its origin, and its axes are principal axes."""

    name: str
    origin: Reals  # from the base's origin [m]
    mass: float  # [kg]
    inertia: Reals  # diagonal [kg m^2]


@dataclass(frozen=True)
class Shape:
    """A collision shape of the base: half sizes of a box, or the radius of a sphere [m]."""

    kind: str
    origin: Reals
    size: tuple[float, ...]


@dataclass(frozen=True)
class Quadrotor:
    """Nominal constants."""

    links: tuple[Link, ...]  # the base first, then the rotors
    shapes: tuple[Shape, ...]
    turns: Reals  # of each rotor: +1 counterclockwise, seen from above, else -1
    thrust: float  # [N s^2/rad^2]
    moment: float  # [N m s^2/rad^2]
    drag: float  # of a rotor [N s^2/(m rad)]
    max_speed: float  # [rad/s]
    tau_up: float  # [s]
    tau_down: float  # [s]

    @property
    def hubs(self) -> Reals:
        """(4, 3), from the base's origin [m]."""
        return np.array([link.origin for link in self.links[1:]])

    @property
    def mass(self) -> float:
        """Of all links [kg]."""
        return sum(link.mass for link in self.links)

    @property
    def inertia(self) -> Reals:
        """Of all links about the base's origin, diagonal [kg m^2]."""
        total = np.zeros(3)
        for link in self.links:
            square = link.origin**2
            total += link.inertia + link.mass * (square.sum() - square)
        return total

    @property
    def hover_speed(self) -> float:
        """Speed of each rotor in hover [rad/s]."""
        return float(np.sqrt(self.mass * GRAVITY / (4.0 * self.thrust)))

    @property
    def mixer(self) -> Reals:
        """(4, 4): squared rotor speeds to thrust [N] and moments about the base's axes [N m]."""
        hubs = self.hubs
        rows = [np.ones(4), hubs[:, 1], -hubs[:, 0], -self.turns * self.moment / self.thrust]
        return self.thrust * np.array(rows)


def vector(text: str | None) -> Reals:
    """Three numbers of an attribute; zeros without one."""
    return np.array((text or "0 0 0").split(), float)


def links_of(root: ElementTree.Element) -> list[Link]:
    """All links, each placed by its fixed joint to the base."""
    places = {BASE: np.zeros(3)}
    for joint in root.iterfind("joint"):
        child, origin = joint.find("child"), joint.find("origin")
        assert child is not None and origin is not None
        places[child.attrib["link"]] = vector(origin.get("xyz"))
    links = []
    for link in root.iterfind("link"):
        mass, inertia = link.find("inertial/mass"), link.find("inertial/inertia")
        assert mass is not None and inertia is not None
        diagonal = np.array([float(inertia.attrib[name]) for name in ("ixx", "iyy", "izz")])
        name = link.attrib["name"]
        links.append(Link(name, places[name], float(mass.attrib["value"]), diagonal))
    return links


def shapes_of(root: ElementTree.Element) -> list[Shape]:
    """Collision shapes of the base."""
    shapes = []
    for collision in root.iterfind(f"link[@name='{BASE}']/collision"):
        origin = collision.find("origin")
        place = vector(None if origin is None else origin.get("xyz"))
        box, sphere = collision.find("geometry/box"), collision.find("geometry/sphere")
        if box is not None:
            sides = 0.5 * vector(box.attrib["size"])
            shapes.append(Shape("box", place, tuple(map(float, sides))))
        elif sphere is not None:
            shapes.append(Shape("sphere", place, (float(sphere.attrib["radius"]),)))
    return shapes


def read() -> Quadrotor:
    """The shipped vehicle."""
    root = ElementTree.parse(URDF).getroot()
    text = (FOLDER / "rotors.yaml").read_text(encoding="utf-8")
    values = {
        name: float(value) for name, value in re.findall(r"^  (\w+): ([-+.\de]+)$", text, re.M)
    }
    turns = dict(re.findall(r"link: (\w+), .*direction: (ccw|cw)", text))
    links = links_of(root)
    return Quadrotor(
        links=tuple(links),
        shapes=tuple(shapes_of(root)),
        turns=np.array([1.0 if turns[link.name] == "ccw" else -1.0 for link in links[1:]]),
        thrust=values["thrust_constant"],
        moment=values["moment_constant"],
        drag=values["drag_constant"],
        max_speed=values["max_speed"],
        tau_up=values["tau_up"],
        tau_down=values["tau_down"],
    )
