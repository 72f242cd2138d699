"""Frames and units of autopilots against ours.

Ours: W has x to the north, y to the west, z up; B has x forward, y to the left, z up; quaternions
w x y z are W from B. Autopilots: NED (north, east, down) and FRD (forward, right, down).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skybody.exports.frames import FLIP, FLIP_QUATERNION

Array = NDArray[np.float64]

PASCAL_PER_HECTOPASCAL = 100.0
MICROTESLA_PER_GAUSS = 100.0
EARTH_RADIUS = 6378137.0  # WGS 84: equatorial [m]
EARTH_ECCENTRICITY = 6.69437999014e-3  # WGS 84: squared


def to_ned(vector: Array) -> Array:
    """A vector (3,) with components in W as components in NED; also the reverse."""
    return np.asarray(vector * FLIP)


def to_frd(vector: Array) -> Array:
    """A vector (3,) with components in B as components in FRD; also the reverse."""
    return np.asarray(vector * FLIP)


def to_ned_from_frd(quaternion: Array) -> Array:
    """The rotation W from B (w x y z) as NED from FRD (w x y z); also the reverse."""
    return np.asarray(quaternion * FLIP_QUATERNION)


def to_enu(vector: Array) -> Array:
    """A vector (3,) with components in W as components to the east, to the north and up."""
    x, y, z = vector
    return np.array([-y, x, z])


@dataclass(frozen=True)
class Home:
    """The place on Earth of the origin of W."""

    latitude: float = 47.397742  # [deg], north; PX4's own default
    longitude: float = 8.545594  # [deg], east
    altitude: float = 488.0  # above the sea [m]

    def place(self, position: Array) -> tuple[float, float, float]:
        """Latitude [deg], longitude [deg] and altitude [m] of a position in W [m].

        W is flat: the radii of curvature are those of home.
        """
        north, east, down = to_ned(position)
        sine = math.sin(math.radians(self.latitude))
        of_prime_vertical = EARTH_RADIUS / math.sqrt(1.0 - EARTH_ECCENTRICITY * sine * sine)
        of_meridian = of_prime_vertical * (1.0 - EARTH_ECCENTRICITY)
        of_meridian /= 1.0 - EARTH_ECCENTRICITY * sine * sine
        of_parallel = of_prime_vertical * math.cos(math.radians(self.latitude))
        return (
            self.latitude + math.degrees(north / of_meridian),
            self.longitude + math.degrees(east / of_parallel),
            self.altitude - float(down),
        )


HOME = Home()


def course_over_ground(velocity: Array) -> float:
    """Direction of a velocity in W, clockwise from north, in [0, 360) [deg]; 0 at rest."""
    north, east, _ = to_ned(velocity)
    return math.degrees(math.atan2(east + 0.0, north + 0.0)) % 360.0
