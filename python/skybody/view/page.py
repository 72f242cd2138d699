"""One HTML file that plays flights: three.js, the program of the page and the flights inside."""

from __future__ import annotations

import base64
import html
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from skybody import InputError
from skybody.look.palette import ROBOTS
from skybody.train.files import write_file
from skybody.whole_output import not_written

from .live import Live, sliders_of
from .pack import Packer, rounded
from .samples import Samples
from .track import track_of
from .world import world_of

PAGE = Path(__file__).resolve().parent / "page"
LIBRARIES = {  # modules of three.js by the names that imports use
    "./three.core.js": "three.core.js.gz",
    "three": "three.module.js.gz",
    "three/OrbitControls.js": "OrbitControls.js.gz",
}
MODULES = ("pack", "track", "world", "stage", "plots", "panel", "live", "main")  # in this order


@dataclass(frozen=True)
class Shown:
    """A flight of a page."""

    samples: Samples
    label: str


@dataclass(frozen=True)
class Curve:
    """A plot beside the flights, such as a learning curve."""

    title: str
    x_label: str
    y_label: str
    points: list[tuple[float, float]]
    marks: list[tuple[float, str]] = field(default_factory=list)  # x and label of the shown flights


def document(title: str, flights: Sequence[Shown], curve: Curve | None = None) -> str:
    """The page's text."""
    packer = Packer()
    content: dict[str, Any] = {
        "title": title,
        "flights": [flight_of(shown, k, packer) for k, shown in enumerate(flights)],
        "curve": None if curve is None else curve_of(curve),
    }
    return filled(title, content, packer.text())


def flight_of(shown: Shown, number: int, packer: Packer) -> dict[str, Any]:
    """All that the page knows about a flight."""
    samples = shown.samples
    return {
        "label": shown.label,
        "color": rounded(ROBOTS[number % len(ROBOTS)]),
        "world": world_of(samples.compiled, samples.drawn, samples.body_names, packer),
        "track": track_of(samples, packer),
        "events": samples.events,
    }


def live_content(live: Live) -> tuple[dict[str, Any], str]:
    """A page's data of a running simulation, and its packed arrays."""
    packer = Packer()
    sampler = live.sampler
    flight = {
        "label": "live",
        "color": rounded(ROBOTS[0]),
        "world": world_of(live.compiled, sampler.drawn(), sampler.body_names, packer),
        "track": {
            "goals": sampler.goal_names,
            "series": [{"name": name, "unit": unit} for name, unit in sampler.names],
        },
        "events": [],
    }
    content = {
        "title": live.compiled.name,
        "live": True,
        "flights": [flight],
        "curve": None,
        "params": sliders_of(live),
    }
    return content, packer.text()


def curve_of(curve: Curve) -> dict[str, Any]:
    """A curve as the page takes it."""
    return {
        "title": curve.title,
        "x_label": curve.x_label,
        "y_label": curve.y_label,
        "points": curve.points,
        "marks": curve.marks,
    }


def filled(title: str, content: dict[str, Any], packed: str) -> str:
    """The template with style, programs and content."""
    parts = {
        "title": html.escape(title),
        "style": (PAGE / "style.css").read_text(),
        "loader": (PAGE / "loader.js").read_text(),
        "modules": for_script(modules()),
        "content": for_script(content),
        "packed": packed,
    }
    template = (PAGE / "index.html").read_text()
    return re.sub("{{([a-z]+)}}", lambda found: parts[found[1]], template)


def modules() -> list[dict[str, str]]:
    """Programs in the order of their imports: name, and text or compressed text in base64."""
    found = [
        {"name": name, "gzip": base64.b64encode((PAGE / "three" / file).read_bytes()).decode()}
        for name, file in LIBRARIES.items()
    ]
    return found + [
        {"name": f"./{name}.js", "text": (PAGE / f"{name}.js").read_text()} for name in MODULES
    ]


def for_script(value: object) -> str:
    """JSON that may stand in a <script>: no text ends the element."""
    return json.dumps(value, allow_nan=False).replace("<", "\\u003c")


def write_page(
    path: Path, title: str, flights: Sequence[Shown], curve: Curve | None = None
) -> None:
    """Writes the page; nothing is left of one that could not be finished.

    Raises:
        InputError: the file cannot be written.
    """
    try:
        write_file(path, document(title, flights, curve).encode())
    except OSError as error:
        raise InputError(not_written(path, error)) from None
