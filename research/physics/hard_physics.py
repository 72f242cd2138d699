"""Accuracy of fast spins, deep contact, throws, rest and joint stops at four time steps, compared
with the previous build.

    python -m research run hard_physics [--quick] [--out DIR]

The figures of the previous build are those that the page had.
"""

from __future__ import annotations

import json
from typing import Any

from research.common.machine import machine_line
from research.common.options import Options, heading
from research.common.pages import write_page
from research.common.places import RESULTS
from research.physics import hard_cases

PAGE = "hard_physics"


def cell(case: hard_cases.Case, figure: float) -> str:
    """A figure in the format of the table."""
    return "fault" if figure == float("inf") else format(figure, case.form)


def page(content: dict[str, Any], cases: list[hard_cases.Case]) -> str:
    """The page's text."""
    steps = [f"{1e3 * dt:g} ms" for dt in content["steps"]]
    lines = [f"| case | wanted | build | {' | '.join(steps)} |", "| --- | --- | --- |"]
    lines[1] += " ---: |" * len(steps)
    for case in cases:
        for build in ("before", "after"):
            figures = content[build].get(case.name)
            if figures is None:
                continue
            cells = " | ".join(cell(case, figure) for figure in figures)
            first = f"{case.name} | {case.wanted}" if build == "before" else " | "
            if not content["before"]:
                first = f"{case.name} | {case.wanted}"
            lines.append(f"| {first} | {build} | {cells} |")
    table = "\n".join(lines)
    return f"""# Hard cases of motion and contact

{machine_line(content["machine"])}

    {content["command"]}

Free spins, throws, deep starts, rest and stops, at four time steps by the default rule (midpoint).
`after` is this build, `before` the build of e6f53056 (25 November 2026), whose step took the
gyroscopic term explicitly and whose contact cut a step by speed alone. By the law of contact
nothing leaves faster than 1 / d = 0.222 m/s. `research/physics/hard_cases.py` has the cases.

{table}
"""


def main() -> int:
    options = Options(__doc__, __name__, "two steps, fewer throws, short spins").given()
    cases = hard_cases.cases(options.quick)
    after = hard_cases.measured(options.quick)
    kept = RESULTS / f"data/{PAGE}.json"
    before = {} if options.quick else json.loads(kept.read_text(encoding="utf-8"))["before"]
    content = heading("hard cases of motion and contact", options) | {
        "steps": hard_cases.steps(options.quick),
        "before": before,
        "after": after,
    }
    write_page(options.out, PAGE, page(content, cases), content)
    return 0
