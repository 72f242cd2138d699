"""Built pages for all readers: names of pictures and of the search; pictures load when seen."""

from __future__ import annotations

import re
from pathlib import Path

IMAGE = re.compile(r"<img\b[^>]*>")
SOURCE = re.compile(r'src="([^"]+)"')
DIALOG = '<div class="md-search" data-md-component="search" role="dialog">'


def finished(page: str) -> str:
    """The page's HTML: pictures without a text are named after their files."""
    page = page.replace(DIALOG, DIALOG.replace(">", ' aria-label="Search">'))
    seen = 0

    def named(found: re.Match[str]) -> str:
        nonlocal seen
        seen += 1
        image, source = found[0], SOURCE.search(found[0])
        if not re.search(r'\balt="[^"]', image) and source:
            name = Path(source[1]).stem.replace("_", " ")
            image = re.sub(r'\s*\balt="?"?', "", image).replace("<img", f'<img alt="{name}"', 1)
        # The first one is on the first screen.
        return image if seen == 1 else image.replace("<img", '<img loading="lazy"', 1)

    return IMAGE.sub(named, page)


def finish(site: Path) -> None:
    """Rewrites all pages of a built site."""
    for path in site.rglob("*.html"):
        path.write_text(finished(path.read_text()))
