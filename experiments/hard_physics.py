"""Hard cases of motion and contact at four time steps, compared with an older build.

    .venv/bin/python experiments/hard_physics.py [--before PACKAGE] [--quick] [--out DIR]

--before: folder of an older build's Python package, such as `python` of its sources. Without it the
page keeps the older build's figures.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import hard_cases
from result_pages import add_quick, heading, option_parser, place_quick, write_page
from skybody.program import run_program
from training_runs import ROOT, machine_line

NAME = "hard_physics"


def of_build(package: Path, quick: bool) -> dict[str, list[float]]:
    """The figures of another build's Python package."""
    command = [sys.executable, hard_cases.__file__]
    done = subprocess.run(
        command + ["--quick"] * quick,
        stdout=subprocess.PIPE,
        check=True,
        env=os.environ | {"PYTHONPATH": str(package)},
    )
    return dict(json.loads(done.stdout))


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
nothing leaves faster than 1 / d = 0.222 m/s. `experiments/hard_cases.py` has the cases.

{table}
"""


def main() -> int:
    parser = option_parser(__doc__)
    add_quick(parser, "two steps, fewer throws, short spins")
    parser.add_argument("--before", type=Path, help="Python package of an older build")
    options = parser.parse_args()
    place_quick(options, NAME)
    cases = hard_cases.cases(options.quick)
    after = hard_cases.measured(options.quick)
    kept = ROOT / f"docs/results/data/{NAME}.json"
    before: dict[str, list[float]] = {}
    if options.before is not None:
        before = of_build(options.before, options.quick)
    elif kept.exists() and not options.quick:
        before = json.loads(kept.read_text(encoding="utf-8"))["before"]
    content = heading("hard cases of motion and contact", f"{NAME}.py", None) | {
        "steps": hard_cases.steps(options.quick),
        "before": before,
        "after": after,
    }
    write_page(options.report, NAME, content, page(content, cases))
    return 0


if __name__ == "__main__":
    run_program(main)
