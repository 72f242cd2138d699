"""Laws from the commands of motors to the speeds of rotors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skybody.look.flight import Array

LAWS = {
    "speed": "the column is the speed",
    "polynomial": "c0 + c1 v + c2 v^2 ... of the column v, with `coefficients` [rad/s]",
    "speed_share": "a share of the greatest speed; `range` is the column at 0 and at 1",
    "thrust_share": "a share of the greatest thrust, which goes with the squared speed",
}


@dataclass(frozen=True)
class Law:
    """A law of LAWS."""

    kind: str
    span: tuple[float, float] | None  # columns are held to it, and a rotor stands at its lower end
    coefficients: tuple[float, ...] = ()

    def speeds(self, values: Array, factor: float, most: Array) -> Array:
        """Speeds of rotors [rad/s].

        Args:
            values: of the columns, (rows, rotors).
            factor: to rad/s, for `speed`.
            most: greatest speed of each rotor by its model [rad/s], (rotors,).
        """
        low, high = self.span or (-np.inf, np.inf)
        held = np.clip(values, low, high)
        if self.kind == "speed":
            speeds = factor * held
        elif self.kind == "polynomial":
            speeds = np.asarray(np.polynomial.polynomial.polyval(held, self.coefficients))
        else:
            share = (held - low) / (high - low)
            speeds = most * (share if self.kind == "speed_share" else np.sqrt(share))
        return np.where(held <= low, 0.0, speeds)
