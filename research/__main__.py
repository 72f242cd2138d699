"""Runs a measurement, lists all, or writes their index.

python -m research run NAME [--quick] [OPTIONS]   NAME's own options: run NAME --help
python -m research --list                         names, subjects and pages
python -m research all --list | [--resume]        every measurement that writes a page, with times
python -m research index                          writes the index of docs/results/README.md
python -m research paper --list | --all           every table and figure of the GzDRL paper
"""

from __future__ import annotations

import argparse
import difflib
import importlib
import sys
from collections.abc import Sequence

from research import registry


def listed() -> str:
    """One line per measurement: name, subject, page."""
    rows = registry.measurements()
    width = max(len(row.name) for row in rows)
    lines = []
    for row in rows:
        page = row.page if "/" in row.page else f"docs/results/{row.page}.md"
        lines.append(f"{row.name:{width}}  {row.subject}" + (f" [{page}]" if row.page else ""))
    return "\n".join(lines)


def run(name: str, options: Sequence[str]) -> None:
    """Runs a measurement as a program; does not return."""
    found = {row.name: row for row in registry.measurements()}
    if name not in found:
        close = difflib.get_close_matches(name, found, 1)
        also = f"; perhaps {close[0]}" if close else ""
        print(
            f"research: no measurement `{name}`{also}; --list prints all of them", file=sys.stderr
        )
        sys.exit(2)
    from skybody import InputError  # not needed by --list and index
    from skybody.program import run_program

    from research.common.programs import RunError

    def main() -> object:
        module = importlib.import_module(found[name].module)
        try:
            return module.main()
        except (RunError, InputError, *getattr(module, "ERRORS", ())) as error:
            print(f"{name}: {error}", file=sys.stderr)
            return 2

    sys.argv = [f"research run {name}", *options]
    run_program(main)


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="python -m research",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--list", action="store_true", help="names, subjects and pages")
    commands = parser.add_subparsers(dest="command", metavar="run | all | index | paper")
    one = commands.add_parser("run", add_help=False)
    one.add_argument("name")
    one.add_argument("options", nargs=argparse.REMAINDER)
    commands.add_parser("index", help="write the index of docs/results/README.md")
    commands.add_parser("all", add_help=False)
    commands.add_parser("paper", add_help=False)
    if sys.argv[1:2] == ["paper"]:  # its options are its own, `--list` among them
        from research.paper.command import main as list_paper

        sys.exit(list_paper(sys.argv[2:]))
    if sys.argv[1:2] == ["all"]:
        from research.everything.command import main as run_all

        sys.exit(run_all(sys.argv[2:]))
    options = parser.parse_args()
    if options.command == "run":
        run(options.name, options.options)
    elif options.command == "index":
        registry.INDEX.write_text(registry.page(), encoding="utf-8")
    elif options.list:
        print(listed())
    else:
        parser.error("run NAME, all, index, paper or --list")


if __name__ == "__main__":
    main()
