"""Writes the tables under "Learned" in the READMEs of tasks from docs/results/data/learning.json.

    python -m research run learned_tables

A comment in a README names the scenarios of its table. learning.py writes the data.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from research.common.places import ROOT
from research.learning.learning_courses import COURSES, Course
from research.learning.learning_report import course_cells, of

PAGE = "tasks/*/README.md"

MARK = re.compile(
    r"(<!-- learned: ([\w ]+), written by research/documents/learned_tables\.py -->\n)"
    r".*?(<!-- end of learned -->\n)",
    re.DOTALL,
)
TAIL = """
Figures of seeds {seeds} in their order, each of {episodes} drawn episodes that training does not
know, flown by `skybody run SCENARIO --policy RUN`:
[learning.md](../../docs/results/learning.md) says more, and on which machines they were trained.
"""


def table(content: dict[str, Any], courses: Sequence[Course]) -> str:
    """One line per course, and the method of its figures."""
    lines = [_cells(course, of(content["runs"], course)) for course in courses]
    filled = [name for name in lines[0] if any(line[name] for line in lines)]
    rows = [filled, ["---"] * len(filled), *([line[name] for name in filled] for line in lines)]
    seeds = ", ".join(map(str, dict.fromkeys(seed for course in courses for seed in course.seeds)))
    tail = TAIL.format(seeds=seeds, episodes=content["flights"]["episodes"])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows) + "\n" + tail


def _cells(course: Course, rows: Sequence[dict[str, Any]]) -> dict[str, str]:
    cells = course_cells(course, rows)
    return {
        "scenario": cells["task"],
        "counts as learned": cells["learned means"],
        "figures": cells["figures"],
        "median error in the last second [m]": cells["median error [m]"],
        "steps": cells["steps"],
        "seconds of training (allowed)": cells["seconds (allowed)"],
        "shipped": ", ".join(f"seed {row['seed']}" for row in rows if row["is_shipped"]),
    }


def page(text: str) -> str:
    """A README with its updated table."""
    content = json.loads((ROOT / "docs/results/data/learning.json").read_text(encoding="utf-8"))
    by_name = {course.scenario: course for course in COURSES}

    def replaced(match: re.Match[str]) -> str:
        courses = [by_name[name] for name in match[2].split()]
        return match[1] + table(content, courses) + match[3]

    return MARK.sub(replaced, text)


def pages() -> list[Path]:
    return sorted(ROOT.glob("tasks/*/README.md"))


def named(text: str) -> list[str]:
    """The scenarios whose tables a README has."""
    return [name for match in MARK.finditer(text) for name in match[2].split()]


def main() -> int:
    """Writes all tables; returns the exit code."""
    for readme in pages():
        readme.write_text(page(readme.read_text(encoding="utf-8")), encoding="utf-8")
    return 0
