"""The list of the paper's tables and figures: for a terminal, and as docs/results/paper.md."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from research.common import page_data
from research.common.pages import head, markdown_table
from research.common.places import RESULTS, ROOT
from research.paper.items import HOLDS, MISSED, OPEN, Item, Verdict, goal_of, items, number, verdict
from research.paper.readings import FEATURES
from research.paper.runs import Record, minutes

PAGE = RESULTS / "paper.md"


def listed(results: Path = RESULTS, record: Record | None = None) -> str:
    """Some lines per item: name, subject, verdict, commands, page."""
    lines = []
    rows = [(item, verdict(item, results)) for item in items()]
    for item, found in rows:
        lines.append(f"{item.item}: {item.subject}")
        figure = f"{item.figure}: {number(found.figure)}; goal: {goal_of(item)}"
        lines.append(f"    {found}; {figure}")
        if item.paper:
            lines.append(f"    the paper: {item.paper}")
        for command in item.commands or ["(part of the documentation)"]:
            lines.append(f"    {command}")
        time = f"{minutes(item, record or Record()):.0f} min"
        lines.append(f"    {item.page}" + (f", about {time}" if item.runs else ""))
    return "\n".join([*lines, count(rows)])


def count(rows: list[tuple[Item, Verdict]]) -> str:
    """How many of which verdict."""
    words = [found.word for _, found in rows]
    tables = sum(item.item.startswith("Table") for item, _ in rows)
    names = {HOLDS: "hold", MISSED: "missed", OPEN: "not measured"}
    parts = [f"{words.count(word)} {name}" for word, name in names.items() if word in words]
    return f"{tables} tables and {len(rows) - tables} figures: {', '.join(parts)}."


def table(rows: list[tuple[Item, Verdict]]) -> str:
    """One line per item."""
    cells: list[list[Any]] = [
        head("item | subject | verdict | figure | here | goal | the paper | command | minutes")
    ]
    for item, found in rows:
        commands = "<br>".join(f"`{command}`" for command in item.commands) or "-"
        page = f"[{item.subject}]({os.path.relpath(ROOT / item.page, RESULTS)})"
        place = ROOT / item.page
        subject = page if place == PAGE or place.exists() else item.subject
        goal = goal_of(item)
        cells.append(
            [
                item.item,
                subject,
                f"**{found.word}**" + (", older" if found.is_older else ""),
                item.figure,
                number(found.figure),
                goal,
                item.paper or "-",
                commands,
                f"{item.minutes:g}" if item.runs else "-",
            ]
        )
    return markdown_table(cells, (0, 1, 2, 3, 5, 6, 7))


def page(results: Path = RESULTS) -> str:
    """The page: its figures are those of the other pages' data."""
    rows = [(item, verdict(item, results)) for item in items()]
    features = "\n".join(
        f"- {name}: [{path}]({os.path.relpath(ROOT / path, RESULTS)})"
        for name, path in FEATURES.items()
    )
    return f"""\
# Every table and figure of the paper

    python -m research paper --list     # this table for a terminal
    python -m research paper --all      # runs all measurements; finished ones are not repeated
    python -m research paper --page     # writes this page

The GzDRL paper has 5 tables and 11 figures. Each has a row: its page here, the figure that decides,
read from the data of that page, the goal, and the command that makes it. "Older": the page's data
were measured before a later change of the code, which the page names. Times are about those of two
cores.

**{count(rows)}**

{table(rows)}

## Features of Table I

The last row of Table I claims these for the paper's framework; here they are in:

{features}
"""


def write() -> None:
    """Writes the page, if it is out of date."""
    if not is_current():
        page_data.write(PAGE, page())


def is_current() -> bool:
    """Whether the page is as its data say."""
    return PAGE.is_file() and page_data.body(PAGE.read_text(encoding="utf-8")) == page()
