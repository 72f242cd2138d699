"""Writes the tables of observations and infos in the READMEs of tasks from their declarations.

python -m research run task_tables

A comment in a README names the scenario of its tables. For a team the first robot's
columns are shown, with A for its name and B for another robot's.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from skybody.arguments import load

from research.common.places import ROOT

PAGE = "tasks/*/README.md"

MARK = re.compile(
    r"(<!-- (columns|infos) of (\w+), written by research/documents/task_tables\.py -->\n)"
    r".*?(<!-- end of \2 -->\n)",
    re.DOTALL,
)


def cell(text: str) -> str:
    """The text with its bars escaped, which would end a cell."""
    return text.replace("|", r"\|")


def columns(compiled: Any) -> list[str]:
    """The observation: name, size, unit, meaning; privileged columns for the critic are marked."""
    rows = ["| Column | Size | Unit | |", "|---|---|---|---|"]
    shown: set[str] = set()
    for column in compiled.observation_columns:
        if column.robot > 0 or column.source != "task":
            continue
        name = general_name(column.name, compiled.robots)
        if name in shown:
            continue
        shown.add(name)
        size = " x ".join(map(str, column.shape))
        critic = "; for the critic alone" if column.privileged else ""
        rows.append(f"| `{name}` | {size} | {column.unit} | {cell(column.doc)}{critic} |")
    return rows


def infos(compiled: Any) -> list[str]:
    """The infos: name, unit, meaning."""
    rows = ["| Value | Unit | |", "|---|---|---|"]
    shown: set[str] = set()
    for channel in compiled.info_channels:
        name = general_name(channel.name, compiled.robots)
        if name in shown or not channel.doc:
            continue
        shown.add(name)
        rows.append(f"| `{name}` | {channel.unit} | {cell(channel.doc)} |")
    return rows


def general_name(name: str, robots: Sequence[str]) -> str:
    """`quad1.quad3.offset` becomes `A.B.offset`."""
    letters = iter("AB")
    parts = [next(letters) if part in robots else part for part in name.split(".")]
    return ".".join(parts)


TABLES: dict[str, Callable[[Any], list[str]]] = {"columns": columns, "infos": infos}


def page(text: str) -> str:
    """A README with its updated tables."""

    def replaced(match: re.Match[str]) -> str:
        table = TABLES[match[2]](load(match[3], (), ()))
        return match[1] + "\n".join(table) + "\n" + match[4]

    return MARK.sub(replaced, text)


def pages() -> list[Path]:
    return sorted(ROOT.glob("tasks/*/README.md"))


def main() -> None:
    """Writes."""
    for readme in pages():
        readme.write_text(page(readme.read_text(encoding="utf-8")), encoding="utf-8")
