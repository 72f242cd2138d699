"""Rows of results: their fields, the rows that represent a contestant, and the comparisons."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields
from typing import Any

OURS, LIMIT = "Skybody", "limit"
CPP = {
    "mujoco_cpp": "MuJoCo (C++)",
    "bullet_cpp": "Bullet (C++)",
}  # programs, by their names in the table


@dataclass(frozen=True)
class Row:
    """One measurement; `rate` counts physics steps of worlds (task engine: environment steps)."""

    peer: str
    version: str
    engine: str
    task: str  # hover, payload, robots or engine
    envs: int
    robots: int  # in each world
    substeps: int  # physics steps a call
    cores: int
    rate: float  # [1/s]
    unit: str
    differs: str
    mode: str

    @property
    def per_core(self) -> float:
        return self.rate / self.cores

    @property
    def contestant(self) -> str:
        """The contestant's name in the table: ours and MuJoCo have several ways."""
        if self.peer == OURS:
            return f"{OURS} ({self.way})"
        if self.peer == "MuJoCo":
            return f"MuJoCo ({self.mode.split(',')[0]})"
        return CPP.get(self.peer, self.peer)

    @property
    def is_rk4(self) -> bool:
        """Whether a peer uses Runge-Kutta of order 4 with fixed steps (not an adaptive RK45)."""
        return re.search(r"\bRK4\b", f"{self.differs}; {self.mode}") is not None

    @property
    def way(self) -> str:
        """The way of our row that a peer's row is compared with."""
        if "no joint observation" in self.mode:
            return "C++, no joint observation"
        for word in ("C++", "rk4", "as shipped"):
            if word in self.mode:
                return word
        return "Python"


Test = Callable[[Row], bool]
NAMES = tuple(field.name for field in fields(Row))


def read(facts: dict[str, Any]) -> Row:
    """A row from a script's line.

    Raises:
        ValueError: a field is missing, or the rate is invalid.
    """
    missing = [name for name in NAMES if name not in facts]
    if missing:
        raise ValueError(f"a row without {', '.join(missing)}")
    row = Row(**{name: facts[name] for name in NAMES})
    for value in (row.rate, row.cores, row.envs, row.robots, row.substeps):
        if not isinstance(value, int | float) or not 0 < value < math.inf:
            raise ValueError(f"a row with {value!r} where a number above 0 belongs")
    return row


def best_of_sittings(rows: Iterable[Row]) -> list[Row]:
    """One row per measurement: the fastest of those that differ only in the rate."""
    best: dict[tuple[Any, ...], Row] = {}
    for row in rows:
        key = tuple(getattr(row, name) for name in NAMES if name != "rate")
        if key not in best or row.rate > best[key].rate:
            best[key] = row
    return list(best.values())


def quickest(rows: Iterable[Row], test: Test) -> Row | None:
    """The fastest row per core."""
    found = [row for row in rows if test(row)]
    return max(found, key=lambda row: row.per_core, default=None)


def on_all_cores(rows: Iterable[Row], test: Test) -> Row | None:
    """The fastest row with any number of cores."""
    found = [row for row in rows if test(row)]
    return max(found, key=lambda row: row.rate, default=None)


def shown(rows: list[Row]) -> list[Row]:
    """The rows of the table, the fastest contestant first.

    They are, of each contestant and task: the best row with one step per call and with several, the
    one with 1024 environments and the one with one.
    """
    groups: dict[tuple[str, int, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row.task, row.robots, row.contestant), []).append(row)
    tasks = ["hover", "payload", "robots", "engine"]
    ranked = sorted(
        groups.items(),
        key=lambda item: (
            tasks.index(item[0][0]) if item[0][0] in tasks else len(tasks),
            item[0][1],
            -max(row.per_core for row in item[1]),
        ),
    )
    picked: list[Row] = []
    for _, group in ranked:
        candidates = [
            on_all_cores(group, lambda row: row.substeps == 1),
            on_all_cores(group, lambda row: row.substeps > 1),
            on_all_cores(group, lambda row: row.envs == 1024 and row.substeps == 1),
            on_all_cores(group, lambda row: row.envs == 1 and row.substeps == 1),
        ]
        picked += [row for row in dict.fromkeys(candidates) if row is not None]
    return picked


def counterpart(row: Row, rows: list[Row]) -> Row | None:
    """Our row to compare with a peer's row. None: there is no such row.

    It has the same task and number of robots, and is C++ for C++, RK4 for RK4, one step per call
    for one and several for several. One environment is compared with one, otherwise each is at its
    best number. It has the same number of cores if there is such a row, and at 1024 environments
    the same number of environments.
    """
    way = "C++" if row.peer in CPP or row.peer == LIMIT else "Python"
    if row.is_rk4:
        way = "rk4"
    alone = row.envs == 1 and way != "C++"
    ways = ("C++", "Python") if row.peer == LIMIT else (way,)
    found = [
        own
        for own in rows
        if own.peer == OURS
        and (own.task, own.robots) == (row.task, row.robots)
        and own.way in ways
        and (own.envs == 1) == alone
        and (own.substeps > 1) == (row.substeps > 1)
    ]
    wishes: list[Test] = [
        lambda own: own.cores == row.cores,
        lambda own: row.envs != 1024 or own.envs == 1024,
    ]
    for wish in wishes:
        found = [own for own in found if wish(own)] or found
    return quickest(found, lambda own: True)
