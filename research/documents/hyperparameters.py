"""Writes the table of hyper-parameters in docs/training.md from the list of the learners in C++.

python -m research run hyperparameters
"""

from __future__ import annotations

from typing import Any

from skybody._native import hyperparameter_rows, hyperparameters
from skybody.train.algorithms import ALGORITHMS, NATIVE

from research.common.pages import between
from research.common.places import ROOT

PAGE = "docs/training.md"

TARGET = ROOT / "docs/training.md"
BEGIN, END = (
    "<!-- written by research/documents/hyperparameters.py -->\n",
    "<!-- end of hyper-parameters -->\n",
)


def table() -> str:
    """One row per hyper-parameter, with the learners that have it."""
    listed: dict[str, tuple[str, float, float, str]] = {}
    defaults: dict[str, Any] = {}
    for algorithm in NATIVE:
        defaults.update(hyperparameters(algorithm))
        listed.update({row[0]: row for row in hyperparameter_rows(algorithm)})
    rows = ["| key | of | range | meaning |", "| --- | --- | --- | --- |"]
    for name, least, largest, meaning in listed.values():
        of = ", ".join(f"`{algorithm}`" for algorithm in having(name))
        of = "all" if len(having(name)) == len(ALGORITHMS) else of
        extent = spoken_range(defaults[name], least, largest)
        rows.append(f"| `{name}={spoken(defaults[name])}` | {of} | {extent} | {meaning} |")
    return "\n".join(rows) + "\n"


def having(name: str) -> list[str]:
    """The learners that have a hyper-parameter."""
    return [algorithm for algorithm, row in ALGORITHMS.items() if hasattr(row.defaults(), name)]


def spoken(value: Any) -> str:
    """A value in the form of `--set`."""
    if isinstance(value, bool):
        return str(value).lower()
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


def spoken_range(default: Any, least: float, largest: float) -> str:
    """A range; empty for words and bools, whose descriptions list them."""
    return "" if isinstance(default, (bool, str)) else f"{least:g} to {largest:g}"


def page() -> str:
    """docs/training.md with the updated table."""
    return between(TARGET.read_text(encoding="utf-8"), BEGIN, END, table())


def main() -> None:
    """Writes."""
    TARGET.write_text(page(), encoding="utf-8")
