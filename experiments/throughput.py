"""Steps per second of an asynchronous pool from Python, by the GzDRL paper's protocol.

The reference's code counts receives, where the paper's text has environment steps: 1,000 for
warm-up and 10,000 measured ones. A receive returns N_B rows, each an environment step; a row that
begins an episode counts like the others, as in the reference. Each trial has a separate pool and
seed.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import skybody

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "bench"), str(ROOT / "scripts")]
import page_data as page_data  # noqa: E402
from baselines import interval as interval  # noqa: E402
from baselines import processor, processor_seconds  # noqa: E402
from baselines import processors as processors  # noqa: E402

BURST = 10  # receives between two readings of the clock
# Actions a of (a + 1) * 1150 rad/s: the reference's constant action, and the QDrone2's hover speed.
ACTIONS = {"zero": 0.0, "hold": 1391.0 / 1150.0 - 1.0}


@dataclass(frozen=True)
class Case:
    """Environments, batch and actions of a measurement."""

    scenario: str
    envs: int  # N_E
    batch: int  # N_B
    action: str  # of ACTIONS, the same for all environments and steps
    overrides: tuple[str, ...] = ()
    row: tuple[float, ...] = ()  # values of an environment's action, in place of `action`

    @property
    def threads(self) -> int:
        """N_T, as in the paper."""
        return min(self.envs, processors())


@dataclass(frozen=True)
class Length:
    """Length of a measurement: the longer of receives and seconds, limited by `most`."""

    trials: int
    warm_up: int  # [receives]
    receives: int
    seconds: float
    most: float = float("inf")  # of warm-up and measurement, each [s]


FULL = Length(trials=5, warm_up=1_000, receives=10_000, seconds=1.0)
QUICK = Length(trials=3, warm_up=100, receives=500, seconds=0.05, most=0.5)


@dataclass(frozen=True)
class Trial:
    """One measurement."""

    receives: int
    steps: int  # receives times N_B
    seconds: float
    cpu_use: float  # processor time over wall time and processors: 0 ... 1

    @property
    def rate(self) -> float:
        """[steps/s]"""
        return self.steps / self.seconds


@dataclass(frozen=True)
class Summary:
    """Mean of several trials."""

    rate: float  # [steps/s]
    interval: float  # half the width of the 95 % interval of Student's t [steps/s]
    cpu_use: float
    receives: float
    steps: float


def summary(trials: Sequence[Trial]) -> Summary:
    """Summary of two or more trials."""
    rates = [trial.rate for trial in trials]
    return Summary(
        rate=statistics.mean(rates),
        interval=interval(rates),
        cpu_use=statistics.mean(trial.cpu_use for trial in trials),
        receives=statistics.mean(trial.receives for trial in trials),
        steps=statistics.mean(trial.steps for trial in trials),
    )


def measure(case: Case, length: Length) -> list[Trial]:
    """All trials of one case."""
    compiled = skybody.CompiledScenario(case.scenario, overrides=list(case.overrides))
    return [_trial(compiled, case, length, seed) for seed in range(length.trials)]


def _trial(compiled: skybody.CompiledScenario, case: Case, length: Length, seed: int) -> Trial:
    with skybody.make_pool(
        compiled,
        case.envs,
        batch_size=case.batch,
        num_threads=case.threads,
        seed=seed,
        infos=False,
    ) as pool:
        pool.async_reset()
        receive = _receiver(pool, case)
        _receive_for(receive, length.warm_up, 0.0, length.most)
        computed = processor_seconds()
        receives, seconds = _receive_for(receive, length.receives, length.seconds, length.most)
        computed = processor_seconds() - computed
    return Trial(receives, receives * case.batch, seconds, computed / (seconds * processors()))


def _receiver(pool: skybody.Pool, case: Case) -> Callable[[], None]:
    """Receives a batch and sends those environments again."""
    shape = (case.batch, pool.compiled.action_size)
    rows = np.full(shape, case.row or ACTIONS[case.action], np.float32)
    recv, send = pool.recv, pool.send

    def receive_all() -> None:
        recv()
        send(rows)

    def receive_some() -> None:
        send(rows, recv()[4]["env_id"])

    return receive_all if case.batch == case.envs else receive_some


def _receive_for(
    receive: Callable[[], None], receives: int, seconds: float, most: float
) -> tuple[int, float]:
    """Receives so many and for so long, at most `most`; returns number and time [s]."""
    done, start = 0, time.perf_counter()
    while True:
        for _ in range(BURST):
            receive()
        done += BURST
        taken = time.perf_counter() - start
        if (done >= receives and taken >= seconds) or taken >= most:
            return done, taken


# --- shared output of both experiments ---------------------------------------------------------


def facts() -> dict[str, Any]:
    """Machine, date and versions of the measurement."""
    return {
        "machine": platform.node(),
        "processor": processor(),
        "processors": processors(),
        "date": datetime.date.today().isoformat(),
        "load": os.getloadavg(),
        "versions": skybody.versions() | {"python": platform.python_version()},
    }


def machine_line(found: dict[str, Any]) -> str:
    """facts() in words."""
    versions = found["versions"]
    asserts = " with asserts" if versions["simbody asserts"] == "on" else ""
    return (
        f"{found['machine']}, {found['processors']} cores of {found['processor']} "
        f"({versions['instruction set']}), {found['date']}; Skybody {versions['git']}, "
        f"Simbody {versions['simbody']}{asserts}, {versions['compiler']}, "
        f"Python {versions['python']}; load {found['load'][0]:.1f} when it began"
    )


def thousands(rate: float, half: float | None = None) -> str:
    """A rate in thousands per second, with its interval."""
    digits = 0 if rate >= 1e6 else 1
    text = f"{rate / 1e3:,.{digits}f}"
    return text if half is None else f"{text} ± {half / 1e3:,.{digits}f}"


def percent(share: float) -> str:
    """A share in 0 ... 1 in percent."""
    return f"{100.0 * share:.0f}"


def markdown_table(rows: Sequence[Sequence[str]]) -> str:
    """The first row is the head; the first column is text, the others are numbers."""
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    lines.insert(1, "| --- |" + " ---: |" * (len(rows[0]) - 1))
    return "\n".join(lines)


def plain_table(rows: Sequence[Sequence[str]]) -> str:
    """The same for a terminal."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join(
        "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]).rstrip()
        for row in rows
    )


def arguments(description: str) -> argparse.ArgumentParser:
    """--quick and --out, options of both experiments."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="fewer and shorter trials (seconds); writes nothing unless --out is given",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FOLDER",
        help="folder of page, data and images (default: docs/results)",
    )
    return parser


def output_folder(parser: argparse.ArgumentParser, options: argparse.Namespace) -> Path | None:
    """The output folder, with subfolders for data and images; None: no output."""
    folder: Path | None = options.out or (None if options.quick else ROOT / "docs/results")
    if folder is None:
        return None
    try:
        for name in ("data", "images"):
            (folder / name).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        parser.error(f"cannot write to {folder}: {error.strerror}")
    return folder


def write_report(folder: Path | None, name: str, text: str, content: dict[str, Any]) -> None:
    """Prints a page and, if there is a folder, writes it with its figures as JSON."""
    print(text)
    if folder is not None:
        page_data.write(folder / f"{name}.md", text)
        write_json(folder / f"data/{name}.json", content)


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Writes `content`, one line per value."""
    path.write_text(json.dumps(content, indent=1) + "\n")
