"""What every peer's script shares: its command line, best-of trials and its lines of JSON.

    python peer_NAME.py --seconds S --trials T [--quick]

A line is one measurement: so many environments, so many robots in each, so many physics steps a
call, on so many cores. Standard library only: a peer's virtual environment holds nothing of ours.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

SIZES = (1, 128, 1024, 8192, 65536)
QUICK_SIZES = (1, 1024, 8192)
GRAVITY = 9.81  # [m/s^2]
ROBOTS = (2, 5, 10, 20)
ROBOT_WORLDS = 32  # environments of the rows with many robots, as in the paper's Table IV
Call = Callable[[], object]


@dataclass(frozen=True)
class Effort:
    seconds: float  # [s] of a trial
    trials: int
    quick: bool

    def sizes(self, most: int = SIZES[-1]) -> tuple[int, ...]:
        """Numbers of environments to try, to find a peer's best."""
        return tuple(n for n in (QUICK_SIZES if self.quick else SIZES) if n <= most)


def parser(description: str | None) -> argparse.ArgumentParser:
    found = argparse.ArgumentParser(description=(description or "").split("\n")[0])
    found.add_argument("--seconds", type=positive, default=0.2, help="of a trial")
    found.add_argument("--trials", type=int, default=5, help="the best one counts")
    found.add_argument("--quick", action="store_true", help="fewer sizes")
    return found


def effort(arguments: argparse.ArgumentParser, options: argparse.Namespace) -> Effort:
    if options.trials < 1:
        arguments.error("--trials must be at least 1")
    return Effort(options.seconds, options.trials, options.quick)


def parse(description: str | None) -> Effort:
    """The command line of a script that has no options of its own."""
    arguments = parser(description)
    return effort(arguments, arguments.parse_args())


def positive(text: str) -> float:
    value = float(text)
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not a time above 0")
    return value


def use_cores(count: int) -> int:
    """Keeps this process, and the threads and processes that it starts from now on, on that many
    cores; gives how many those are."""
    available = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, available[:count])
    return min(count, len(available))


def best_rate(call: Call, steps: int, effort: Effort) -> float:
    """Physics steps a second of the best trial; `call` takes `steps` of them.

    The first call may compile: it is not measured. Between two looks at the clock lie as many
    calls as take about a hundredth of a trial, so that looking costs nothing."""
    call()
    bunch, taken = 1, 0.0
    while taken < 0.01 * effort.seconds:
        start = time.perf_counter()
        for _ in range(bunch):
            call()
        taken = time.perf_counter() - start
        bunch = bunch if taken >= 0.01 * effort.seconds else 2 * bunch
    best = 0.0
    for _ in range(effort.trials):
        calls, start = 0, time.perf_counter()
        while (taken := time.perf_counter() - start) < effort.seconds:
            for _ in range(bunch):
                call()
            calls += bunch
        best = max(best, calls * steps / taken)
    return best


@dataclass(frozen=True)
class Peer:
    """Who is measured; each row adds its own words to `differs` (what it does otherwise)."""

    name: str
    version: str
    engine: str
    differs: str

    def row(
        self,
        call: Call,
        effort: Effort,
        *,
        mode: str,
        cores: int,
        envs: int = 1,
        robots: int = 1,
        substeps: int = 1,
        task: str = "hover",
        differs: str = "",
        unit: str = "physics steps/s",
        check: Callable[[], None] | None = None,
    ) -> None:
        """Measures `call`, which takes `substeps` physics steps in all `envs`; prints it where
        `check`, called afterwards, does not throw."""
        rate = best_rate(call, envs * substeps, effort)
        if check:
            check()
        self.line(
            rate=rate,
            mode=mode,
            cores=cores,
            envs=envs,
            robots=robots,
            substeps=substeps,
            task=task,
            differs="; ".join(text for text in (self.differs, differs) if text),
            unit=unit,
        )

    def line(self, **facts: Any) -> None:
        head = {"peer": self.name, "version": self.version, "engine": self.engine}
        print(json.dumps(head | facts), flush=True)

    def skipped(self, what: str, why: object) -> None:
        """A size or a task that does not work here; the others go on."""
        reason = " ".join(str(why).split())[:300] or type(why).__name__
        print(json.dumps({"peer": self.name, "skipped": f"{what}: {reason}"}), flush=True)

    def attempt(self, what: str, measurement: Callable[[], None]) -> None:
        """Runs a measurement; a failure becomes a line that says so."""
        try:
            measurement()
        except Exception as error:  # whatever a foreign library throws: the run goes on
            print(f"{self.name}, {what}: {error!r}", file=sys.stderr)
            self.skipped(what, error)


def require(fine: bool, what: str) -> None:
    """A measurement whose vehicles did not do what they should is none."""
    if not fine:
        raise RuntimeError(what)


def require_climb(speed: float, seconds: float) -> None:
    """After so long on a tenth more thrust than hovers, vehicles climb at a tenth of gravity's
    speed. Commands that do not reach the forces would make any simulator quick."""
    expected = 0.1 * GRAVITY * seconds
    require(
        0.8 * expected < speed < 1.2 * expected,
        f"a tenth more thrust for {seconds:.3g} s made {speed:.3g} m/s upwards",
    )
