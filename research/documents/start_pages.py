"""Runs all commands of docs/start, and makes the pictures of these pages.

    python -m research run start_pages [--pages NAME...] [--quick] [--out FOLDER]

Each page is one session of a shell in a folder of its own: its files (`<!-- file: NAME -->` before
a block), its commands (indented blocks), and its blocks of Python, in their order. --quick trains
and tunes little, builds without optimization, and makes no pictures.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path

from PIL import Image

from research.common.places import PROGRAMS, ROOT
from research.common.programs import RunError, output_of

__all__ = ["RunError", "main"]

PAGES = ROOT / "docs/start"
IMAGES = PAGES / "images"
WIDTH = 900  # of a picture [pixels]
WORDS = ("skybody", "cd", "cmake", "ctest", "export", "sed")  # that begin a command
BLOCK = re.compile(
    r"<!-- file: (?P<name>\S+) -->\n```\w+\n(?P<file>.*?)```|```python\n(?P<python>.*?)```"
    rf"|^    (?P<command>(?:{'|'.join(WORDS)}) [^\n]*)$",
    re.DOTALL | re.MULTILINE,
)
QUICK = {
    "run": " --no-picture",
    "train": " --total-steps 20000 --eval-episodes 1",
    "tune": " --candidates 20 --draws 2",
}
PICTURES = {  # by name of a picture: its source in the folder of the pages
    "first_flight": "first_flight/flights/first/flight-0001.png",
    "first_panel": "first_flight/flights/first/panels/flight-0001.png",
    "first_film": "first_flight/flights/first/film.png",
    "second_flight": "first_flight/flights/second/flight-0001.png",
    "curve": "first_policy/flights/learn/curve.png",
    "learned": "first_policy/flights/learned/flight-0001.png",
    "vehicle": "own_vehicle/my_quad/flights/default/flight-0001.png",
    "eight": "own_vehicle/my_quad/flights/eight/flight-0001.png",
    "vehicle_learned": "own_vehicle/my_quad/flights/learned/flight-0001.png",
    "task": "own_task/my_task/flights/first/flight-0001.png",
    "task_learned": "own_task/my_task/flights/learned/flight-0001.png",
    "law_fast": "own_controller/my_law/flights/fast/flight-0001.png",
    "law_slow": "own_controller/my_law/flights/slow/flight-0001.png",
}


def names() -> list[str]:
    """The pages with commands."""
    return [path.stem for path in sorted(PAGES.glob("*.md")) if path.stem != "README"]


def script(page: str, quick: bool) -> Iterator[str]:
    """The page as lines of a shell script."""
    yield "set -euo pipefail"
    for found in BLOCK.finditer(page):
        if found["name"]:
            yield f"cat >{found['name']} <<'END_OF_FILE'\n{found['file']}END_OF_FILE"
        elif found["python"]:
            yield f"'{sys.executable}' - <<'END_OF_FILE'\n{found['python']}END_OF_FILE"
        elif quick:
            yield quicker(found["command"])
        else:
            yield found["command"]


def quicker(command: str) -> str:
    """The command, with less to train or to tune."""
    words = command.split()
    if "--resume" in words or words[0] != "skybody":
        return command
    return command + QUICK.get(words[1], "")


def environment(quick: bool) -> dict[str, str]:
    """That of a reader after `./dev build`."""
    more = {"CMAKE_BUILD_TYPE": "None", "CXXFLAGS": "-O1"} if quick else {}
    path = os.pathsep.join([str(PROGRAMS), str(Path(sys.executable).parent), os.environ["PATH"]])
    python = {"PYTHONPATH": str(ROOT / "python"), "SKYBODY_PYTHON": sys.executable}
    return {**os.environ, "PATH": path, "SKYBODY": str(ROOT), **python, **more}


def run_page(name: str, folder: Path, quick: bool) -> str:
    """Runs a page's session in a new folder. Raises RunError if a command fails."""
    folder.mkdir(parents=True)
    text = "\n".join(script((PAGES / f"{name}.md").read_text(), quick)) + "\n"
    file = folder / "page.sh"
    file.write_text(text)
    return output_of(["bash", file], cwd=folder, env=environment(quick))


def write_pictures(folder: Path, pages: list[str]) -> None:
    """Converts the pictures that the pages have made."""
    IMAGES.mkdir(exist_ok=True)
    for name, source in PICTURES.items():
        if source.split("/")[0] not in pages:
            continue
        image = Image.open(folder / source).convert("RGB")
        height = round(image.height * WIDTH / image.width)
        image.resize((WIDTH, height), Image.Resampling.LANCZOS).save(
            IMAGES / f"{name}.webp", quality=80, method=6
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pages", nargs="+", default=names(), choices=names())
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--out", type=Path, default=ROOT / "build/start_pages", help="a new folder")
    options = parser.parse_args()
    for name in options.pages:
        print(run_page(name, options.out / name, options.quick), flush=True)
    if not options.quick:
        write_pictures(options.out, options.pages)
