"""Units of columns."""

from __future__ import annotations

import math

STANDARD_GRAVITY = 9.80665  # [m/s^2]

# Factor to the SI unit, and that unit.
UNITS: dict[str, tuple[float, str]] = {
    "": (1.0, ""),
    "%": (0.01, ""),
    "s": (1.0, "s"),
    "ms": (1e-3, "s"),
    "us": (1e-6, "s"),
    "ns": (1e-9, "s"),
    "m": (1.0, "m"),
    "cm": (1e-2, "m"),
    "mm": (1e-3, "m"),
    "m/s": (1.0, "m/s"),
    "cm/s": (1e-2, "m/s"),
    "mm/s": (1e-3, "m/s"),
    "m/s^2": (1.0, "m/s^2"),
    "g": (STANDARD_GRAVITY, "m/s^2"),
    "mg": (1e-3 * STANDARD_GRAVITY, "m/s^2"),
    "rad": (1.0, "rad"),
    "deg": (math.pi / 180.0, "rad"),
    "rad/s": (1.0, "rad/s"),
    "deg/s": (math.pi / 180.0, "rad/s"),
    "rpm": (math.pi / 30.0, "rad/s"),
    "V": (1.0, "V"),
    "mV": (1e-3, "V"),
    "A": (1.0, "A"),
    "mA": (1e-3, "A"),
    "N": (1.0, "N"),
    "Pa": (1.0, "Pa"),
    "hPa": (100.0, "Pa"),
    "uT": (1.0, "uT"),
    "gauss": (100.0, "uT"),
}
