#!/usr/bin/env python3
"""Builds the documentation site: `./dev docs` calls it.

    scripts/docs_site/build.py [--out build/site]

Every link and anchor is checked; a broken one is an error.
"""

from __future__ import annotations

import argparse
import logging
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml
from check import problems
from finish import finish
from mkdocs.commands.build import build
from mkdocs.config import load_config
from references import write_references
from tree import ROOT, Tree, matching

WORK = ROOT / "build/site_pages"
SITE = ROOT / "docs/site"


def version() -> str:
    """The version in CMakeLists.txt."""
    found = re.search(r"project\(Skybody VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())
    assert found is not None
    return found[1]


def commit() -> str:
    """The commit of the sources, with `-dirty` if they differ; `no commit` outside of git."""
    command = ["git", "describe", "--always", "--dirty"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "no commit"


def expanded(entries: list[Any]) -> list[Any]:
    """The navigation with patterns replaced by their pages, and without pages that do not exist."""
    found: list[Any] = []
    for entry in entries:
        title, value = next(iter(entry.items())) if isinstance(entry, dict) else ("", entry)
        if isinstance(value, list):
            value = expanded(value)
        elif "*" in value:
            value = [p for p in matching(WORK, value) if not p.endswith("results/README.md")]
        found.append({title: value} if title else value)
    return found


def settings(out: Path) -> Path:
    """MkDocs' configuration, from docs/site/site.yml."""
    config = yaml.safe_load((SITE / "site.yml").read_text())
    config["site_name"] += f" {version()}"
    config["copyright"] = f"Skybody {version()}, commit {commit()}. Apache-2.0."
    config["markdown_extensions"]["toc"] = {"permalink": True}
    config |= {"docs_dir": str(WORK), "site_dir": str(out), "nav": expanded(config["nav"])}
    path = WORK.with_suffix(".yml")
    text = yaml.safe_dump(config, sort_keys=False, allow_unicode=True)
    # GitHub's anchors.
    slug = "!!python/object/apply:pymdownx.slugs.slugify {kwds: {case: lower}}"
    text = text.replace("permalink: true", f"permalink: true\n    slugify: {slug}")
    path.write_text(
        text.replace("paths:\n        - python", f"paths:\n        - {ROOT / 'python'}")
    )
    return path


class Warnings(logging.Handler):
    """MkDocs' warnings, each a problem."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(record.getMessage())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "build/site")
    out = parser.parse_args().out.resolve()
    tree = Tree(WORK)
    tree.write()
    write_references(WORK)
    for asset in SITE.iterdir():
        if asset.suffix in (".css", ".js"):
            shutil.copyfile(asset, WORK / asset.name)
    warnings = Warnings()
    logging.getLogger("mkdocs").addHandler(warnings)
    build(load_config(str(settings(out))))
    finish(out)
    broken = warnings.texts + problems(out)
    for problem in broken:
        print(problem, file=sys.stderr)
    print(f"{out / 'index.html'}: {len(list(out.rglob('*.html')))} pages, {len(broken)} problems")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
