"""Fits gains of a chain of controllers to a vehicle by simulation: `skybody tune`.

`tune(vehicle, ...)` does it from Python. docs/tune.md describes the flights, the cost and the
results.
"""

from __future__ import annotations

from .tuner import Tuned, TuneOptions, tune
from .vehicle import TuneError, Vehicle

__all__ = ["TuneError", "TuneOptions", "Tuned", "Vehicle", "tune"]
