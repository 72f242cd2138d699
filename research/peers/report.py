"""Report of a run of the peers: a table to read, Markdown for docs, facts for JSON."""

from __future__ import annotations

import dataclasses
import pathlib
from dataclasses import dataclass
from typing import Any

from research.common.pages import head, markdown_table, plain_table
from research.peers import results
from research.peers.goals import Figure
from research.peers.results import Row

HEADINGS = head(
    "task | contestant | N | K | cores | M steps/s | by core | ours / theirs | version | mode"
    " | differences"
)
GOAL_HEADINGS = head("goal | ours | theirs | ratio | wanted |")


def rate(value: float | None) -> str:
    """Millions per second."""
    if value is None:
        return ""
    return f"{value / 1e6:.3g}" if value >= 1e5 else f"{value / 1e6:.2g}"


def task_text(row: Row) -> str:
    return f"{row.robots} robots" if row.task == "robots" else row.task


def goal_cells(figure: Figure) -> list[str]:
    return [
        figure.what,
        rate(figure.ours),
        rate(figure.theirs),
        "" if figure.ratio is None else f"{figure.ratio:.3g}",
        f"{figure.sense} {figure.goal:g}",
        figure.verdict,
    ]


@dataclass(frozen=True)
class Report:
    machine: dict[str, Any]
    rows: list[Row]
    skipped: list[str]
    figures: list[Figure]

    def cells(self, row: Row) -> list[str]:
        other = results.counterpart(row, self.rows) if row.peer != results.OURS else None
        return [
            task_text(row),
            row.contestant,
            str(row.envs),
            str(row.substeps),
            str(row.cores),
            rate(row.rate),
            rate(row.per_core),
            "" if other is None else f"{other.per_core / row.per_core:.3g}",
            row.version,
            row.mode,
            row.differs,
        ]

    def head(self) -> str:
        m = self.machine
        return (
            f"{m['machine']}, {m['processors']} cores of {m['processor']}, {m['date']}, "
            f"Skybody {m['skybody_version']}; load {m['load'][0]:.1f} when it began"
            f"{'; short trials of --quick' if m['quick'] else ''}"
        )

    def text(self) -> str:
        """The printed text."""
        parts = [
            self.head(),
            "N environments, K physics steps a call; rates in million physics steps of worlds a "
            "second (engine: environment steps); ratios by core",
            plain_table([HEADINGS, *(self.cells(row) for row in results.shown(self.rows))]),
            "goals; rates with all cores at hand, or by core where it says so:",
            plain_table([GOAL_HEADINGS, *(goal_cells(figure) for figure in self.figures)]),
            "\n".join(self.skipped),
        ]
        return "\n\n".join(part for part in parts if part)

    def markdown(self, picture: pathlib.Path | None) -> str:
        """The page in docs/results; it is beside the folder `images`."""
        link = "" if picture is None else f"![Steps per second]({linked(picture)})\n\n"
        goals = [GOAL_HEADINGS, *map(goal_cells, self.figures)]
        rows = [HEADINGS, *map(self.cells, results.shown(self.rows))]
        skipped = "".join(f"- {line}\n" for line in self.skipped) or "Nothing was skipped.\n"
        return (
            "# Peers, measured\n\n"
            "Written by `./dev bench --peers` (research/peers, whose README says how the work is "
            f"made alike); raw rows in data/peers.json. {self.head()}.\n\n"
            "N environments, K physics steps a call. Rates are million physics steps of worlds a "
            "second, a world with many robots counted once (task engine: environment steps). "
            "Ratios are by core; a peer's row stands against ours of the same task, of C++ with "
            "C++, of one step a call with one. Of each contestant: its best row, that of 1024 "
            "environments and that of one.\n\n"
            f"{link}"
            "## Goals\n\nRates with all cores at hand, or by core where it says so.\n\n"
            f"{markdown_table(goals, range(6))}\n\n"
            "## All contestants\n\n"
            f"{markdown_table(rows, range(len(HEADINGS)))}\n\n"
            f"## Skipped\n\n{skipped}"
        )

    def facts(self) -> dict[str, Any]:
        """All results, for JSON."""
        figures = [dataclasses.asdict(f) | {"verdict": f.verdict} for f in self.figures]
        return self.machine | {
            "rows": [dataclasses.asdict(row) for row in self.rows],
            "goals": figures,
            "skipped": self.skipped,
        }


def linked(picture: pathlib.Path) -> str:
    """The picture's link in the page: beside it, or in the folder `images`."""
    return f"images/{picture.name}" if picture.parent.name == "images" else picture.name
