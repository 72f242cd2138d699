"""Fits gains of a chain of controllers to a vehicle by simulation: `skybody tune`.

`tune(vehicle, ...)` does it from Python. docs/tune.md says what is flown, what counts and what
comes out.
"""

from __future__ import annotations

from .tuner import Tuned, TuneOptions, tune
from .vehicle import TuneError, Vehicle

__all__ = ["TuneError", "TuneOptions", "Tuned", "Vehicle", "tune"]
