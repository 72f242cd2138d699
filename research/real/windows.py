"""Windows of recorded flights that are fit for a replay, and the reasons against the others.

A window is WARM_UP before its start, and the longest horizon after it.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from skybody.imports.channels import Samples
from skybody.imports.motion import at, quaternions_at

from research.real.recorded_flights import MOST_PWM, Reals, Recorded

HORIZONS = (0.1, 0.2, 0.5)  # [s]
WARM_UP = 0.3  # [s], of the rotors
STEP = 0.002  # of the commands [s]
STRIDE = 0.1  # between starts of windows [s]
CLEARANCE = 0.25  # above the height at rest [m]; below it is take-off, landing or the ground
MOST_GAP = 0.025  # between poses [s]
MOST_BRIDGED = 0.1  # a longer straight line in motor commands or rates is a gap of telemetry [s]
BITS = 1e-6  # relative; a bend of a line below it is rounding
REASONS = ("ground", "impossible", "gap", "saturated")


@dataclass(frozen=True)
class Windows:
    """Windows of one flight."""

    flight: Recorded
    starts: Reals  # times [s], (windows,)
    rejected: Counter[str] = field(default_factory=Counter)  # windows by the first of REASONS

    def grid(self) -> Reals:
        """Times of commands, (windows, steps): middles of STEP, from WARM_UP before the start."""
        steps = round((WARM_UP + HORIZONS[-1]) / STEP)
        return self.starts[:, None] - WARM_UP + STEP * (np.arange(steps) + 0.5)

    def on_grid(self, values: Reals) -> Reals:
        """A series of the flight on the grid, linear between rows, (windows, steps, columns)."""
        grid = self.grid()
        flat = at(Samples(self.flight.time, values), grid.ravel())
        return flat.reshape(*grid.shape, values.shape[1])

    def states(self, after: float) -> Reals:
        """Recorded states some time after the starts, (windows, 13)."""
        return states_at(self.flight, self.starts + after)


def states_at(flight: Recorded, times: Reals) -> Reals:
    """Recorded states at times, between rows linear, (times, 13)."""
    states = at(Samples(flight.time, flight.states), times)
    states[:, 3:7] = quaternions_at(Samples(flight.time, flight.states[:, 3:7]), times)
    return states


def windows_of(flight: Recorded, stride: float = STRIDE) -> Windows:
    """The windows of a flight without a reason against them."""
    faults = faults_of(flight)
    first, last = flight.time[0] + WARM_UP, flight.time[-1] - HORIZONS[-1]
    good: list[float] = []
    rejected: Counter[str] = Counter()
    for start in np.arange(first, max(last, first), stride):
        begin, middle, end = np.searchsorted(
            flight.time, [start - WARM_UP, start, start + HORIZONS[-1]]
        )
        rows = slice(max(begin - 1, 0), end + 1)
        # The warm-up may begin near the ground, for rotors turn there as in the air.
        found = {name for name in REASONS[1:] if faults[name][rows].any()}
        if faults["ground"][middle : end + 1].any():
            found.add("ground")
        if found:
            rejected[next(name for name in REASONS if name in found)] += 1
        else:
            good.append(float(start))
    return Windows(flight, np.array(good), rejected)


def faults_of(flight: Recorded) -> dict[str, NDArray[np.bool_]]:
    """Rows that speak against a window, by each of REASONS."""
    time, pwm, rates = flight.time, flight.pwm, flight.states[:, 10:]
    high = flight.states[:, 2] > flight.states[0, 2] + CLEARANCE
    rows = np.flatnonzero(high)
    ground = np.ones(len(time), bool)
    if len(rows):
        ground[rows[0] : rows[-1] + 1] = ~high[rows[0] : rows[-1] + 1]
    if not flight.has_pose:
        ground[:] = False
    steps = np.diff(time, prepend=time[0])
    bridged = straight(time, pwm) | straight(time, rates)
    return {
        "ground": ground,
        "gap": (steps > MOST_GAP) | bridged,
        "impossible": np.any((pwm < 0.0) | (pwm > MOST_PWM), axis=1),
        "saturated": np.any(pwm >= MOST_PWM, axis=1),
    }


def usable(flight: Recorded) -> NDArray[np.bool_]:
    """Rows without any fault."""
    faults = np.stack(list(faults_of(flight).values()))
    return np.asarray(~faults.any(axis=0))


def straight(time: Reals, values: Reals) -> NDArray[np.bool_]:
    """Rows on straight lines of all columns that are longer than MOST_BRIDGED.

    Telemetry that is lost was filled by straight lines, or extrapolated by one.
    """
    result = np.zeros(len(time), bool)
    if len(time) < 3:
        return result
    slopes = np.diff(values, axis=0) / np.diff(time)[:, None]
    limit = BITS * np.abs(slopes).max(axis=0) + 1e-12
    slack = 1e-3 * np.abs(slopes[1:])
    bent = (np.abs(np.diff(slopes, axis=0)) > limit + slack).any(axis=1)
    # The line before row k + 1 goes on behind it unless bent[k].
    corners: list[int] = np.concatenate([[0], np.flatnonzero(bent) + 1, [len(time) - 1]]).tolist()
    for begin, end in pairwise(corners):
        moves = np.ptp(values[begin : end + 1], axis=0).any()
        if moves and time[end] - time[begin] > MOST_BRIDGED:
            result[begin : end + 1] = True
    return result
