"""Rows of plan.yaml, and whether their pages are those of today's sources."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import yaml

from research import registry
from research.common import page_data
from research.common.places import PROGRAMS, RESULTS, ROOT

FILE = Path(__file__).with_name("plan.yaml")
# A change of these changes no data.
NO_SOURCES = ("docs", "tests", "*.md", ".github", ".ci", "CITATION.cff")
REMEDIES = {
    "package": "pip install it, or ./dev build",
    "program": "./dev build release benchmarks",
    "tool": "install it (perf: apt install linux-perf)",
    "folder": "recorded flights are no part of the repository; docs/imports.md",
    "firmware": "scripts/build_betaflight.sh FOLDER makes it",
    "neural_swarm": "a checkout of github.com/aerorobotics/neural-swarm",
}


@dataclass(frozen=True)
class Given:
    """Files that only the caller knows."""

    firmware: Path | None = None
    neural_swarm: Path | None = None


@dataclass(frozen=True)
class Row:
    """A row of the plan; members are the keys of plan.yaml."""

    name: str
    minutes: float
    options: str = ""
    command: str = ""
    page: str = ""
    needs: list[str] = field(default_factory=list)
    by_hand: bool = False
    quick: str = "--quick --out {out}"

    def words(self, given: Given, out: Path | None = None) -> list[str]:
        """The command.

        Args:
            out: folder of a trial; None: no trial.
        """
        python = sys.executable
        for need in self.needs:
            if need.startswith("python "):
                python = str(python_of(need.split()[1]))
        first, *more = (self.command or f"python -P -m research run {self.name}").split()
        options = self.options if out is None else self.quick
        places = {"firmware": given.firmware, "neural_swarm": given.neural_swarm, "out": out}
        words = [word.format(**places) for word in options.split()]
        return [python if first == "python" else first, *more, *words]


def rows(file: Path = FILE) -> list[Row]:
    """All rows, in their order. A row without `page` has the page of its measurement."""
    pages = {row.name: row.page for row in (*registry.measurements(), *registry.OTHERS)}
    found = yaml.safe_load(file.read_text(encoding="utf-8"))
    return [Row(**{"page": pages.get(row["name"], ""), **row}) for row in found]


def missing(row: Row, given: Given) -> str | None:
    """The first need that is absent, with its remedy; None: all are there."""
    for need in row.needs:
        kind, _, name = need.partition(" ")
        if kind in ("python", "overlay"):
            is_there, remedy = python_of(name).exists(), f"./dev {name} installs it"
        elif kind == "peers":
            is_there, remedy = has_peers(), "pip must reach a package index"
        else:
            is_there, remedy = has(kind, name, given), REMEDIES[kind]
        if not is_there:
            return f"needs {need}: {remedy}"
    return None


def python_of(name: str) -> Path:
    """The Python of an environment below .peers."""
    return ROOT / f".peers/{name}/bin/python"


def has(kind: str, name: str, given: Given) -> bool:
    """Whether a package, a program, a tool or a folder is there, or a file is given."""
    if kind == "package":
        return importlib.util.find_spec(name) is not None
    if kind == "program":
        return (PROGRAMS / name).is_file()
    if kind == "tool":
        return shutil.which(name) is not None
    if kind == "folder":
        return (ROOT / name).is_dir()
    return getattr(given, kind) is not None


def has_peers() -> bool:
    """Whether peers are installed, or pip reaches a package index."""
    if any((ROOT / ".peers").glob("*/bin/python")):
        return True
    words = [sys.executable, "-m", "pip", "index", "versions", "rotorpy", "--retries", "0"]
    try:
        done = subprocess.run(words, capture_output=True, check=False, timeout=30.0)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def sources_are_of(commit: str) -> bool:
    """Whether the sources are those of a commit; documents and tests do not count."""
    if not commit or commit.endswith("-dirty"):
        return False
    words = ["git", "diff", "--quiet", commit, "--", ".", *(f":!{name}" for name in NO_SOURCES)]
    return subprocess.run(words, cwd=ROOT, capture_output=True, check=False).returncode == 0


def measured_commit(row: Row) -> str:
    """Commit of the data of the row's page; empty: the page does not tell."""
    page = RESULTS / f"{row.page}.md"
    data = page_data.stamp_of(page.read_text(encoding="utf-8")) if page.is_file() else None
    return str(data["commit"]) if data else ""
