"""Writes the table of options in docs/python.md from the list in skybody.options.

.venv/bin/python scripts/python_options.py
"""

from __future__ import annotations

from pathlib import Path

from skybody import options
from skybody.options import Option, options_of

PAGE = Path(__file__).resolve().parents[1] / "docs/python.md"
BEGIN, END = "<!-- written by scripts/python_options.py -->\n", "<!-- end of options -->\n"

TAKERS: dict[type, tuple[str, ...]] = {
    options.VectorOptions: ("make_vec",),
    options.PoolOptions: ("make_pool",),
    options.PooledOptions: ("SkybodyVecEnv",),
    options.EnvOptions: ("SkybodyEnv", "ParallelEnv"),
    options.SimulationOptions: ("Simulation",),
    options.SimulationPoolOptions: ("SimulationPool",),
    options.TaskOptions: ("PythonTaskVectorEnv",),
}


def table() -> str:
    """One row per option, with all classes and functions that take it with this default."""
    takers: dict[tuple[str, Option], list[str]] = {}
    for kind, names in TAKERS.items():
        for key, (_, option) in options_of(kind).items():
            takers.setdefault((key, option), []).extend(names)
    everybody = [name for names in TAKERS.values() for name in names]
    rows = ["| option | of | meaning |", "| --- | --- | --- |"]
    for (key, option), names in takers.items():
        of = "all" if names == everybody else ", ".join(f"`{name}`" for name in names)
        default = repr(option.default).replace("'", '"')
        rows.append(f"| `{key}={default}` | {of} | {option.doc} |")
    return "\n".join(rows) + "\n"


def page() -> str:
    """docs/python.md with the updated table."""
    before, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    return before + BEGIN + table() + END + rest.split(END)[1]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
