"""Commands of a log that lacks some of them: the differences between rotors are damped.

The onboard loop commands the rotors several hundred times a second. A log with fewer commands
aliases the fast differences between rotors, and a constant difference is the vehicle's own trim.
`skybody identify` therefore takes a part of the differences, about their moving means over SLOW.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from skybody.identify.windows import SLOW

from research.real.recorded_flights import MOST_PWM, Reals, Recorded
from research.real.windows import faults_of


def damped(flight: Recorded, detail: float) -> Recorded:
    """A flight with a part of the differences between the rotors' commands.

    Args:
        detail: the part, 0 to 1.
    """
    pwm = np.clip(flight.pwm, 0.0, MOST_PWM)
    faults = faults_of(flight)
    apart = pwm - moving_mean(flight.time, pwm, ~(faults["impossible"] | faults["gap"]))
    own = apart - apart.mean(axis=1, keepdims=True)
    return replace(flight, pwm=pwm.mean(axis=1, keepdims=True) + detail * own)


def moving_mean(time: Reals, values: Reals, good: NDArray[np.bool_]) -> Reals:
    """Means of good rows within SLOW about each row, (rows, columns); 0 where there is none."""
    first = np.searchsorted(time, time - 0.5 * SLOW)
    last = np.searchsorted(time, time + 0.5 * SLOW, side="right")
    sums = np.cumsum(np.where(good[:, None], values, 0.0), axis=0)
    sums = np.concatenate([np.zeros((1, values.shape[1])), sums])
    counts = np.concatenate([[0], np.cumsum(good)])
    number = np.maximum(counts[last] - counts[first], 1)[:, None]
    return np.asarray((sums[last] - sums[first]) / number)
