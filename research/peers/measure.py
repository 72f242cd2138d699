"""Shared code of all peers' scripts: command line, best-of trials and lines of JSON.

    python peer_NAME.py --seconds S --trials T [--quick]

A line is one measurement: a number of environments, of robots in each, of physics steps per
call, and of cores. Standard library only: a peer's virtual environment contains no code of ours.
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
    found.add_argument("--seconds", type=positive, default=0.2, help="duration of a trial [s]")
    found.add_argument(
        "--trials", type=int, default=5, help="number of trials; the best one counts"
    )
    found.add_argument("--quick", action="store_true", help="fewer sizes")
    return found


def effort(arguments: argparse.ArgumentParser, options: argparse.Namespace) -> Effort:
    if options.trials < 1:
        arguments.error("--trials must be at least 1")
    return Effort(options.seconds, options.trials, options.quick)


def parse(description: str | None) -> Effort:
    """Parses the command line of a script without own options."""
    arguments = parser(description)
    return effort(arguments, arguments.parse_args())


def positive(text: str) -> float:
    value = float(text)
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not a time above 0")
    return value


def use_cores(count: int) -> int:
    """Restricts this process, and all threads and processes started later, to that many
    cores; returns their number.
    """
    available = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, available[:count])
    return min(count, len(available))


def best_rate(call: Call, steps: int, effort: Effort) -> float:
    """Physics steps per second of the best trial; `call` takes `steps` of them.

    The first call may compile: it is not measured. The clock is read after as many calls as take
    about a hundredth of a trial, so that reading it costs nothing.
    """
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
    """The measured simulator; each row adds its own differences to `differs`."""

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
        """Measures `call`, which takes `substeps` physics steps in all `envs`; prints the row
        unless `check`, called afterwards, raises.
        """
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
        """Reports a size or a task that does not work here; the others continue."""
        reason = " ".join(str(why).split())[:300] or type(why).__name__
        print(json.dumps({"peer": self.name, "skipped": f"{what}: {reason}"}), flush=True)

    def attempt(self, what: str, measurement: Callable[[], None]) -> None:
        """Runs a measurement; a failure becomes a line of output."""
        try:
            measurement()
        except Exception as error:  # any error of a foreign library: the run continues
            print(f"{self.name}, {what}: {error!r}", file=sys.stderr)
            self.skipped(what, error)


def require(fine: bool, what: str) -> None:
    """Rejects a measurement whose vehicles did not behave as expected."""
    if not fine:
        raise RuntimeError(what)


def require_climb(speed: float, seconds: float) -> None:
    """Checks that vehicles with a tenth more thrust than at hover climb with a tenth of gravity.

    If commands did not reach the forces, any simulator would be fast.
    """
    expected = 0.1 * GRAVITY * seconds
    require(
        0.8 * expected < speed < 1.2 * expected,
        f"a tenth more thrust for {seconds:.3g} s made {speed:.3g} m/s upwards",
    )
