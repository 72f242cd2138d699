"""Whether threads, batches and orders change a trajectory.

    python -m research run determinism_matrix [--envs N] [--steps K] [--write]

The ways:

* 1, 2 and 4 threads;
* batches of all environments, of a third and of one;
* order `fixed` and `arrival`;
* by the program (`skybody hash`) and from Python;
* without interruption, and saved in the middle and restored, also into a pool of another shape;
* with an environment that faults repeatedly;
* on the machine as it is, and with a computing process on every processor.

`hover` is also flown on the ground, `cooperative_payload_ropes` also on slack ropes. Prints one
line per scenario, with the trajectory hash; exit status 0: all are identical, 1: some differ, 2: a
process failed.

All of it takes hours. `--scenarios` flies some. `--write` merges each result into the page as soon
as it is available, and removes lines that no longer have the pinned hash.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import json
import os
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import skybody
from skybody.program import ignoring_interrupts

from research.common import page_data
from research.common.machine import machine, machine_line
from research.common.options import Options
from research.common.pages import write_json
from research.common.places import PROGRAM, RESULTS, ROOT, command_of
from research.common.programs import output_of

sys.path.insert(0, str(ROOT / "tests/golden"))
import golden
from golden import ENVS, LEAST_STEPS, SEED, STEPS, Flight, FlightError

PAGE = "determinism_matrix"

ERRORS = (FlightError,)
LINES = RESULTS / f"data/{PAGE}.json"
FLIGHTS = {flight.name: flight for flight in golden.FLIGHTS}
QUICK_SCENARIOS = ("hover", "payload")
TIMEOUT = 600.0  # s, for one process on a loaded machine
PYTHON_FLIGHTS = (
    "Python",
    "Python, restored",
    "Python, restored into another pool",
    "Python, beside an environment that faults",
)
BURN = "import os\nparent = os.getppid()\nwhile os.getppid() == parent: sum(range(1_000_000))"


@dataclass(frozen=True)
class Shape:
    """Batching and threads of the environments."""

    threads: int
    batch: int
    order: str

    def options(self) -> list[str]:
        """Options for both `skybody hash` and hash_run.py."""
        return [f"--threads={self.threads}", f"--batch={self.batch}", f"--order={self.order}"]

    def __str__(self) -> str:
        return f"{self.threads} threads, batches of {self.batch}, {self.order}"


@dataclass(frozen=True)
class Result:
    """Hashes of the flights of one scenario."""

    flight: Flight
    pinned: str  # "" if the flight is not the pinned one
    hashes: dict[str, str]  # by way of flying

    @property
    def hash(self) -> str:
        """The pinned hash (tests/golden), otherwise the most frequent one."""
        return self.pinned or Counter(self.hashes.values()).most_common(1)[0][0]

    @property
    def differing(self) -> list[str]:
        """Ways with a different hash."""
        return [f"{way}: {value}" for way, value in self.hashes.items() if value != self.hash]

    @property
    def verdict(self) -> str:
        return f"{len(self.differing)} differ" if self.differing else "identical"


def make_shapes(envs: int, quick: bool) -> list[Shape]:
    """All shapes; the first is the simplest."""
    third = max(1, envs // 3)
    if quick:
        return [Shape(1, envs, "fixed"), Shape(4, third, "arrival"), Shape(2, 1, "fixed")]
    return [
        Shape(threads, batch, order)
        for threads in (1, 2, 4)
        for batch in dict.fromkeys((envs, third, 1))
        for order in ("fixed", "arrival")
    ]


# --- processes ----------------------------------------------------------------------------------


@contextlib.contextmanager
def load() -> Iterator[None]:
    """Keeps all processors of this process busy; the load processes end with their parent."""
    burners: list[subprocess.Popen[bytes]] = []
    try:
        for processor in sorted(os.sched_getaffinity(0)):
            with ignoring_interrupts():
                burner = subprocess.Popen([sys.executable, "-S", "-c", BURN])
            burners.append(burner)
            os.sched_setaffinity(burner.pid, {processor})
        time.sleep(0.1)  # until they compute
        yield
    finally:
        for burner in burners:
            burner.kill()
            burner.wait()


def fly(program: Path, flight: Flight, envs: int, shape: Shape) -> dict[str, str]:
    """Hashes by way of flying, from two processes."""
    options = [*flight.options(envs), *shape.options()]
    (by_program,) = output_of([program, "hash", *options], TIMEOUT).split()
    python = [*command_of("hash_run"), *options]
    by_python = output_of(python, TIMEOUT).split()
    return {"skybody hash": by_program, **dict(zip(PYTHON_FLIGHTS, by_python, strict=True))}


def fly_all(options: argparse.Namespace, flight: Flight, shapes: list[Shape]) -> Result:
    """Flies one flight in all ways."""
    hashes: dict[str, str] = {}
    for condition, busy in (("", contextlib.nullcontext()), (", under load", load())):
        with busy:
            for shape in shapes:
                flown = fly(options.program, flight, options.envs, shape)
                for way, value in flown.items():
                    hashes[f"{way}, {shape}{condition}"] = value
    as_pinned = options.envs == ENVS and flight == FLIGHTS[flight.name]
    return Result(flight, golden.shipped_hash(flight) if as_pinned else "", hashes)


# --- report -------------------------------------------------------------------------------------


def line(result: Result) -> str:
    """One line, and one more for each way that differs."""
    head = (
        f"{result.flight.name:<18} {result.hash}  {len(result.hashes):>4} runs of "
        f"{result.flight.steps:>3} "
        f"steps  {result.verdict}"
    )
    return "\n".join([head, *(f"  differs: {way}" for way in result.differing)])


HEAD = """\
# The determinism matrix

The shipped scenarios of the table, and `every_sensor` with all sensors at once
(`tests/golden/every_sensor.yaml`), flown in {runs} ways, or in a part of them: the trajectory hash
that `tests/golden` pins, and whether all of them gave it.

    .venv/bin/python -m research run determinism_matrix --write [--quick] [--scenarios NAME ...]

on {machine}; Skybody {version}. A run is {envs} environments under seed {seed}, each with a
reset, the number of steps below and the actions of `skybody hash`. The horizon is a quarter of the
steps, so that every environment is reset at least three times on the way. `hover_on_ground` is
`hover` begun 2 to 6 cm above the ground, which the vehicle touches. Taut ropes move as rods do: in
episodes as short as these `cooperative_payload_ropes` has the hash of `cooperative_payload`;
`cooperative_payload_slack` is the same world with ropes that are slack at the start. The machine is
that of the lines that were flown last. The ways are

- {shapes} shapes: {threads} threads x batches of {batches} x order {orders}; where a line has
  {quick_runs} runs, {quick_shapes};
- by `skybody hash`; from Python; from Python, saved in the middle, disturbed and restored; restored
  there into a pool of one thread that waits for all; and beside an environment whose actions are
  not finite every few steps (the others' hashes are compared);
- each of these on the machine as it was, and with one more process computing on every processor.

The program has a process for each run, Python one for each shape. Hashes chain state words,
observation, privileged row, images, reward and status after every step. Across what builds and
processors they are the same, and where that is not promised, is in
[determinism.md](../determinism.md).

| scenario | robots | steps | hash | runs | |
| --- | --- | --- | --- | --- | --- |
"""


def markdown(lines: dict[str, dict[str, Any]]) -> str:
    """The report."""

    def words(values: Iterator[object]) -> str:
        return ", ".join(str(value) for value in dict.fromkeys(values))

    shapes, quick = make_shapes(ENVS, False), make_shapes(ENVS, True)
    ways = 2 * (1 + len(PYTHON_FLIGHTS))  # per shape
    head = HEAD.format(
        runs=ways * len(shapes),
        machine=machine_line(machine()),
        version=skybody.__version__,
        envs=ENVS,
        seed=SEED,
        shapes=len(shapes),
        threads=words(shape.threads for shape in shapes),
        batches=words(shape.batch for shape in shapes),
        orders=words(shape.order for shape in shapes),
        quick_runs=ways * len(quick),
        quick_shapes="; ".join(map(str, quick)),
    )
    rows = [
        f"| `{name}` | {line['robots']} | {line['steps']} | `{line['hash']}` | {line['runs']} "
        f"| {line['verdict']} |"
        for name, line in lines.items()
    ]
    differing = [f"- `{name}`, {way}" for name in lines for way in lines[name]["differing"]]
    return "\n".join(
        [head + "\n".join(rows), *(["", "Differ:", "", *differing] if differing else []), ""]
    )


def keep(result: Result, is_part: bool) -> None:
    """Merges a line into the earlier results, and writes the report again.

    Args:
        is_part: only some flights are flown now.
    """
    flight = result.flight
    known = json.loads(LINES.read_text()) if LINES.is_file() else {}
    known[flight.name] = {
        "robots": flight.robots,
        "steps": flight.steps,
        "hash": result.hash,
        "runs": len(result.hashes),
        "verdict": result.verdict,
        "differing": result.differing,
    }
    lines = {
        name: known[name]
        for name, pinned in FLIGHTS.items()
        if name in known and known[name]["hash"] == golden.shipped_hash(pinned)
    }
    write_json(LINES, lines)
    page_data.write(RESULTS / f"{PAGE}.md", markdown(lines), keeps=is_part)


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line's values, checked."""
    few = "--steps: per environment, divided by the number of robots, those of tests/golden at most"
    parser = (
        Options(__doc__, __name__, "three shapes, two scenarios", PROGRAM)
        .add("--scenarios", nargs="+", metavar="NAME", help="default: all of tests/golden")
        .add("--envs", type=int, default=ENVS, help=f"at least 3; default: {ENVS}")
        .add("--steps", type=int, default=STEPS, help=few)
        .add("--write", action="store_true", help=f"merge the lines into docs/results/{PAGE}.md")
    )
    options = parser.parse_args(arguments)
    options.scenarios = options.scenarios or (QUICK_SCENARIOS if options.quick else tuple(FLIGHTS))
    unknown = sorted(set(options.scenarios) - set(FLIGHTS))
    if unknown:
        parser.error(f"--scenarios {unknown[0]}: there are {', '.join(FLIGHTS)}")
    if options.write and (options.envs, options.steps) != (ENVS, STEPS):
        parser.error("--write: without --envs and --steps, which the report does not vary")
    if options.envs < 3:
        parser.error(f"--envs {options.envs}: at least 3")
    if options.steps < LEAST_STEPS:
        parser.error(f"--steps {options.steps}: at least {LEAST_STEPS}")
    return options


def main(arguments: list[str] | None = None) -> int:
    """Flies, compares, prints; returns the exit status."""
    options = parse(arguments)
    shapes = make_shapes(options.envs, options.quick)
    differs = False
    for name in options.scenarios:
        pinned = FLIGHTS[name]
        flight = dataclasses.replace(pinned, most_steps=min(options.steps, pinned.most_steps))
        result = fly_all(options, flight, shapes)
        differs |= bool(result.differing)
        print(line(result), flush=True)
        if options.write:
            keep(result, is_part=set(options.scenarios) != set(FLIGHTS))
    return 1 if differs else 0
