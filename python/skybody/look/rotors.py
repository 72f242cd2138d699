"""Rotors as they are drawn: turning blades, hubs, and lines of thrust."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from skybody._native import Rotor

from .lines import Lines
from .motion import Array
from .shapes import BOX, CYLINDER, Block, Color, spins, towards

ARROW = 0.03  # length of arrows of thrust [m/N]
BLADES_SHOWN = 0.04  # speed of drawn blades over that of the rotors: else they seem to stand
BLADE: Color = (0.10, 0.10, 0.11)
THRUST: Color = (0.88, 0.55, 0.05)
GAP = 0.006  # between the place of a rotor and its blades [m]


class Rotors:
    """The rotors of a scenario."""

    def __init__(
        self, rotors: Sequence[Rotor], radii: Mapping[str, float], color: Color | None
    ) -> None:
        """Prepares the shapes.

        Args:
            radii: of the drawn blades, by the rotors' names [m].
            color: in place of their own.
        """
        self._bodies = np.array([rotor.body for rotor in rotors], np.intp)
        self._places = np.array([rotor.position for rotor in rotors]).reshape(-1, 3)
        self._axes = np.array([rotor.axis for rotor in rotors]).reshape(-1, 3)
        self._frames = towards(self._axes)
        self._directions = np.array([rotor.direction for rotor in rotors])
        self._thrusts = np.array([rotor.thrust_constant for rotor in rotors])
        radius = np.array([radii[rotor.name] for rotor in rotors])[:, None]
        paint = color or BLADE
        blade = radius * [1.0, 0.09, 0.012] + [0.0, 0.0, 1e-4]
        self._blades = Block.of(BOX, self._places, self._frames, blade, paint, shadow=False)
        hub = radius * [0.13, 0.13, 0.1]
        self._hubs = Block.of(CYLINDER, self._places, self._frames, hub, paint)

    def at(self, position: Array, axes: Array, turns: Array) -> tuple[Block, Block]:
        """Blades and hubs.

        Args:
            position, axes: of all bodies, W [m], and W from B.
            turns: angle of each rotor [rad]; none: speeds were not recorded.
        """
        turned = axes[self._bodies]
        hubs = self._hubs_at(position, turned)
        frames = turned @ self._frames
        count = len(self._directions)
        angles = (BLADES_SHOWN * turns if len(turns) else np.zeros(count)) + np.arange(count)
        blades = self._blades.at(
            hubs + GAP * frames[..., 2], frames @ spins(self._directions * angles)
        )
        return blades, self._hubs.at(hubs, frames)

    def add_thrusts(self, lines: Lines, position: Array, axes: Array, speeds: Array) -> None:
        """Adds a line for the nominal thrust at some speeds [rad/s]; none: not recorded."""
        if len(speeds) == 0:
            return
        turned = axes[self._bodies]
        hubs = self._hubs_at(position, turned)
        along = (turned @ self._axes[..., None])[..., 0]
        length = ARROW * self._thrusts * speeds**2
        lines.add_pairs(hubs, hubs + length[:, None] * along, 4.0, THRUST)

    def _hubs_at(self, position: Array, turned: Array) -> Array:
        return np.asarray(position[self._bodies] + (turned @ self._places[..., None])[..., 0])
