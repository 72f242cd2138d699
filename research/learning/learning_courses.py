"""The courses of learning.md: one row per scenario, with the criteria of success."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from research.common.places import ROOT
from research.learning.learning_flight import Flights

SEEDS = (1, 2, 3)
LAP_FACTOR = 1.3
# Lap times of the fastest lines found by `skybody plan` (race_lines.py) [s].
RACE_LINES = json.loads((ROOT / "docs/results/data/race_lines.json").read_text())["rows"]
LAPS = {row["scenario"]: row["seconds"] / row["laps"] for row in RACE_LINES}


class Limit(Protocol):
    """A figure of 100 flights and its limit."""

    @property
    def text(self) -> str:
        """The criterion in words."""

    def figure(self, flights: Flights) -> float:
        """The figure of the flights."""

    def shown(self, figure: float) -> str:
        """The formatted figure."""

    def is_met(self, figure: float) -> bool:
        """Whether the figure meets the limit; nan does not."""


@dataclass(frozen=True)
class Share:
    """Of the flights without a failure at least a share `least` meets a condition.

    The condition: an info, averaged over the last second, is below a bound; without an info: the
    task's own success at the end.
    """

    least: float
    of: str = ""  # an info
    below: float = np.inf  # its unit
    means: str = "success"

    @property
    def text(self) -> str:
        return f"{self.means} in {100 * self.least:.0f} %"

    def figure(self, flights: Flights) -> float:
        if not self.of:
            return float(flights.succeeded.mean())
        near = flights.last_second[self.of] < self.below
        return float((near & ~flights.failed).mean())

    def shown(self, figure: float) -> str:
        return f"{100 * figure:.0f} %"

    def is_met(self, figure: float) -> bool:
        return figure >= self.least


@dataclass(frozen=True)
class Whole(Share):
    """At least this share of flights ends without a failure."""

    means: str = "no failure"

    def figure(self, flights: Flights) -> float:
        return float(1.0 - flights.failed.mean())


@dataclass(frozen=True)
class Mean:
    """Mean of an info's value at the end of the flights: a bound on one side."""

    of: str
    means: str
    unit: str = ""
    most: float = np.inf
    least: float = -np.inf
    of_winners: bool = False  # of the successful flights only

    @property
    def text(self) -> str:
        if np.isfinite(self.most):
            return f"{self.means} at most {self.most:.3g} {self.unit}".rstrip()
        return f"{self.means} at least {self.least:.3g} {self.unit}".rstrip()

    def values(self, flights: Flights) -> NDArray[np.float64]:
        """One value per flight."""
        return flights.at_the_end[self.of]

    def figure(self, flights: Flights) -> float:
        values = self.values(flights)
        if self.of_winners:
            values = values[flights.succeeded]
        return float(values.mean()) if len(values) else np.nan

    def shown(self, figure: float) -> str:
        return f"{figure:.3g} {self.unit}".rstrip()

    def is_met(self, figure: float) -> bool:
        return self.least <= figure <= self.most


@dataclass(frozen=True)
class MeanOfTheWhole(Mean):
    """The same of an info's average over a flight; of a speed: length of the path over time."""

    def values(self, flights: Flights) -> NDArray[np.float64]:
        return flights.whole_flight[self.of]


@dataclass(frozen=True)
class MeanOfTheFirst(Mean):
    """The same for several racers: the value of the one that has passed the most gates."""

    racers: tuple[str, ...] = ()

    def values(self, flights: Flights) -> NDArray[np.float64]:
        gates = np.array([flights.at_the_end[f"{racer}.gates_passed"] for racer in self.racers])
        values = np.array([flights.at_the_end[f"{racer}.{self.of}"] for racer in self.racers])
        first: NDArray[np.float64] = values[gates.argmax(axis=0), np.arange(gates.shape[1])]
        return first


@dataclass(frozen=True)
class Course:
    """A scenario that is learned with its preset."""

    scenario: str
    learned: Sequence[Limit]  # all must be met
    minutes: float = 15.0  # limit of a run's duration
    error: str = ""  # the info whose last second is on the page [m]
    algorithm: str = "fast-ppo"
    seeds: tuple[int, ...] = SEEDS


def _trajectory(scenario: str, most: float = 0.1) -> Course:
    error = Mean("mean_error", "mean error", "m", most=most)
    return Course(scenario, (error, Whole(0.95)), error="position_error")


def _payload(scenario: str) -> Course:
    near = Share(0.95, "payload_error", 0.1, "payload within 0.1 m in the last second")
    return Course(scenario, (near,), error="payload_error")


def _pendulum(scenario: str) -> Course:
    # A vehicle that is not upright for the whole episode has failed.
    near = Share(0.9, "position_error", 0.3, "upright for 10 s, bob within 0.3 m in the last one")
    return Course(scenario, (near,), error="position_error")


def _formation(scenario: str) -> Course:
    near = Share(0.9, "formation_error", 0.3, "no contact, Hausdorff below 0.3 m")
    return Course(scenario, (near,), error="formation_error")


def _racing(scenario: str, gates: int, track: str = "") -> Course:
    """All gates of three laps, without opponents.

    Args:
        track: scenario whose line the laps are compared with; default: this one.
    """
    most = LAP_FACTOR * LAPS[track or scenario]
    passed = Mean("gates_passed", f"gates of {gates}", least=0.9 * gates)
    lap = Mean("lap_time", "winners' last lap", "s", most=most, of_winners=True)
    return Course(scenario, (passed, lap), minutes=30.0)


def _racing_by_eye(scenario: str, gates: int) -> Course:
    """The same on tracks and with frames that no line was planned for."""
    passed = Mean("gates_passed", f"gates of {gates}", least=0.9 * gates)
    return Course(scenario, (passed,), minutes=30.0)


def _duel(scenario: str, gates: int, track: str, racers: tuple[str, ...]) -> Course:
    """The same against an opponent: results of the leader, in races that no failure ends."""
    most = LAP_FACTOR * LAPS[track]
    passed = MeanOfTheFirst(
        "gates_passed", f"gates of {gates} by the one ahead", least=0.9 * gates, racers=racers
    )
    lap = MeanOfTheFirst(
        "lap_time", "winners' last lap", "s", most=most, of_winners=True, racers=racers
    )
    won = Share(0.9, means="a race won before either touches or misses anything")
    return Course(scenario, (passed, lap, won), minutes=30.0)


COURSES = (
    _trajectory("trajectory"),
    _trajectory("trajectory_modular"),
    _trajectory("trajectory_ctbr"),
    _trajectory("trajectory_compact", most=0.05),
    _payload("payload_learn"),
    _payload("payload_modular_learn"),
    _pendulum("pendulum_learn"),
    _pendulum("pendulum_learn_randomized"),
    _formation("formation_learn_2"),
    _formation("formation_learn"),
    _formation("formation_obstacles"),
    Course(
        "cooperative_payload_learn",
        (Share(0.8, "payload_error", 0.15, "load within 0.15 m in the last second"),),
        minutes=30.0,
        error="payload_error",
    ),
    _racing("racing", 15),
    _racing("racing_drawn", 15, track="racing"),
    _racing_by_eye("racing_vision", 15),
    _racing("racing_split_s", 12),
    _racing("racing_figure", 18),
    _duel("racing_duel", 15, "racing", ("red", "blue")),
    Course("landing", (Share(0.9),)),
    Course("landing_vision", (Share(0.9),), minutes=30.0),
    Course("obstacles", (Share(0.9),)),
    Course("obstacles_rays", (Share(0.9),)),
    Course(
        "obstacles_vision",
        (Share(0.9), MeanOfTheWhole("speed", "mean speed along the path", "m/s", least=5.0)),
        minutes=30.0,
    ),
    Course("chase", (Share(0.9),)),
    Course("chase_agents", (Share(0.9),)),
)
