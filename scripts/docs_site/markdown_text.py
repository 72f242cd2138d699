"""Markdown as GitHub reads it, rewritten for Python-Markdown, which differs in lists and tables."""

from __future__ import annotations

import re
from collections.abc import Callable

FENCE = re.compile(r"^ *(`{3,})")
ITEM = re.compile(r"^( *)([-*]|\d+\.)( +)(?=\S)")


def outside_code(text: str, change: Callable[[str], str]) -> str:
    """The text with `change` applied to the parts outside of fenced and indented blocks."""
    parts: list[str] = []
    prose: list[str] = []
    fence = ""
    for line in text.splitlines(keepends=True):
        found = FENCE.match(line)
        is_code = bool(fence) or bool(found) or (line.startswith("    ") and not in_list(prose))
        if found and not fence:
            fence = found[1]
        elif found and found[1] == fence:
            fence = ""
        if is_code:
            parts += [change("".join(prose)), line]
            prose = []
        else:
            prose.append(line)
    return "".join([*parts, change("".join(prose))])


def in_list(lines: list[str]) -> bool:
    """Whether the next indented line continues a list item."""
    for line in reversed(lines):
        if ITEM.match(line):
            return True
        if line.strip() and not line.startswith(" "):
            return False
    return False


def for_python_markdown(text: str) -> str:
    """Lists indented by four columns a level, an empty line before each; tables with code."""
    lines: list[str] = []
    offsets: list[int] = []  # where the text of the open items begins
    fence = ""
    for line in text.splitlines():
        found = FENCE.match(line)
        if not fence and not offsets and line.startswith("    "):  # code, even if it has lists
            lines.append(line)
            continue
        if not fence:
            offsets = [o for o in offsets if not line.strip() or indent(line) >= o]
            item = ITEM.match(line)
            if item and not offsets and lines and lines[-1].strip() and needs_empty_line(lines):
                lines.append("")
            line = shifted(line, offsets)
            if item:
                offsets.append(len(item[0]))
        else:
            line = shifted(line, offsets)
        if found:
            fence = "" if fence == found[1] else fence or found[1]
        lines.append(line if fence else unescaped(line))
    return "\n".join(lines) + "\n"


def indent(line: str) -> int:
    """Number of spaces before a line."""
    return len(line) - len(line.lstrip(" "))


def shifted(line: str, offsets: list[int]) -> str:
    """A line of the innermost open item, four columns further for each."""
    if not offsets or not line.strip():
        return line
    return " " * (4 * len(offsets)) + line[min(offsets[-1], indent(line)) :]


def needs_empty_line(lines: list[str]) -> bool:
    """Whether a list item needs an empty line before it: unless the block that ends here begins
    with an item of the outermost level.
    """
    first = lines[-1]
    for line in reversed(lines):
        if not line.strip():
            break
        first = line
    return not ITEM.match(first) or indent(first) > 0


def unescaped(line: str) -> str:
    r"""`a\|b` in a table as `a|b`: in code Python-Markdown needs no backslash; and [0, pi] [rad] as
    text, not as a link.
    """

    def part(found: re.Match[str]) -> str:
        text = found[0]
        if not text.startswith("`"):
            return r"] \["
        return text.replace(r"\|", "|") if line.lstrip().startswith("|") else text

    return line if line.startswith("    ") else re.sub(r"`[^`]*`|\] \[", part, line)
