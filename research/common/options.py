"""The options that all measurements have."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from research.common.machine import machine
from research.common.places import FLIGHTS, PROGRAM, RESULTS


class Options(argparse.ArgumentParser):
    """A parser whose help begins with the measurement's docstring, with --quick and --out.

    Args:
        name: of the measurement's module, and of the default folder of its runs below flights.
        trial: description of the reduced measurement.
        program: default of --program; None: no such option.
    """

    def __init__(
        self,
        doc: str | None,
        name: str,
        trial: str = "fewer and shorter trials",
        program: Path | None = None,
    ) -> None:
        name = name.rpartition(".")[2]
        super().__init__(
            prog=f"python -m research run {name}",
            description=doc,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        self.name = name
        where = "folder of page, data and images; default: docs/results, of a trial flights/"
        self.add("--quick", action="store_true", help=f"a trial: {trial}")
        self.add("--out", type=Path, metavar="FOLDER", help=f"{where}{name}_quick")
        if program is not None:
            self.add("--program", type=Path, default=program, help=f"default: {program}")

    def add(self, *names: str, **more: Any) -> Options:
        """add_argument(), in a chain."""
        self.add_argument(*names, **more)
        return self

    def of_runs(self) -> Options:
        """Adds --runs: where finished runs are kept and found again."""
        where = f"folder of the runs; default: flights/{self.name}, of a trial --out"
        return self.add("--runs", type=Path, metavar="FOLDER", help=where)

    def of_training(self, seeds: int | list[int], jobs: int = 2) -> Options:
        """Adds --seeds (their number, or a list), --jobs and --threads of training runs."""
        more: dict[str, Any] = {"nargs": "+"} if isinstance(seeds, list) else {}
        self.add("--seeds", type=int, default=seeds, help=f"seeds; default: {seeds}", **more)
        self.add("--jobs", type=int, default=jobs, help=f"parallel runs; default: {jobs}")
        threads = "threads of a run; 0: one per processor; changes no bits"
        return self.add("--threads", type=int, default=0, help=threads)

    def given(self, arguments: Sequence[str] | None = None) -> argparse.Namespace:
        """The values: folders are set and made, `command` repeats the measurement."""
        options = self.parse_args(arguments)
        words = sys.argv[1:] if arguments is None else arguments
        options.command = " ".join(["python -m research run", self.name, *words])
        quick = FLIGHTS / f"{self.name}_quick"
        options.out = options.out or (quick if options.quick else RESULTS)
        if "runs" in options:
            runs = options.out if options.quick else FLIGHTS / self.name
            options.runs = options.runs or runs
        if getattr(options, "jobs", 1) < 1:
            self.error(f"--jobs {options.jobs}: at least 1")
        program = getattr(options, "program", PROGRAM)
        if not program.exists():
            self.error(f"the program {program} does not exist; ./dev build makes it")
        try:
            for name in ("data", "images"):
                (options.out / name).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            self.error(f"cannot write to {options.out}: {error.strerror}")
        return options


def heading(experiment: str, options: argparse.Namespace) -> dict[str, Any]:
    """Head of the data: the experiment, its command, and the machine."""
    return {"experiment": experiment, "command": options.command, "machine": machine()}
