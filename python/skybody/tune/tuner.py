"""Tuning from end to end: draws, search, held-out draws, margins."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from skybody._native import CompiledScenario

from .commands import Program, make_program
from .cost import Costs, costs_of
from .draws import DrawRanges, make_draws, with_margin_flights
from .flight import Flights, Flyer
from .gains import Gains, find_gains
from .margins import Margins, margins_of
from .search import minimize
from .vehicle import TuneError, Use, Vehicle, entries_of, uses_of

Rows = NDArray[np.float64]

HELD_OUT = 32  # draws that are not used in the search
DELAY_MARGIN = 0.010  # [s] beyond the latency
WORST_SHARE = 0.25  # weight of the worst draw in a candidate's cost; the rest is the mean over all


@dataclass(frozen=True)
class TuneOptions:
    """Options of the search. The same options give the same gains, independent of time."""

    seed: int = 0
    evaluations: int = 800
    """Number of candidates to fly."""
    population: int = 16
    """Candidates per generation."""
    draws: int = 6
    """Vehicles and winds over which each candidate flies, including the nominal one."""
    ranges: DrawRanges = field(default_factory=DrawRanges)
    fixed: tuple[str, ...] = ()
    """Gains that are not fitted: `controller.parameter`."""
    num_threads: int = 0
    """Threads that step, 0: all; changes no bits."""
    margins: bool = True

    def __post_init__(self) -> None:
        for name, least, most in (
            ("seed", 0, 2**32 - 1),
            ("evaluations", 1, 1_000_000),
            ("population", 4, 1000),
            ("draws", 1, 1000),
        ):
            value = getattr(self, name)
            if not least <= value <= most:
                raise TuneError(f"{name} is {value}; allowed: {least} to {most}")


@dataclass(frozen=True)
class Outcome:
    """One set of gains, flown over the held-out draws."""

    parameters: dict[str, dict[str, list[float]]]
    costs: Costs
    nominal: Flights
    """Flight of the nominal vehicle in still air."""
    margins: Margins | None

    @property
    def cost(self) -> float:
        return float(np.mean(self.costs.total))

    @property
    def lost(self) -> int:
        """Number of held-out flights that were lost."""
        return int(np.sum(self.costs.lost > 0.0))


@dataclass(frozen=True)
class Tuned:
    """The result of tuning."""

    vehicle: Vehicle
    options: TuneOptions
    uses: list[Use]
    """The controllers of the chain."""
    gains: Gains
    program: Program
    before: Outcome
    after: Outcome
    history: list[tuple[int, float]]
    """Candidates tried, best cost so far."""
    seconds: float

    @property
    def better_draws(self) -> int:
        """Number of held-out draws on which the new gains cost less."""
        return int(np.sum(self.after.costs.total < self.before.costs.total))


def tune(
    vehicle: Vehicle,
    options: TuneOptions | None = None,
    progress: Callable[[int, int, float], None] | None = None,
) -> Tuned:
    """Fits the gains of the vehicle's chain.

    Args:
        progress: called with the number of candidates tried, their total number, and the best cost
            so far.

    Raises:
        TuneError: a mistake that the user can correct.
    """
    options = options or TuneOptions()
    began = time.monotonic()
    compiled = vehicle.compile()
    program = make_program(compiled)
    uses = uses_of(compiled)
    gains = find_gains(compiled, options.fixed)
    # Some controllers slow their default gains down for slow rotors, but use given gains unchanged.
    # So candidates give all gains, as the written file does.
    given = entries_of(uses, gains.parameters(np.zeros(len(gains))))
    candidate = replace(vehicle, chain=f"[{', '.join(given)}]")
    tried = candidate.compile()
    history: list[tuple[int, float]] = []

    def note(count: int, cost: float) -> None:
        history.append((count, cost))
        if progress is not None:
            progress(count, options.evaluations, cost)

    with Search(candidate, tried, program, gains, options) as search:
        best, _ = minimize(
            search.costs,
            len(gains),
            options.evaluations,
            options.population,
            options.seed + 1,
            note,
        )
    held_out = make_draws(compiled, HELD_OUT + 1, _generator(options.seed, 1), options.ranges)
    with Flyer(compiled, program, held_out, 1, options.num_threads) as flyer:
        before = _outcome(vehicle, options, gains, flyer, 0.0 * best)
    with Flyer(tried, program, held_out, 1, options.num_threads) as flyer:
        after = _outcome(candidate, options, gains, flyer, best)
    return Tuned(
        vehicle,
        options,
        uses,
        gains,
        program,
        before,
        after,
        history,
        time.monotonic() - began,
    )


class Search:
    """Flies the candidates of a generation over the draws and with changed loops.

    The nominal vehicle flies with half and twice the gains of its loops (`with_margin_flights`),
    and in a separate pool with DELAY_MARGIN more latency, so that candidates without margins cost
    more.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        compiled: CompiledScenario,
        program: Program,
        gains: Gains,
        options: TuneOptions,
    ) -> None:
        self._program, self._gains = program, gains
        draws = make_draws(compiled, options.draws, _generator(options.seed, 0), options.ranges)
        delayed = vehicle.compile(vehicle.latency + DELAY_MARGIN)
        nominal = make_draws(delayed, 1, _generator(options.seed, 0), options.ranges)
        size, threads = options.population, options.num_threads
        self._flyers = (
            Flyer(compiled, program, with_margin_flights(draws), size, threads),
            Flyer(delayed, program, nominal, size, threads),
        )

    def costs(self, points: Rows) -> Rows:
        """Costs (k,) of points (k, gains)."""
        flown = [flyer.fly(self._gains, points) for flyer in self._flyers]
        total = np.hstack(
            [costs_of(self._program, f).total.reshape(len(points), -1) for f in flown]
        )
        worst = np.max(total, axis=1)
        return np.asarray((1.0 - WORST_SHARE) * np.mean(total, axis=1) + WORST_SHARE * worst)

    def __enter__(self) -> Search:
        return self

    def __exit__(self, *_: object) -> None:
        for flyer in self._flyers:
            flyer.close()


def _generator(seed: int, purpose: int) -> np.random.Generator:
    """Independent generators for the search's draws (0) and the held-out ones (1)."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, purpose])))


def _outcome(
    vehicle: Vehicle, options: TuneOptions, gains: Gains, flyer: Flyer, point: Rows
) -> Outcome:
    flights = flyer.fly(gains, point[None])
    drawn = flights.of(slice(1, None))  # the first draw is the nominal vehicle
    return Outcome(
        gains.parameters(point),
        costs_of(flyer.program, drawn),
        flights.of(slice(0, 1)),
        margins_of(vehicle, gains, point) if options.margins else None,
    )
