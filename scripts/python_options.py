"""Writes the table of options in docs/python.md from the signatures of the constructors.

.venv/bin/python scripts/python_options.py
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_type_hints

import skybody
from skybody.env import SkybodyEnv
from skybody.multi_agent import ParallelEnv
from skybody.python_task import PythonTaskVectorEnv
from skybody.sb3 import SkybodyVecEnv

PAGE = Path(__file__).resolve().parents[1] / "docs/python.md"
BEGIN, END = "<!-- written by scripts/python_options.py -->\n", "<!-- end of options -->\n"

TAKERS: dict[str, type] = {
    "make_vec": skybody.make_vec,
    "make_pool": skybody.make_pool,
    "SkybodyVecEnv": SkybodyVecEnv,
    "SkybodyEnv": SkybodyEnv,
    "ParallelEnv": ParallelEnv,
    "Simulation": skybody.Simulation,
    "SimulationPool": skybody.SimulationPool,
    "PythonTaskVectorEnv": PythonTaskVectorEnv,
    "DifferentiableEnv": skybody.DifferentiableEnv,
}


def options_of(taker: type) -> Iterator[tuple[str, Any, str]]:
    """Name, default and meaning of each option of a constructor."""
    hints = get_type_hints(vars(taker)["__init__"], include_extras=True)
    for name, parameter in inspect.signature(taker).parameters.items():
        if meanings := getattr(hints[name], "__metadata__", ()):
            yield name, parameter.default, meanings[0]


def table() -> str:
    """One row per option, with all classes and functions that take it with this default."""
    takers: dict[tuple[str, Any, str], list[str]] = {}
    for name, taker in TAKERS.items():
        for option in options_of(taker):
            takers.setdefault(option, []).append(name)
    rows = ["| option | of | meaning |", "| --- | --- | --- |"]
    for (name, value, meaning), names in takers.items():
        of = "all" if names == list(TAKERS) else ", ".join(f"`{name}`" for name in names)
        default = repr(value).replace("'", '"')
        rows.append(f"| `{name}={default}` | {of} | {meaning} |")
    return "\n".join(rows) + "\n"


def page() -> str:
    """docs/python.md with the updated table."""
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    return before + BEGIN + table() + END + rest.split(END)[1]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
