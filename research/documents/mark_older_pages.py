#!/usr/bin/env python3
"""Notes on each page of docs/results the code changes since its data were measured.

It adds or removes the notes, and writes docs/results/paper.md again, which names older data.
--raise gives a subject a new version, --same records hashes that rounding alone has changed, and
--stamp says that a page's data are of today.

    python -m research run mark_older_pages
    python -m research run mark_older_pages --raise contact "no rebound is too fast"
    python -m research run mark_older_pages --same flight
    python -m research run mark_older_pages --stamp docs/results/memory.md

Raise a subject's version with each change that alters figures of its pages. tests/golden detects
some: for a subject with flights in `golden`, tests/python/test_result_pages.py fails if their
motion has changed without --raise or --same. See docs/results/README.md.
"""

from __future__ import annotations

import argparse
import datetime
from pathlib import Path

from research.common import page_data
from research.paper import report


def mark(page: Path) -> bool:
    """Writes the note on a page. Returns whether the page has changed."""
    text = page.read_text(encoding="utf-8")
    data = page_data.stamp_of(text)
    if data is None:
        raise SystemExit(f"{page}: no line `Data: commit ...`; --stamp {page} writes one")
    marked = page_data.stamped(page.stem, text, data)
    page.write_text(marked, encoding="utf-8")
    return marked != text


def change(subject: str, words: str | None) -> None:
    """Records the golden hashes of today, and with `words` a new version."""
    versions = page_data.read_versions()
    row = versions["subjects"][subject]
    row["golden"] = {flight: page_data.motion_of(flight) for flight in row["golden"]}
    if words is not None:
        date = datetime.date.today().isoformat()
        row["changes"].append({"date": date, "change": words.rstrip(".")})
    page_data.write_versions(versions)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    subjects = list(page_data.read_versions()["subjects"])
    one = parser.add_mutually_exclusive_group()
    one.add_argument("--raise", dest="raised", nargs=2, metavar=("SUBJECT", "CHANGE"))
    one.add_argument("--same", choices=subjects)
    one.add_argument("--stamp", type=Path, metavar="PAGE")
    options = parser.parse_args()
    if options.raised:
        if options.raised[0] not in subjects:
            parser.error(f"no subject `{options.raised[0]}`; there are {', '.join(subjects)}")
        change(*options.raised)
    elif options.same:
        change(options.same, None)
    elif options.stamp:
        page_data.write(options.stamp, options.stamp.read_text(encoding="utf-8"))
    for page in page_data.pages():
        if mark(page):
            print(f"marked {page.relative_to(page_data.ROOT)}")
    report.write()
