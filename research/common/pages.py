"""Pages: tables, figures in words, and writing of page and data."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from research.common import page_data
from research.common.places import shown


def markdown_table(rows: Sequence[Sequence[Any]], text: Sequence[int] = (0,)) -> str:
    """A table; the first row is the head.

    Args:
        text: columns that are text; the others are numbers.
    """
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in rows]
    sides = ("---" if k in text else "---:" for k in range(len(rows[0])))
    lines.insert(1, f"| {' | '.join(sides)} |")
    return "\n".join(lines)


def head(names: str) -> list[str]:
    """Names of columns, separated by bars."""
    return [name.strip() for name in names.split("|")]


def between(text: str, begin: str, end: str, content: str) -> str:
    """`text` with `content` between two marks."""
    before, rest = text.split(begin)
    return before + begin + content + end + rest.split(end)[1]


def plain_table(rows: Sequence[Sequence[str]]) -> str:
    """A table for a terminal; the first column is text."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join(
        "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]).rstrip()
        for row in rows
    )


def thousands(rate: float, half: float | None = None) -> str:
    """A rate in thousands per second, with its interval."""
    digits = 0 if rate >= 1e6 else 1
    text = f"{rate / 1e3:,.{digits}f}"
    return text if half is None else f"{text} ± {half / 1e3:,.{digits}f}"


def percent(share: float) -> str:
    """A share in 0 ... 1 in percent."""
    return f"{100.0 * share:.0f}"


def write_json(path: Path, content: Any) -> None:
    """Writes `content`, one line per value."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content, indent=1) + "\n")


def write_page(
    folder: Path, name: str, text: str, content: Any = None, keeps: bool = False
) -> None:
    """Prints a page, and writes it with its figures as JSON.

    Args:
        text: begins with the title's line.
        content: figures of data/NAME.json; None: there is no such file.
        keeps: some of the data are older: the page keeps its data line, which is the oldest's.
    """
    if content is not None:
        write_json(folder / f"data/{name}.json", content)
    page_data.write(folder / f"{name}.md", text, keeps)
    print(f"{text}\nwritten: {shown(folder / f'{name}.md')}")
