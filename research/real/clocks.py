"""One clock for a flight: commands, IMU and battery are moved to the clock of the poses.

Logs over the radio lag behind the motion capture by some milliseconds, another time in each flight.
The offset is where the gyroscope agrees best with the rates of the recorded attitude.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from skybody.imports.motion import angular_velocities

from research.real.recorded_flights import Reals, Recorded
from research.real.windows import usable

SHIFTS = np.arange(-0.06, 0.0601, 0.001)  # candidates [s]
WINDOW = 0.05  # of derivatives [s]
LEAST_ROWS = 100


def offset(flight: Recorded) -> float:
    """How far the clock of the gyroscope is ahead of that of the poses [s]; 0: too few rows."""
    rows = np.flatnonzero(usable(flight))
    if not flight.has_pose or len(rows) < LEAST_ROWS:
        return 0.0
    turned = angular_velocities(flight.time, flight.states[:, 3:7], WINDOW)[rows]
    errors = [
        np.var(at(flight, flight.states[:, 10:], shift)[rows] - turned, axis=0).sum()
        for shift in SHIFTS
    ]
    return float(SHIFTS[int(np.argmin(errors))])


def at(flight: Recorded, values: Reals, shift: float) -> Reals:
    """A series at times later by a shift, linear between rows, (rows, columns)."""
    columns = [np.interp(flight.time + shift, flight.time, column) for column in values.T]
    return np.stack(columns, axis=1)


def aligned(flight: Recorded, shift: float) -> Recorded:
    """The flight with commands and onboard sensors on the clock of the poses."""
    states = flight.states.copy()
    states[:, 10:] = at(flight, states[:, 10:], shift)
    setpoint = flight.setpoint
    return replace(
        flight,
        states=states,
        pwm=at(flight, flight.pwm, shift),
        voltage=at(flight, flight.voltage[:, None], shift)[:, 0],
        specific_force=at(flight, flight.specific_force, shift),
        setpoint=None if setpoint is None else at(flight, setpoint, shift),
    )
