"""Draws levels of control as rows and controllers as arrows between them, as SVG.

Plain text without a library, so that the same declarations always give the same file.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from xml.sax.saxutils import escape

ROW = 58  # pixels between levels
TOP = 30
LABEL_WIDTH = 340  # of the levels' names and values
COLUMN = 122
BAR = "actuators"  # below all levels
COLORS = ("#1f5fa8", "#b3541e", "#2e7d4f", "#7b4fa3", "#8c6d1f", "#a8324a", "#2a7f8e", "#555555")


@dataclass
class Arrow:
    """A controller that leads from one row to another."""

    name: str
    note: str
    begin: int
    end: int
    column: int = 0


def ranked(modes: dict[str, Any]) -> list[str]:
    """Levels from the highest to the lowest: each above the levels that its controllers command.

    Levels without a controller above come first; levels of acting controllers come last.
    """
    names = [s["signal"] for s in modes["signals"] if s["signal"] != "none"]
    below: dict[str, set[str]] = {name: set() for name in names}
    for mode in modes["controllers"]:
        takes, gives = mode["takes"]["signal"], mode["gives"]["signal"]
        if takes != gives and takes in below and not mode["passes_on"]:
            below[takes].add(gives)

    acts = {s["signal"] for s in modes["signals"] if s["acts"]}

    def rank(name: str, seen: frozenset[str]) -> int:
        if not below[name]:
            return 0 if name in acts else len(names)
        others = [other for other in below[name] if other not in seen]
        lower = [rank(other, seen | {name}) for other in others if below[other] or other in acts]
        return 1 + max(lower, default=0)

    return sorted(names, key=lambda name: (-rank(name, frozenset((name,))), names.index(name)))


def arrows(modes: dict[str, Any], rows: list[str]) -> list[Arrow]:
    """One arrow per mode; it leads to the actuators for acting controllers."""
    acts = {s["signal"] for s in modes["signals"] if s["acts"]}
    found = []
    for mode in modes["controllers"]:
        takes, gives = mode["takes"]["signal"], mode["gives"]["signal"]
        if mode["passes_on"]:
            continue
        begin = rows.index(takes) if takes in rows else -1
        end = len(rows) if takes == gives and gives in acts else rows.index(gives)
        found.append(Arrow(mode["plugin"], ", ".join(mode["options"]), begin, end))
    led = {rows[a.begin] for a in found if a.end == len(rows)}  # others act directly
    found += [Arrow("", "", rows.index(name), len(rows)) for name in acts - led]
    return place(sorted(found, key=lambda a: (a.begin, a.end - a.begin, a.name, a.note)))


def place(found: list[Arrow]) -> list[Arrow]:
    """Gives each arrow the first column in which it overlaps no other."""
    columns: list[list[tuple[int, int]]] = []
    for arrow in found:
        low, high = sorted((arrow.begin, arrow.end))
        for column, taken in enumerate(columns):
            if all(high <= a or low >= b for a, b in taken):
                arrow.column = column
                taken.append((low, high))
                break
        else:
            arrow.column = len(columns)
            columns.append([(low, high)])
    return found


def text(x: float, y: float, content: str, style: str) -> str:
    return f'<text x="{x:g}" y="{y:g}" class="{style}">{escape(content)}</text>'


def wrapped(content: str, width: int) -> list[str]:
    """Lines of at most `width` characters."""
    lines = [""]
    for word in content.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] += (" " if lines[-1] else "") + word
    return lines


def draw_level(y: float, name: str, meaning: str, right: float) -> list[str]:
    lines = wrapped(meaning.split(";")[0], 58)
    return [
        f'<line x1="10" y1="{y:g}" x2="{right:g}" y2="{y:g}" class="level"/>',
        text(12, y - 6, name, "name"),
        *(text(12, y + 14 + 12 * k, line, "meaning") for k, line in enumerate(lines[:3])),
    ]


def draw_arrow(arrow: Arrow, y: list[float]) -> list[str]:
    x = LABEL_WIDTH + 24 + COLUMN * arrow.column
    color = COLORS[sum(map(ord, arrow.name)) % len(COLORS)]
    begin = y[arrow.begin] if arrow.begin >= 0 else y[0] - ROW
    end = y[arrow.end]
    down = 1 if end > begin else -1
    tip = end - 8 * down
    middle = begin + 22 * down
    drawn = [
        f'<line x1="{x:g}" y1="{begin:g}" x2="{x:g}" y2="{tip:g}" stroke="{color}" '
        'stroke-width="2"/>',
        f'<circle cx="{x:g}" cy="{begin:g}" r="4" fill="{color}"/>',
        f'<path d="M{x - 5:g} {tip:g} L{x + 5:g} {tip:g} L{x:g} {end - 1 * down:g} Z" '
        f'fill="{color}"/>',
        text(x + 7, middle, arrow.name, "controller"),
    ]
    notes = wrapped(arrow.note.replace(", ", " "), 19)
    drawn += [text(x + 7, middle + 12 + 11 * k, line, "note") for k, line in enumerate(notes)]
    return drawn


STYLE = """<style>
text { font-family: sans-serif; fill: #222; }
.name { font-size: 14px; font-weight: bold; }
.meaning { font-size: 10px; fill: #666; }
.controller { font-size: 12px; font-weight: bold; }
.note { font-size: 9.5px; fill: #555; }
.level { stroke: #bbb; stroke-width: 1; }
</style>"""


def figure(modes: dict[str, Any]) -> str:
    """The whole picture."""
    rows = ranked(modes)
    meanings = {s["signal"]: s["meaning"] for s in modes["signals"]}
    found = arrows(modes, rows)
    above = 1 if any(a.begin < 0 for a in found) else 0  # a row for controllers without input
    y = [TOP + ROW * (k + above + 0.5) for k in range(len(rows) + 1)]
    columns = 1 + max((a.column for a in found), default=0)
    width = LABEL_WIDTH + 24 + COLUMN * columns
    height = y[-1] + 40
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
        f'width="{width:g}" height="{height:g}">',
        STYLE,
        f'<rect width="{width:g}" height="{height:g}" fill="white"/>',
    ]
    if above:
        parts += draw_level(y[0] - ROW, "no command", "begin a chain by themselves", width - 10)
    for name, place_y in zip(rows, y[:-1], strict=True):
        parts += draw_level(place_y, name, meanings[name], width - 10)
    parts.append(f'<rect x="10" y="{y[-1]:g}" width="{width - 20:g}" height="26" fill="#e8e8e8"/>')
    parts.append(text(12, y[-1] + 18, "rotors, joints, bodies", "name"))
    for arrow in found:
        parts += draw_arrow(arrow, y)
    return "\n".join([*parts, "</svg>"]) + "\n"
