"""Repeated trials and their statistics."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable, Sequence

# 0.975 quantile of Student's t for 1, 2, ... degrees of freedom.
STUDENT = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262)


def interval(values: Sequence[float]) -> float:
    """Half the width of the 95 % interval of the mean of 2 to 10 values."""
    return STUDENT[len(values) - 2] * statistics.stdev(values) / math.sqrt(len(values))


def rounds_a_second(step: Callable[[], object], seconds: float, burst: int = 10) -> float:
    """Calls a second over about that long; the clock is read after each burst."""
    rounds, start = 0, time.perf_counter()
    while True:
        for _ in range(burst):
            step()
        rounds += burst
        taken = time.perf_counter() - start
        if taken >= seconds:
            return rounds / taken


def in_turns(
    cases: Sequence[str], trials: int, measure: Callable[[str], float]
) -> dict[str, list[float]]:
    """Rates of some cases, which take turns; prints each."""
    found: dict[str, list[float]] = {name: [] for name in cases}
    for trial in range(trials):
        for name in cases:
            found[name].append(measure(name))
            print(f"{trial + 1}/{trials} {name}: {found[name][-1]:,.0f}", flush=True)
    return found
