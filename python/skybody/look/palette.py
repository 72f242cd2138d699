"""Colours of robots, the same in pictures, films and plots, and safe for the colour-blind."""

from __future__ import annotations

import numpy as np

from .shapes import Color

# Of Okabe and Ito, "Color Universal Design", 2008, without black and yellow.
ROBOTS: tuple[Color, ...] = (
    (0.000, 0.447, 0.698),
    (0.835, 0.369, 0.000),
    (0.000, 0.620, 0.451),
    (0.800, 0.475, 0.655),
    (0.902, 0.624, 0.000),
    (0.337, 0.706, 0.914),
)
# Of more: from dark to light, as viridis does.
MANY = np.array(
    [
        [0.27, 0.00, 0.33],
        [0.23, 0.32, 0.55],
        [0.13, 0.57, 0.55],
        [0.37, 0.79, 0.38],
        [0.85, 0.80, 0.2],
    ]
)


def colors(count: int) -> list[Color]:
    """Distinct colours of some robots, joints or rotors."""
    if count <= len(ROBOTS):
        return list(ROBOTS[:count])
    at = np.linspace(0.0, len(MANY) - 1.0, count)
    channels = [np.interp(at, np.arange(len(MANY)), MANY[:, k]) for k in range(3)]
    return [(float(r), float(g), float(b)) for r, g, b in zip(*channels, strict=True)]
