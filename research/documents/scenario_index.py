"""Writes the table of scenarios/README.md from the scenarios' heads.

python -m research run scenario_index
"""

from __future__ import annotations

import re
from pathlib import Path

from skybody._native import scenario_file, shipped_scenarios

from research.common.places import ROOT

PAGE = "scenarios/README.md"
TARGET = ROOT / PAGE
BEGIN = "<!-- written by research/documents/scenario_index.py -->\n"
END = "<!-- end of scenarios -->\n"
SENTENCE = re.compile(r"(?<=[a-z0-9)%])\.(?: |$)")


def summary(scenario: Path) -> str:
    """The first sentence of the comment at the beginning of the file."""
    lines = []
    for line in scenario.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.removeprefix("#").strip())
    return SENTENCE.split(" ".join(lines))[0]


def files() -> list[Path]:
    """All scenarios, by task."""
    return sorted(Path(scenario_file(name)) for name in shipped_scenarios())


def table() -> str:
    """One row per scenario."""
    rows = ["| task | scenario | content | learned |", "| --- | --- | --- | --- |"]
    for file in files():
        task = file.parent.name
        parts = {"presets": f"training/{file.name}", "policy": f"policies/{file.stem}.h5"}
        links = [
            f"[{name}]({task}/{part})"
            for name, part in parts.items()
            if (file.parent / part).is_file()
        ]
        rows.append(
            f"| [{task}](../tasks/{task}/README.md) | [`{file.stem}`]({task}/{file.name}) "
            f"| {summary(file)} | {', '.join(links)} |"
        )
    return "\n".join(rows) + "\n"


def page() -> str:
    """scenarios/README.md with the updated table."""
    before, rest = TARGET.read_text(encoding="utf-8").split(BEGIN)
    return before + BEGIN + table() + END + rest.split(END)[1]


def main() -> None:
    """Writes the table."""
    TARGET.write_text(page(), encoding="utf-8")
