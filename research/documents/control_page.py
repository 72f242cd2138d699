"""Writes the tables of docs/control-modes.md and its figure from the plugins' declarations.

    python -m research run control_page [--check]

Runs `skybody modes --json` of build/release. --check writes nothing and exits with 1 if page or
figure is outdated.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
from typing import Any

from research.common.pages import between
from research.common.places import PROGRAM, ROOT
from research.documents.control_figure import figure

PAGE = "docs/control-modes.md"

TARGET = ROOT / "docs/control-modes.md"
FIGURE = ROOT / "docs/control-modes.svg"
SIGNALS_H = ROOT / "core/plugin_abi/signals.h"
BEGIN = "<!-- {name}: written by research/documents/control_page.py -->\n"
END = "<!-- end of {name} -->\n"


def declared() -> dict[str, Any]:
    """The declarations of the shipped plugins."""
    environment = {k: v for k, v in os.environ.items() if k != "SKYBODY_PLUGIN_PATH"}
    done = subprocess.run(
        [PROGRAM, "modes", "--json"], capture_output=True, text=True, check=True, env=environment
    )
    return json.loads(done.stdout)


def sizes() -> dict[str, str]:
    """Number of values of each signal, from the list in core/plugin_abi/signals.h."""
    text = SIGNALS_H.read_text(encoding="utf-8").replace("SKYBODY_REFERENCE_VALUES", "17")
    found = {}
    for word, least, most, doc in re.findall(
        r"X\(\w+, +\w+, +(\w+), +(\d+), +(\d+), \"([^\"]*)\"\)", text
    ):
        if least == "0":
            found[word] = "6 a site" if doc.startswith("6 per site") else "by the robot"
        elif most == "0":
            found[word] = f"{least} a point"
        else:
            found[word] = least if least == most else f"{least} or {most}"
    return found


def table(heading: list[str], rows: list[list[str]]) -> str:
    lines = [heading, ["---"] * len(heading), *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def signal_table(modes: dict[str, Any]) -> str:
    count = sizes()
    rows = [
        [f"`{name}`", count[name], signal["meaning"], "yes" * signal["acts"]]
        for signal in modes["signals"]
        if (name := signal["signal"]) != "none"
    ]
    return table(["Signal", "Size", "Values", "Acts"], rows)


def level(use: dict[str, Any], count: dict[str, str]) -> str:
    """A signal, with its size if the signal does not fix it."""
    has_choice = " or " in count.get(use["signal"], "")
    return f"`{use['signal']}`" + (f" ({use['size']})" if has_choice else "")


def controller_table(modes: dict[str, Any]) -> str:
    count = sizes()
    rows = []
    for mode in modes["controllers"]:
        name = mode["plugin"]
        takes = "any" if mode["passes_on"] else level(mode["takes"], count)
        gives = "the same" if mode["passes_on"] else level(mode["gives"], count)
        chosen = ", ".join(f"`{option}`" for option in mode["options"])
        rows.append(
            [f"[{name}](../controllers/{name}/README.md)", takes, gives, chosen, mode["doc"]]
        )
    for refused in modes["refused"]:
        name = refused["plugin"]
        rows.append([f"[{name}](../controllers/{name}/README.md)", "", "", "see there", ""])
    return table(["Controller", "takes", "gives", "chosen by", "in a line"], rows)


def page(modes: dict[str, Any]) -> str:
    """The current text of docs/control-modes.md."""
    text = TARGET.read_text(encoding="utf-8")
    for name, content in (
        ("signals", signal_table(modes)),
        ("controllers", controller_table(modes)),
    ):
        text = between(text, BEGIN.format(name=name), END.format(name=name), content)
    return text


def main() -> int:
    parser = argparse.ArgumentParser(description="write the control page from declared signals")
    parser.add_argument(
        "--check",
        action="store_true",
        help="write nothing; exit status 1 if page or figure is out of date",
    )
    options = parser.parse_args()
    modes = declared()
    made = {TARGET: page(modes), FIGURE: figure(modes)}
    if options.check:
        return int(any(not file.is_file() or file.read_text() != made[file] for file in made))
    for file, text in made.items():
        file.write_text(text, encoding="utf-8")
    return 0
