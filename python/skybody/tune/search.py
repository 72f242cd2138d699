"""The search over gains: CMA-ES, of the package `cmaes`."""

from __future__ import annotations

import contextlib
import sys
import warnings
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from skybody.extras import install_command

from .gains import LARGEST_FACTOR
from .vehicle import TuneError

Rows = NDArray[np.float64]

FIRST_SPREAD = 0.4  # of log factors: two thirds of the first candidates within 1.5


def minimize(
    evaluate: Callable[[Rows], Rows],
    size: int,
    evaluations: int,
    population: int,
    seed: int,
    progress: Callable[[int, float], None],
) -> tuple[Rows, float]:
    """The best point and its cost.

    Args:
        evaluate: costs (k,) of points (k, size).
        evaluations: number of points to try, including the defaults (zeros); rounded up to
            whole generations.
        progress: called with the number of points tried and the best cost so far.
    """
    try:
        with _without_scipy():
            from cmaes import CMA  # type: ignore[import-untyped, unused-ignore]
    except ModuleNotFoundError as error:
        raise TuneError(
            "the search needs the package `cmaes`, not installed here: " + install_command(["tune"])
        ) from error
    bound = np.log(LARGEST_FACTOR)
    search = CMA(
        mean=np.zeros(size),
        sigma=FIRST_SPREAD,
        bounds=np.tile([-bound, bound], (size, 1)),
        population_size=population,
        seed=seed,
    )
    best, cost = np.zeros(size), float(evaluate(np.zeros((1, size)))[0])
    tried = 1
    progress(tried, cost)
    while tried < evaluations:
        points = np.array([search.ask() for _ in range(population)])
        costs = evaluate(points)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of a generation that is all lost
            search.tell([(point, float(c)) for point, c in zip(points, costs, strict=True)])
        k = int(np.argmin(costs))
        if costs[k] < cost:
            best, cost = points[k], float(costs[k])
        tried += population
        progress(tried, cost)
        if search.should_stop():
            break
    return best, cost


@contextlib.contextmanager
def _without_scipy() -> Iterator[None]:
    """Hides SciPy: if it is installed, `cmaes` imports it for other searches.

    It takes 190 MB and half a second, and its OpenBLAS retries without end if memory is short.
    """
    if "scipy" in sys.modules:
        yield
        return
    sys.modules["scipy"] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        del sys.modules["scipy"]
