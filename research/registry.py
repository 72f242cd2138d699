"""The measurements: modules of this package's folders with a function main(), read from their text.

A module's docstring begins with its subject, one sentence. PAGE is the page that it writes: a name
in docs/results, or a path in the repository. No module is imported, since some need packages that
are not installed everywhere.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
INDEX = HERE.parent / "docs/results/README.md"
BEGIN, END = "<!-- pages: written by python -m research index -->\n", "<!-- end of pages -->\n"
FOLDERS = {  # in the order of the index
    "speed": "Speed",
    "peers": "Speed",
    "physics": "Physics",
    "real": "Real flights",
    "control": "Control",
    "learning": "Learning",
    "deploy": "Deployment",
    "sync": "Deployment",
    "transfer": "Transfer",
    "determinism": "Determinism",
    "documents": "Documents",
}


@dataclass(frozen=True)
class Measurement:
    """A module that `python -m research run` runs, or another program that writes a page."""

    name: str
    group: str  # of the index
    subject: str  # one sentence
    page: str = ""  # "": prints only
    command: str = ""  # of another program
    module: str = ""

    @property
    def made_by(self) -> str:
        """The command without options."""
        return self.command or f"python -m research run {self.name}"


OTHERS = (
    Measurement(
        "benchmarks",
        "Speed",
        "Method of speed measurements, and the engine's cost relative to bare Simbody.",
        "benchmarks",
        "./dev bench",
    ),
    Measurement(
        "python_task",
        "Learning",
        "Whether a task written in Python is learned.",
        "python_task",
        "python examples/python_task.py",
    ),
    Measurement(
        "paper",
        "Documents",
        "Every table and figure of the GzDRL paper, and whether it holds.",
        "paper",
        "python -m research paper --page",
    ),
    Measurement(
        "fuzz_results", "Determinism", "Findings from mutated inputs.", "fuzz_results", "./dev fuzz"
    ),
)


def measurement(path: Path) -> Measurement | None:
    """The row of a module, or None if it has no main(), or is a peer's program."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    has_guard = any(
        isinstance(node, ast.If) and "__name__" in ast.unparse(node.test) for node in tree.body
    )
    if "main" not in names or has_guard:
        return None
    constants = {
        target.id: node.value.value
        for node in tree.body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    subject = " ".join((ast.get_docstring(tree) or "").partition("\n\n")[0].split())
    module = ".".join(("research", *path.relative_to(HERE).with_suffix("").parts))
    group = FOLDERS[path.parent.name]
    return Measurement(path.stem, group, subject, constants.get("PAGE", ""), module=module)


def measurements() -> list[Measurement]:
    """All modules with a main(), in the order of the index."""
    files = [path for folder in FOLDERS for path in sorted((HERE / folder).glob("*.py"))]
    return [row for row in map(measurement, files) if row is not None]


def groups() -> list[str]:
    """Titles of the index, in its order."""
    return list(dict.fromkeys(FOLDERS.values()))


def index() -> str:
    """The index of pages of docs/results that exist: one table, by group."""
    rows = ["| page | subject | made by |", "| --- | --- | --- |"]
    pages = {path.stem for path in INDEX.parent.glob("*.md")}
    found = [row for row in (*measurements(), *OTHERS) if row.page in pages]
    for row in sorted(found, key=lambda row: groups().index(row.group)):
        subject = row.subject.removesuffix(".")
        rows.append(f"| [{row.page}.md]({row.page}.md) | {subject} | `{row.made_by}` |")
    return "\n".join(rows) + "\n"


def page() -> str:
    """docs/results/README.md with the updated index."""
    before, rest = INDEX.read_text(encoding="utf-8").split(BEGIN)
    return before + BEGIN + index() + END + rest.split(END)[1]
