"""Limits of size in C++: at most 40 methods and 25 data members a class, 60 lines a function.

python scripts/code_limits.py [FILE...]   without files: all C++ files of the repository

A plugin's parameters are settings and do not count as members.

Not a compiler: reads the project's clang-format layout by its braces. Exit status 1: something
exceeds a limit; each is printed as file:line.
"""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from cpp_declarations import SCOPE, blank

ROOT = Path(__file__).resolve().parents[1]
METHODS, MEMBERS, LINES = 40, 25, 60
# Classes above a limit, with their counts and reasons; a count may fall, not grow.
ALLOWED = {
    ("SkybodySetup", "members"): 29,  # plain C at the plugin boundary: one list and its length each
    ("SkybodyLanes", "members"): 27,  # likewise: one array each
    ("StateLayout", "members"): 34,  # the order of state words: one member a block
    ("Setup", "methods"): 59,  # an author's declarations: one method each
    ("Simulation", "methods"): 67,  # a user's calls: one method a quantity
}
NO_MEMBER = re.compile(
    r"\b(using|friend|typedef|static_assert|static constexpr|constexpr static)\b"
)
PARAMETER = re.compile(r"(const )?\w*Parameter \w+_")  # a plugin's setting, with its description
LABEL = re.compile(r"^\s*(?:public|protected|private)\s*:(?!:)\s*")
INITIALIZERS = re.compile(r"\)\s*(?:noexcept\s*)?:(?!:)")


@dataclass
class Scope:
    """A pair of braces."""

    kind: str  # class, function, namespace, enum; value: an initializer
    name: str
    line: int
    methods: int = 0
    members: int = 0


def head_of(text: str) -> str:
    """A declaration's text without labels and template parameters."""
    while label := LABEL.match(text):
        text = text[label.end() :]
    text = text.strip()
    while text.startswith("template"):
        depth, place = 1, text.find("<") + 1
        while depth and 0 < place < len(text):
            depth += {"<": 1, ">": -1}.get(text[place], 0)
            place += 1
        text = text[place:].strip()
    return text


def kind_of(head: str, parent: str) -> tuple[str, str]:
    """Kind and name of the scope that a brace opens after a head."""
    if scope := SCOPE.match(head):
        kind = scope.group(1).split()[0]
        return {"struct": "class", "extern": "namespace"}.get(kind, kind), scope.group(2)
    is_body = parent in ("class", "namespace") and "(" in head and not re.search(r"[\w>]$", head)
    if INITIALIZERS.search(head):
        is_body = is_body and head.endswith((")", "}"))
    elif parent in ("class", "namespace") and re.search(
        r"\)[^=()]*\b(const|noexcept|override|final)$|\)\s*(const\s*)?(noexcept\s*)?->[^=]*$", head
    ):
        is_body = True
    return ("function" if is_body else "value"), re.split(r"\s*\(", head)[0].split(" ")[-1]


def add_declaration(scope: Scope, head: str) -> None:
    """Counts a declaration that ends with a semicolon inside a class."""
    if not head or NO_MEMBER.search(head) or SCOPE.match(head) or PARAMETER.match(head):
        return
    plain = re.sub(r"<[^<>]*>", "", re.sub(r"<[^<>]*>", "", head))
    if "(" in re.split(r"[={]", plain)[0].replace("operator=", ""):
        scope.methods += 1
        return
    flat = re.sub(r"\{[^{}]*\}|\([^()]*\)", "", re.sub(r"\{[^{}]*\}", "", plain))
    scope.members += 1 + flat.count(",")


def excesses(path: str, text: str) -> list[str]:
    """The classes and functions of a file that exceed a limit."""
    code, found = blank(text), []
    stack = [Scope("namespace", "", 1)]
    begin, line = 0, 1
    for place, char in enumerate(code):
        line += char == "\n"
        if char == "{":
            head = head_of(code[begin:place])
            kind, name = kind_of(head, stack[-1].kind)
            stack.append(Scope(kind, name, line))
            if kind != "value":
                begin = place + 1
        elif char == "}" and len(stack) > 1:
            scope = stack.pop()
            found += [f"{path}:{scope.line}: {e}" for e in excess_of(scope, line)]
            if scope.kind == "function" and stack[-1].kind == "class":
                stack[-1].methods += 1
            if scope.kind != "value":
                begin = place + 1
        elif char == ";" and stack[-1].kind != "value":
            if stack[-1].kind == "class":
                add_declaration(stack[-1], head_of(code[begin:place]))
            begin = place + 1
    return found


def excess_of(scope: Scope, line: int) -> list[str]:
    """The limits that a scope exceeds, which ends at a line."""
    if scope.kind == "function" and line - scope.line + 1 > LINES:
        return [f"{scope.name}() has {line - scope.line + 1} lines; at most {LINES}"]
    counts = [(scope.methods, METHODS, "methods"), (scope.members, MEMBERS, "members")]
    if scope.kind != "class":
        return []
    allowed = [(n, max(most, ALLOWED.get((scope.name, word), 0)), word) for n, most, word in counts]
    return [f"{scope.name} has {n} {word}; at most {m}" for n, m, word in allowed if n > m]


def main(paths: list[str]) -> int:
    """Prints the excesses of the given files, or of all."""
    if not paths:
        listed = subprocess.run(
            ["git", "ls-files", "*.h", "*.cpp"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        )
        paths = [str(ROOT / name) for name in listed.stdout.split()]
    found = [e for p in paths if Path(p).exists() for e in excesses(p, Path(p).read_text())]
    print("\n".join(found) if found else f"code_limits: {len(paths)} files within limits")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
