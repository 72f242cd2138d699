"""Cost of a flight: error, overshoot, effort, saturation, limits of the laws, failure."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .commands import Program
from .flight import Flights

Rows = NDArray[np.float64]

# Weights of the terms: a good flight has a cost of about 1, and each term contributes a part.
WEIGHTS = {
    "step": 1.5,
    "settled": 3.0,
    "path": 4.0,
    "overshoot": 1.0,
    "shaking": 0.6,
    "effort": 4.0,
    "saturation": 1.0,
    "limited": 0.0,  # reported, not weighted: its effect is in the errors
}
LOST = 20.0  # more than any flight that is not lost
SETTLED_SHARE = 1.0 / 3.0  # of the time after the step


@dataclass(frozen=True)
class Costs:
    """Terms of n flights, each (n,), unweighted."""

    terms: dict[str, Rows]
    lost: Rows
    """share of the flight that remained when it was lost; 0: it was not lost"""

    @property
    def total(self) -> Rows:
        """(n,)"""
        weighted = sum(WEIGHTS[name] * values for name, values in self.terms.items())
        return np.where(self.lost > 0.0, LOST * (1.0 + self.lost), np.minimum(weighted, LOST))


def costs_of(program: Program, flights: Flights) -> Costs:
    """The terms, in scales of the program:

    * step: RMS error from the step to the path;
    * settled: RMS error in the last third of that;
    * path: RMS error on the path, without its first tenth;
    * overshoot: largest distance beyond the step, over all values;
    * shaking: RMS of the body's rates in the last third after the step [rad/s];
    * effort: RMS change of a rotor's command between two commands [share of its speed];
    * saturation: share of rotors' commands at 0 or at the rotor's largest speed;
    * limited: share of the flight in which a limit of a law cuts its output.
    """
    begin, end = program.step_begin, program.step_end
    settled = end - round((end - begin) * SETTLED_SHARE)
    on_path = end + (flights.steps - end) // 10
    error = flights.errors
    jump = (program.targets[begin] - program.targets[begin - 1]) / program.scale
    beyond = error[begin:end] * np.sign(jump)
    with np.errstate(over="ignore", invalid="ignore"):
        terms = {
            "step": _rms(error[begin:end]),
            "settled": _rms(error[settled:end]),
            "path": _rms(error[on_path:]),
            "overshoot": np.max(np.maximum(beyond, 0.0) * (jump != 0.0), axis=(0, 2)),
            "shaking": _rms(flights.rates[settled:end]),
            "effort": _rms(np.diff(flights.rotor_commands, axis=0)),
            "saturation": _saturation(flights.rotor_commands),
            "limited": np.asarray(np.mean(flights.limited, axis=0)),
        }
    lost = 1.0 - flights.lost_at / flights.steps
    return Costs({name: np.nan_to_num(term, nan=LOST) for name, term in terms.items()}, lost)


def _rms(values: Rows) -> Rows:
    """(n,) over times and components of (steps, n, components)."""
    return np.asarray(np.sqrt(np.mean(np.square(values), axis=(0, 2))))


def _saturation(commands: Rows) -> Rows:
    at_limit = (commands <= 1e-6) | (commands >= 1.0 - 1e-6)
    return np.asarray(np.mean(at_limit, axis=(0, 2)))
