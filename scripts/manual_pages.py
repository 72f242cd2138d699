"""Manual pages of the program, from its --help: skybody.1, and one of each command in C++.

    python3 scripts/manual_pages.py --program build/release/bin/skybody --out build/man

Commands in Python are in skybody.1 alone: their help needs the packages that they use.
"""

from __future__ import annotations

import argparse
import datetime
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

HEADING = re.compile(r"^(\S.*):$")
ENTRY = re.compile(r"^ {1,4}(\S.*?)(?: {2,}(\S.*))?$")  # an option or a command, and its text
MORE = re.compile(r"^ {5,}(\S.*)$")  # the rest of such a text
HEADINGS = {"OPTIONS": "OPTIONS", "SUBCOMMANDS": "COMMANDS", "POSITIONALS": "ARGUMENTS"}


def help_of(program: Path, command: tuple[str, ...]) -> str | None:
    """The text of --help; None for a command in Python."""
    environment = {**os.environ, "SKYBODY_PYTHON": "/bin/false", "COLUMNS": "80"}
    words = [str(program), *command, "--help"]
    done = subprocess.run(words, capture_output=True, text=True, env=environment)
    return done.stdout if done.returncode == 0 else None


def escaped(text: str) -> str:
    """Text as troff reads it."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def command_names(text: str) -> list[str]:
    """The commands that a help lists."""
    listed = re.search(r"^subcommands:\n((?: .*\n|\n(?= ))*)", text, re.M | re.I)
    entries = (ENTRY.match(line) for line in (listed[1] if listed else "").splitlines())
    return [entry[1].split()[0] for entry in entries if entry and re.match(r"[a-z]", entry[1])]


def body(text: str) -> Iterator[str]:
    """The lines of a help after the summary and the usage, as troff."""
    verbatim = True
    for line in text.splitlines():
        if heading := HEADING.match(line):
            name = heading[1].upper()
            verbatim = name not in HEADINGS and not name.endswith("OPTIONS")
            yield f".SH {HEADINGS.get(name, name)}"
        elif verbatim and line:
            yield from (".br", escaped(line.strip()))
        elif more := MORE.match(line):
            yield escaped(more[1])
        elif entry := ENTRY.match(line):
            yield from (".TP", f"\\fB{escaped(entry[1])}\\fR")
            if entry[2]:
                yield escaped(entry[2])
        elif line:
            yield from (".PP", escaped(line))


def page(command: tuple[str, ...], text: str, version: str, date: str) -> str:
    """A manual page."""
    name = "-".join(("skybody", *command))
    usage = re.search(r"^usage: *(.*)$", text, re.M | re.I)
    rest = text.replace(usage[0], "", 1) if usage else text
    summary = next((line for line in rest.splitlines() if line), "")
    words = " ".join(("skybody", *command))
    rest = rest.replace(summary, "", 1)
    short = summary.removeprefix("Skybody, ").rstrip(".")
    synopsis = usage[1] if usage and usage[1] else f"{words} [OPTIONS]"
    lines = [f'.TH {name.upper()} 1 "{date}" "Skybody {version}" "User Commands"']
    lines += [".SH NAME", f"{escaped(name)} \\- {escaped(short)}"]
    lines += [".SH SYNOPSIS", f"\\fB{escaped(synopsis)}\\fR", ".SH DESCRIPTION", escaped(summary)]
    lines += body(rest)
    lines += [".SH SEE ALSO"]
    if command:
        lines += [".BR skybody (1)"]
    else:
        lines += ["\\fBskybody COMMAND \\-\\-help\\fR has the options of a command."]
    return "\n".join(lines) + "\n"


def pages(program: Path, version: str, date: str) -> dict[str, str]:
    """All pages, by file name."""
    text = help_of(program, ())
    if text is None:
        sys.exit(f"error: {program} --help fails")
    found = {"skybody.1": page((), text, version, date)}
    for name in command_names(text):
        own = help_of(program, (name,))
        if own is not None:
            found[f"skybody-{name}.1"] = page((name,), own, version, date)
    return found


def main() -> int:
    """Writes the pages; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=Path("build/release/bin/skybody"))
    parser.add_argument("--out", type=Path, default=Path("build/man"))
    options = parser.parse_args()
    version = subprocess.run([options.program, "--version"], capture_output=True, text=True).stdout
    time = int(os.environ.get("SOURCE_DATE_EPOCH", options.program.stat().st_mtime))
    date = datetime.datetime.fromtimestamp(time, datetime.UTC).date().isoformat()
    options.out.mkdir(parents=True, exist_ok=True)
    for name, text in pages(options.program, version.split()[1], date).items():
        (options.out / name).write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
