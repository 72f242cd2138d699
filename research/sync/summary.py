"""The figures of one way of stepping, as the page and its data have them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from research.common.programs import RunError
from research.sync.counting import Counted, errors, spread
from research.sync.work import Reals

QUANTILES = (0.0, 1.0, 25.0, 50.0, 75.0, 99.0, 100.0)  # [%]
EVERY = 5  # actions between two points of the spread
TOGETHER = ("in process", "lockstep")  # stepping without a clock of the simulator's own


def quantiles(values: Reals, unit: float = 1.0) -> list[float]:
    """QUANTILES of values in a unit, to 4 digits."""
    return [shortened(q / unit) for q in np.percentile(values, QUANTILES)]


def shortened(value: float) -> float:
    """A number of 4 digits."""
    return float(f"{value:.4g}")


def summary(way: str, stepping: str, loop: str, found: Counted, reference: Reals) -> dict[str, Any]:
    """The figures of the trials.

    Args:
        way: title of the middleware.
        stepping: `in process`, `lockstep` or `free-running`.
        reference: (WRENCHES, 3), the flight in process [m].

    Raises:
        RunError: steps that belong together are apart, or their flight is not the reference.
    """
    if stepping in TOGETHER:
        check(way, loop, found, reference)
    return {
        "way": way,
        "stepping": stepping,
        "loop": loop,
        "trials": len(found.position),
        "latency_ms": quantiles(found.latency, 1e-3),
        "delay_ms": quantiles(found.delay, 1e-3),
        "intervening": quantiles(found.intervening),
        "intervening_mean": shortened(float(found.intervening.mean())),
        "lost": found.lost,
        "spread_mm": [shortened(1e3 * s) for s in spread(found.position)[::EVERY]],
        "error_mm": quantiles(errors(found.position, reference), 1e-3),
        "pace": shortened(found.pace),
        "rate": shortened(found.rate),
    }


def check(way: str, loop: str, found: Counted, reference: Reals) -> None:
    """Steps that wait for each other have no step between, and the bits of one process."""
    if found.intervening.any() or found.lost:
        raise RunError(f"{way}, {loop} loop: physics steps between an odometry and its action")
    if any(not np.array_equal(flight, reference) for flight in found.position):
        raise RunError(f"{way}, {loop} loop: another flight than in process")


def rows_of(rows: Sequence[dict[str, Any]], loop: str) -> list[dict[str, Any]]:
    """The rows of a loop."""
    return [row for row in rows if row["loop"] == loop]


def label(row: dict[str, Any]) -> str:
    """Name of a row."""
    return row["way"] if row["stepping"] == "in process" else f"{row['way']}, {row['stepping']}"
