"""The motion and values of a flight as a page takes them, at a rate that bounds its size."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from skybody import CompiledScenario
from skybody.look.flight import Flight
from skybody.look.motion import Array

MOST_SERIES = 96  # from a log
SOURCES = ("info", "sensors", "command", "action", "q")  # datasets of a log, the first ones first
BASE = ("x", "y", "z", "qw", "qx", "qy", "qz")  # ends of names of coordinates of floating bases
FASTEST = 50.0  # rows per second
NUMBERS = 6000.0  # per second of flight: a minute takes less than 1 MB, however it moves
LEAST_RATE = 2.0  # rows per second


@dataclass(frozen=True)
class Series:
    """A value over time."""

    name: str
    unit: str
    values: Array  # one a row


@dataclass(frozen=True)
class Samples:
    """Rows of a flight, and the scenario in which it was flown."""

    compiled: CompiledScenario
    episode: int
    drawn: dict[str, float]  # values of the episode's parameters by path
    body_names: list[str]
    time: Array  # [s]
    poses: Array  # rows x bodies x 7: position (W) [m], quaternion w x y z
    rotor_speed: Array  # rows x rotors [rad/s]
    goals: dict[str, Array]  # by body: rows x 4, position (W) [m] and yaw [rad]
    series: list[Series]
    touching: NDArray[np.bool_]
    events: list[tuple[float, str]]


def of_flight(flight: Flight) -> Samples:
    """The samples of a flight log; of a long one only their rows are in memory.

    Raises:
        InputError: its scenario cannot be loaded any more.
    """
    columns = list(islice(logged(flight), MOST_SERIES))
    width = 7 * len(flight.body_names) + len(flight.rotor_names) + 4 * len(flight.goal_columns)
    robots = bases_of(flight.body_names)
    rows = chosen_rows(flight.time, width + len(columns) + 3 * len(robots))
    bodies = flight.rows("bodies")[rows]
    goals = flight.goals_in(rows)
    return Samples(
        compiled=flight.compiled,
        episode=flight.episode,
        drawn=dict(flight.drawn),
        body_names=flight.body_names,
        time=flight.time[rows],
        poses=bodies[:, :, :7],
        rotor_speed=flight.rows("rotor_speed")[rows],
        goals=goals,
        series=[
            *motion_series(flight.body_names, bodies, goals),
            *(Series(name, unit, flight.series(name)[0][rows]) for name, unit in columns),
        ],
        touching=flight.touching[rows],
        events=flight.events,
    )


def chosen_rows(time: Array, width: int) -> NDArray[np.intp]:
    """Indices of the rows that the page has: the first, the last, and equally spaced ones.

    Args:
        time: of all rows [s].
        width: numbers in a row.
    """
    duration = max(float(time[-1] - time[0]), 1e-9)
    rate = min(FASTEST, max(NUMBERS / width, LEAST_RATE))
    stride = max(1, math.ceil((len(time) - 1) / duration / rate - 1e-6))  # less rounding
    return np.unique(np.append(np.arange(0, len(time), stride), len(time) - 1))


def bases_of(body_names: list[str]) -> dict[str, int]:
    """The first body of each robot, by the robot's name."""
    robots = [name.split(".")[0] for name in body_names]
    return {robot: robots.index(robot) for robot in dict.fromkeys(robots)}


def prefixes(robots: Iterable[str]) -> dict[str, str]:
    """The start of the names of each robot's values: `ROBOT.`; empty for a robot alone."""
    names = list(robots)
    return {name: f"{name}." if len(names) > 1 else "" for name in names}


def motion_series(
    body_names: list[str], bodies: Array, goals: dict[str, Array]
) -> Iterator[Series]:
    """Height, speed and distance from the goal of each robot.

    Args:
        bodies: rows x bodies x 10 or more: pose, velocity (W) [m/s].
    """
    robots = bases_of(body_names)
    starts = prefixes(robots)
    for robot, base in robots.items():
        prefix = starts[robot]
        yield Series(f"{prefix}height", "m", bodies[:, base, 2])
        yield Series(f"{prefix}speed", "m/s", np.linalg.norm(bodies[:, base, 7:10], axis=1))
        if (goal := goals.get(body_names[base])) is not None:
            apart = np.linalg.norm(bodies[:, base, :3] - goal[:, :3], axis=1)
            yield Series(f"{prefix}distance from the goal", "m", apart)


def logged(flight: Flight) -> Iterator[tuple[str, str]]:
    """Names and units of the log's columns, each name once; of coordinates those of joints."""
    yield "reward", ""
    seen: set[str] = set()
    for source in SOURCES:
        for name, unit in flight.columns(source):
            is_base = source == "q" and name.rpartition(".")[2] in BASE
            if not is_base and name not in seen:
                seen.add(name)
                yield name, unit
