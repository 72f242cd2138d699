"""Links, anchors and hosts of a built site."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# Attributes from which a browser loads by itself.
LOADS = {"img": "src", "script": "src", "link": "href", "iframe": "src", "video": "src"}


class Links(HTMLParser):
    """The anchors, links and loaded files of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: set[str] = set()
        self.loads: set[str] = set()
        self.unnamed: list[str] = []  # pictures without a text
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value for name, value in attrs if value is not None}
        for name in ("id", "name"):
            if name in values and (name == "id" or tag == "a"):
                self.anchors.add(values[name])
        if tag == "a" and "href" in values:
            self.links.add(values["href"])
        if tag == "img" and not values.get("alt"):
            self.unnamed.append(values.get("src", ""))
        if tag in LOADS and LOADS[tag] in values:
            self.loads.add(values[LOADS[tag]])


def problems(site: Path) -> list[str]:
    """A line for each broken link or anchor, and each file that a page loads from another host."""
    pages = {path.resolve(): Links(path.read_text()) for path in sorted(site.rglob("*.html"))}
    found: list[str] = []
    for path, page in pages.items():
        if path.name == "404.html":  # a server shows it at any path
            continue
        name = path.relative_to(site.resolve())
        found += [f"{name}: {image}: a picture without a text" for image in page.unnamed]
        for link in sorted(page.links | page.loads):
            problem = problem_of(path, link, pages, link in page.loads)
            if problem:
                found.append(f"{name}: {link}: {problem}")
    return found


def problem_of(path: Path, link: str, pages: dict[Path, Links], is_loaded: bool) -> str:
    """The reason why a link is broken, or an empty text."""
    parts = urlsplit(link)
    if parts.scheme == "data" or (parts.scheme and not is_loaded):
        return ""
    if parts.scheme or parts.netloc:
        return "is loaded from another host"
    target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    if target.is_dir():
        target /= "index.html"
    if not target.exists():
        return "no such file"
    if parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
        return "no such anchor" if not parts.fragment.startswith("__") else ""
    return ""
