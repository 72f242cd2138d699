#!/usr/bin/env python3
"""Writes docs/plugin_reference.md from the headers of the plugin API.

    scripts/plugin_reference.py [--check]

--check writes nothing and exits with 1 if the page is outdated. A declaration of plugins/api
without a comment is an error: exit status 2, with its file and line.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cpp_declarations import Declaration, file_comment, read

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/plugin_reference.md"
HEAD = ROOT / "scripts/plugin_reference_head.md"
API = "plugins/api"
ABI = "core/plugin_abi"
# Members that plugin authors do not call. Comments of other such members begin with LIBRARY.
HIDDEN = {"kKind"}
LIBRARY = ("For the library", "Called by the host")
TABLES = {
    "signals": "core/plugin_abi/signals.h",
    "held": "core/base/held_inputs.h",
    "constants": "core/base/constants.h",
    "kinds": "core/base/plugin_kinds.h",
}


@dataclass
class Part:
    """A heading and the declarations of one header below it; all if `names` is empty."""

    title: str
    header: str
    names: tuple[str, ...] | None = ()  # None: no declarations, only the introduction
    intro: bool = False  # whether the header's own comment comes first
    constructors: bool = False


INFOS = ("Robot", "Body", "Link", "Rotor", "Chain", "Shape", "EnvParam")
STRUCTS = tuple(f"Skybody{name}Info" for name in INFOS)
SETUP = (
    Part("What configure() sees and declares", f"{API}/setup.h", ("Setup", "View")),
    Part(
        "Robots, bodies, rotors",
        f"{ABI}/abi.h",
        (*STRUCTS, "SkybodyJointType", "SkybodyShapeKind"),
    ),
    Part(
        "Sites and joint drives",
        f"{ABI}/abi.h",
        ("SkybodySite", "SkybodyJointDrive", "SkybodyJointMode"),
    ),
)
STEP = (
    Part(
        "What step methods read",
        f"{API}/env_view.h",
        ("EnvView", "BodyMotion", "ContactSum", "JointReaction"),
    ),
    Part("Views of values", f"{API}/values.h", ("ConstValues", "Values")),
    Part("Images", f"{ABI}/image.h", ("Image",)),
)
KIT = "plugins/task_kit"
TASK_KIT = (
    Part("Task kit: parts of a row", f"{KIT}/parts.h", intro=True),
    Part("Task kit: parts of a robot", f"{KIT}/robot_parts.h", intro=True, constructors=True),
    Part("Task kit: what a task remembers", f"{KIT}/history.h", constructors=True),
    Part("Task kit: failures and success", f"{KIT}/verdict.h", intro=True, constructors=True),
    Part("Task kit: limits of a flight", f"{KIT}/flight_limits.h", constructors=True),
    Part("Task kit: drawn targets", f"{KIT}/drawn_target.h", constructors=True),
    Part("Task kit: draws and requirements", f"{KIT}/spawn.h"),
    Part("Task kit: terms of rewards", f"{KIT}/shaping.h"),
    Part("Task kit: terms of rewards for a goal", f"{KIT}/goal_shaping.h", intro=True),
    Part("Task kit: attitudes", f"{KIT}/attitude.h"),
    Part("Task kit: obstacles", f"{KIT}/obstacles.h", intro=True),
    Part("Task kit: obstacles as robots see them", f"{KIT}/nearest_obstacles.h"),
)
LOGIC = ("logical_and", "logical_or", "logical_not", "any", "all", "none")
MATH = (
    Part("Random numbers", "core/base/math/random.h", ("Random",), intro=True),
    Part(
        "Packs and masks",
        "core/base/simd/pack.h",
        ("MaskOf", "Word", "kLanesOf", "select", *LOGIC),
        intro=True,
    ),
    Part("Words as numbers", "core/base/simd/pack_memory.h", ("to_real", "choose")),
    Part("Dual numbers", "core/base/math/dual.h", None, intro=True),
    Part("Numbers", "core/base/math/math_basic.h", intro=True),
    Part("Angles", "core/base/math/math_trig.h"),
    Part("Inverse functions of angles", "core/base/math/math_atan.h"),
    Part("Exponentials", "core/base/math/math_exp.h"),
    Part("Vectors", "core/base/math/vec3.h", intro=True),
    Part("Quaternions", "core/base/math/quat.h", intro=True),
    Part("Matrices", "core/base/math/mat3.h", intro=True),
)


PLACES = """\
`first_param` of an info is the place of its first value in `Setup::params()` and
`EnvView::param()`. The values of a constant lie from there on at these places:
`env.param(rotor.first_param + SKYBODY_ROTOR_MAX_SPEED)`. Those of joints stand behind
`first_joint_param`, as many as `joint_param_count` says; those of the world have the paths
`gravity` and `contact` (`Setup::find_params()`)."""


# --- text ---------------------------------------------------------------------------------------


def prose(doc: str) -> str:
    """A comment as Markdown: commands in words, indented parts as lists or as code."""
    doc = doc.replace("@throws nothing: ", "Throws nothing: ")
    doc = doc.replace("@returns ", "Returns ")
    doc = re.sub(r"@throws ((?:\w+::)*\w+)", r"Throws `\1`", doc)
    doc = re.sub(
        r"^Throws .*(\n  +(?![ -]).*)+", lambda m: re.sub(r"\n +", "\n", m[0]), doc, flags=re.M
    )
    doc = re.sub(r"\s*@t?param (\w+(?:, ?\w+)*)\s+", r"\n  - `\1`: ", doc)
    return "\n".join(blocks(doc.splitlines())).strip()


def blocks(lines: list[str]) -> Iterator[str]:
    """Text, lists (`  - x`, continued by lines that are indented further) and code."""
    at = 0
    while at < len(lines):
        if not lines[at].startswith("  "):
            yield escaped(lines[at])
            at += 1
            continue
        end = at
        while end < len(lines) and lines[end].startswith("  "):
            end += 1
        block = [line[2:] for line in lines[at:end]]
        at = end
        if block[0].startswith("- "):
            yield ""
            yield from map(escaped, block)
            yield ""
        else:
            language = "cpp" if block[-1].endswith(";") else "text"
            yield from (f"\n```{language}", *block, "```\n")


def escaped(line: str) -> str:
    """Escapes characters that Markdown would take for HTML, except in backticks."""
    parts = line.split("`")
    return "`".join(
        part if k % 2 else part.replace("<", "&lt;").replace("*", r"\*")
        for k, part in enumerate(parts)
    )


def shown(signature: str) -> str:
    return re.sub(r"^template <class Real> ", "", signature)


def item(declaration: Declaration) -> str:
    """A list item."""
    head = f"- `{shown(declaration.signature)}`"
    doc = prose(declaration.doc)
    if not doc:
        return head
    text = f"{head}: {doc}" if not doc.startswith(("```", "- ")) else f"{head}:\n\n{doc}"
    return re.sub(r"\n(?=[^\n])", "\n  ", text)


def table(heading: list[str], rows: list[list[str]]) -> str:
    lines = [heading, ["---"] * len(heading), *rows]
    return "\n".join(
        "| " + " | ".join(cell.replace("|", r"\|") for cell in row) + " |" for row in lines
    )


# --- declarations -------------------------------------------------------------------------------


def is_shown(declaration: Declaration, owner: str, constructors: bool) -> bool:
    signature = declaration.signature
    if declaration.name in HIDDEN or declaration.doc.startswith(LIBRARY):
        return False
    if signature.endswith(("= delete", "= default")) or declaration.name.startswith("~"):
        return False
    if declaration.is_protected and owner != "Plugin":
        return False
    return constructors or declaration.name != owner


def without_packs(declarations: list[Declaration]) -> list[Declaration]:
    """Without overloads for packs of functions that also exist here for double or Real."""
    kept: dict[str, Declaration] = {}
    for declaration in declarations:
        if "template <int W>" in declaration.signature and declaration.name in kept:
            kept[declaration.name].doc = kept[declaration.name].doc or declaration.doc
        else:
            kept.setdefault(declaration.name, declaration)
    return [d for d in declarations if d is kept[d.name] or "template <int W>" not in d.signature]


class Page:
    """The page being written, with the list of declarations without a comment."""

    def __init__(self) -> None:
        self.parts: list[str] = [HEAD.read_text().strip()]
        self.bare: list[str] = []
        self.aliases = {
            found.group(2): found.group(1)
            for found in re.finditer(
                r"using (\w+) = (Skybody\w+);", (ROOT / f"{API}/setup.h").read_text()
            )
        }

    def add(self, *texts: str) -> None:
        self.parts += [text for text in texts if text]

    def complain(self, header: str, declaration: Declaration) -> None:
        if not declaration.doc and header.startswith(API):
            self.bare.append(f"{header}:{declaration.line}: `{declaration.name}` has no comment")

    def add_class(self, header: str, declaration: Declaration, constructors: bool) -> None:
        self.complain(header, declaration)
        self.add(
            f"### {self.aliases.get(declaration.name, declaration.name)}", prose(declaration.doc)
        )
        members = [m for m in declaration.members if is_shown(m, declaration.name, constructors)]
        for member in members:
            self.complain(header, member)
        self.add("\n".join(map(item, members)))

    def add_part(self, part: Part) -> None:
        declarations = read(ROOT / part.header) if part.names is not None else []
        if part.names:
            declarations = [d for name in part.names for d in declarations if d.name == name]
        if part.title:
            self.add(f"## {part.title}")
        if part.intro:
            self.add(prose(file_comment((ROOT / part.header).read_text())))
        classes = [d for d in declarations if d.scope]
        for declaration in classes:
            self.add_class(part.header, declaration, part.constructors)
        functions = [d for d in declarations if not d.scope and is_shown(d, "", False)]
        functions = [d for d in without_packs(functions) if not d.signature.startswith("class ")]
        if functions and classes:
            self.add(f"### Functions of {part.title.lower()}")
        self.add("\n".join(map(item, functions)))

    def text(self) -> str:
        return "\n\n".join(self.parts) + "\n"


# --- tables -------------------------------------------------------------------------------------


def rows_of(name: str) -> list[tuple[str, list[str]]]:
    """Rows X(...) of a list in plain C, each with the list's macro."""
    text = re.sub(r"\\\n", " ", (ROOT / TABLES[name]).read_text())
    found = []
    for macro, body in re.findall(r"#define (SKYBODY_\w+)\(X\)((?:[^\n])*)", text):
        for row in re.findall(r"\bX\(((?:[^()\"]|\"[^\"]*\"|\([^()]*\))*)\)", body):
            cells = re.findall(r"(?:\"[^\"]*\"\s*)+|\([^()]*\)|[^,\s][^,]*", row)
            found.append((macro, [cell.strip() for cell in cells]))
    return found


def words(text: str) -> str:
    return "".join(re.findall(r'"([^"]*)"', text))


def signals() -> str:
    def count(least: str, most: str) -> str:
        if most == "0":
            return "by the robot" if least == "0" else f"{least} a point"
        return most if least == most else f"{least} to {most}"

    rows = [
        [f"`Signal::k{c[1]}`", f"`{c[2]}`", count(c[3], c[4]), words(c[5])]
        for _, c in rows_of("signals")
    ]
    return table(["signal", "in scenarios", "values", "meaning"], rows)


def held_inputs() -> str:
    rows = [[f"`HeldInput::k{c[1]}`", f"{c[4]} a {c[3]}", words(c[5])] for _, c in rows_of("held")]
    return table(["input", "values", "meaning"], rows)


def constants() -> str:
    rows = [
        [f"`{c[0]}`", f"`{words(c[2])}`", c[4], words(c[3]) or "1", words(c[9])]
        for _, c in rows_of("constants")
    ]
    return table(["place", "key", "values", "unit", "meaning"], rows)


def kinds() -> list[str]:
    return [cells[1] for _, cells in rows_of("kinds")]


# --- the page -----------------------------------------------------------------------------------


def macro_comment() -> str:
    """The comment before SKYBODY_PLUGIN."""
    text = (ROOT / f"{API}/export.h").read_text()
    lines = text[: text.index("#define SKYBODY_PLUGIN(")].rstrip().splitlines()
    comment: list[str] = []
    while lines and lines[-1].startswith("///"):
        comment.insert(0, lines.pop()[3:].removeprefix(" "))
    return prose("\n".join(comment))


def write_page() -> Page:
    page = Page()
    plugin = f"{API}/plugin.h"
    page.add("## A plugin", "`SKYBODY_PLUGIN(CLASS, NAME, VERSION, DOC)`: " + macro_comment())
    page.add_part(Part("", plugin, ("Plugin",)))
    page.add("## Kinds")
    page.add_part(Part("", plugin, tuple(kinds())))
    page.add("## What step methods write")
    page.add_part(Part("", plugin, ("Evaluation", "Start", "Held")))
    page.add("## Parameters", prose(file_comment((ROOT / f"{API}/parameter.h").read_text())))
    page.add_part(Part("", f"{API}/parameter.h", constructors=True))
    page.add_part(Part("Declarations of parameters", f"{API}/parameter_specs.h", intro=True))
    page.add_part(SETUP[0])
    page.add_part(Part("Refusal of a scenario", f"{API}/refuse.h"))
    page.add("## Signals", prose(first_paragraph("signals")), signals())
    page.add("## Held inputs", prose(first_paragraph("held")), held_inputs())
    for part in (*SETUP[1:], *STEP):
        page.add_part(part)
    page.add("## Places of constants", PLACES, constants())
    for part in (*TASK_KIT, *MATH):
        page.add_part(part)
    return page


def first_paragraph(name: str) -> str:
    return file_comment((ROOT / TABLES[name]).read_text()).split("\n\n")[0]


def main() -> int:
    parser = argparse.ArgumentParser(description="write docs/plugin_reference.md from the headers")
    parser.add_argument(
        "--check",
        action="store_true",
        help="write nothing; exit status 1 if the page is out of date",
    )
    options = parser.parse_args()
    page = write_page()
    if page.bare:
        print("\n".join(page.bare), file=sys.stderr)
        return 2
    if options.check:
        return int(not PAGE.is_file() or PAGE.read_text() != page.text())
    PAGE.write_text(page.text())
    return 0


if __name__ == "__main__":
    sys.exit(main())
