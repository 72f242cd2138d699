"""Intervals of the parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skybody.look.flight import Array

from .fit import Fit
from .parameters import LOG, Model, Parameter
from .record import Rows
from .windows import Windows

BLOCK = 2.0  # windows that begin within this time count as one draw [s]
OPEN = 0.7  # share of the deviation before the data at which a parameter counts as not told
LEAST_SHARE = 0.002  # of a constant
LEAST_PHASE = 0.12  # of the time between rows of a log
Z = 1.96  # standard deviations of an interval of 95 %


@dataclass(frozen=True)
class Interval:
    """A parameter as identified."""

    name: str
    unit: str
    nominal: float
    value: float
    low: float
    high: float
    """95 %"""
    deviation: float
    """Standard deviation of the coordinate."""
    kept: str
    """Why it is nominal; empty: it was identified."""


def covariance(fit: Fit, parameters: Sequence[Parameter], windows: Windows) -> Array:
    """Covariance of the coordinates of a fit's free parameters.

    Residuals of neighbouring windows are alike: the sum of the scores over blocks of time gives the
    variance of the gradient (a sandwich by blocks), scaled for the number of blocks. The greater of
    this and of the plain variance counts, by parameter.
    """
    priors = np.array([parameters[k].prior for k in fit.free])
    whole = fit.information + np.diag(1.0 / priors**2)
    plain = np.linalg.inv(whole)
    blocks = blocks_of(windows)
    count = int(blocks.max()) + 1
    sums = np.zeros((count, len(fit.free)))
    np.add.at(sums, blocks, fit.scores)
    sums -= sums.mean(axis=0)
    meat = sums.T @ sums * count / max(count - 1, 1) + np.diag(1.0 / priors**2)
    robust = plain @ meat @ plain
    # Few blocks tell less of the spread than many, and the fit has used up some of it.
    robust *= 1.0 + (2.0 + len(fit.free)) / max(count - 1, 1)
    least = np.array([floor_of(parameters[k], windows) for k in fit.free])
    wanted = np.maximum(np.diag(plain), least**2)
    scale = np.sqrt(np.maximum(wanted / np.diag(robust), 1.0))
    found = robust * np.outer(scale, scale)
    # No parameter is more open than it was before.
    most = np.minimum(1.0, priors / np.sqrt(np.diag(found)))
    return np.asarray(found * np.outer(most, most))


def floor_of(parameter: Parameter, windows: Windows) -> float:
    """The least deviation: the uncertainty by sampling and by the steps of the replay."""
    if parameter.form == LOG:
        return LEAST_SHARE
    if parameter.name.startswith("delay."):
        steps = [float(np.median(np.diff(t.record.command.time))) for t in windows.tracks]
        return LEAST_PHASE * max(steps)
    return 0.0


def is_open(parameter: Parameter, deviation: float) -> bool:
    """Whether the data leave a parameter about as open as it was before."""
    return deviation > OPEN * parameter.prior


def blocks_of(windows: Windows) -> Rows:
    """Number of the block of each window."""
    begins = np.array([windows.begin[windows.flight == f].min() for f in windows.flight])
    keys = np.stack([windows.flight, (windows.begin - begins) // BLOCK], axis=1)
    _, found = np.unique(keys, axis=0, return_inverse=True)
    return np.asarray(found).reshape(-1)


def intervals_of(
    model: Model, x: Array, full: Fit, spread: Array, fixed: Sequence[str]
) -> list[Interval]:
    """Intervals of all parameters.

    Args:
        model: the parameters.
        x: identified coordinates.
        full: the fit of all free parameters, which says how open each of them is.
        spread: covariance of its coordinates.
        fixed: names that the user keeps nominal.
    """
    made = []
    deviations = dict(zip(full.free, np.sqrt(np.diag(spread)), strict=True))
    for k, parameter in enumerate(model.parameters):
        deviation = float(deviations.get(k, 0.0))
        kept = ""
        if parameter.name in fixed:
            kept = "kept by --fix"
        elif is_open(parameter, deviation):
            kept = "not told by these flights"
        middle = float(x[k])
        low, high = (parameter.value(middle + sign * Z * deviation) for sign in (-1.0, 1.0))
        if parameter.form != LOG:
            low, high = max(low, parameter.low), min(high, parameter.high)
        made.append(
            Interval(
                parameter.name, parameter.unit, parameter.nominal,
                float(parameter.value(middle)), float(low), float(high), deviation, kept,
            )
        )  # fmt: skip
    return inertia_z(model, made)


def inertia_z(model: Model, made: list[Interval]) -> list[Interval]:
    """The moment of inertia about z itself: the parameter is relative to those of x and y."""
    by_name = {interval.name: interval for interval in made}
    found = by_name.get("inertia.z")
    if found is None:
        return made
    values = {interval.name: interval.value for interval in made}
    factor = model.inertia(values)[2] / found.value
    deviation = float(
        np.sqrt(
            found.deviation**2 + 0.25 * sum(by_name[f"inertia.{a}"].deviation ** 2 for a in "xy")
        )
    )
    middle = np.sqrt(found.low * found.high) * factor if found.kept else found.value * factor
    low, high = (float(middle * np.exp(sign * Z * deviation)) for sign in (-1.0, 1.0))
    other = Interval(
        found.name,
        found.unit,
        found.nominal,
        found.value * factor,
        low,
        high,
        deviation,
        found.kept,
    )
    return [other if interval is found else interval for interval in made]
