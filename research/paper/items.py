"""Rows of items.yaml, and whether each holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from research.common.page_data import OLDER
from research.common.places import RESULTS, ROOT
from research.paper import readings

FILE = Path(__file__).with_name("items.yaml")
SENSES: dict[str, tuple[str, Callable[[float, float], bool]]] = {
    "above": ("at least", lambda figure, goal: figure >= goal),
    "below": ("below", lambda figure, goal: figure < goal),
    "equal": ("equal to", lambda figure, goal: figure == goal),
}
HOLDS, MISSED, OPEN = "holds", "missed", "not measured"


@dataclass(frozen=True)
class Item:
    """A table or figure of the paper; members are the keys of items.yaml."""

    item: str
    subject: str
    paper: str
    runs: list[str]
    minutes: float
    page: str
    reading: str
    figure: str
    goal: float
    sense: str

    @property
    def commands(self) -> list[str]:
        """Commands that make it."""
        return [f"python -m research run {run}" for run in self.runs]


@dataclass(frozen=True)
class Verdict:
    """Whether an item holds, by its page's data."""

    word: str  # HOLDS, MISSED or OPEN
    figure: float | None
    is_older: bool  # the page says that the code has changed since its data

    def __str__(self) -> str:
        return f"{self.word}, data older than the code" if self.is_older else self.word


def items(file: Path = FILE) -> list[Item]:
    """All rows, in the order of the paper."""
    rows: list[dict[str, Any]] = yaml.safe_load(file.read_text(encoding="utf-8"))
    return [Item(**row) for row in rows]


def verdict(item: Item, results: Path = RESULTS) -> Verdict:
    """Reads the item's figure and compares it with its goal."""
    try:
        figure = float(getattr(readings, item.reading)(results))
    except FileNotFoundError:
        return Verdict(OPEN, None, False)
    page = ROOT / item.page
    is_older = page.is_file() and OLDER in page.read_text(encoding="utf-8")
    reached = SENSES[item.sense][1](figure, item.goal)
    return Verdict(HOLDS if reached else MISSED, figure, is_older)


def number(value: float | None) -> str:
    """A figure for people: no digits after the point from 100 on, else three."""
    if value is None:
        return "-"
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def goal_of(item: Item) -> str:
    """The goal in words."""
    return f"{SENSES[item.sense][0]} {number(item.goal)}"
