"""The table of goals: every rate and that of the limit, from one run on this machine.

    .venv/bin/python bench/goals.py [--full | --trial] [--json FILE] [--markdown FILE]

bench_goals measures the C++ rates, bench_simbody_path the engine's cost over Simbody, this
script the rates from Python. Each figure is the best of many short trials in which all
contestants take turns, because other programs may run on the machine. A missed goal does not
change the exit code 0.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import skybody
from skybody.program import run_program

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import page_data  # noqa: E402

PROGRAMS = ROOT / "build" / "release" / "bin"
HOLD = np.float32(2.0 * 1391.0 / 2300.0 - 1.0)  # hover speed of the QDrone2 as an action
Figure = dict[str, Any]


def best_rate(step: Callable[[], object], count: int, trials: int, seconds: float) -> float:
    """Environment steps per second of the best trial; `step` takes `count` of them."""
    best = 0.0
    for _ in range(trials + 1):
        rounds, start = 0, time.perf_counter()
        while (taken := time.perf_counter() - start) < seconds:
            for _ in range(10):
                step()
            rounds += 10
        best = max(best, rounds * count / taken)
    return best


def vec_rate(count: int, trials: int, seconds: float) -> float:
    envs = skybody.make_vec("hover", count, infos=False)
    try:
        envs.reset()
        actions = np.full((count, 4), HOLD, np.float32)
        return best_rate(lambda: envs.step(actions), count, trials, seconds)
    finally:
        envs.close()


def single_rate(trials: int, seconds: float) -> float:
    """One environment without a queue, all results of a step read."""
    world = skybody.Simulation("hover")
    world.reset()
    action = np.full(4, HOLD, np.float32)
    rows: list[object] = []  # the results that a learner would read

    def step() -> None:
        world.step(action)
        rows.append((world.observation, world.reward))
        rows.clear()
        if world.status:
            world.reset()

    return best_rate(step, 1, trials, seconds)


def figure(
    what: str, numbers: tuple[float, float, float], against: str, goal: float, **more: Any
) -> Figure:
    """numbers: ours, the compared rate, and their ratio as the goal defines it."""
    return {
        "what": what,
        "actions": more.get("actions", "hold"),
        "threads": more.get("threads", 2),
        "unit": more.get("unit", "M steps/s"),
        "ours": numbers[0],
        "limit": numbers[1],
        "against": against,
        "ratio": numbers[2],
        "sense": more.get("sense", ">="),
        "goal": goal,
    }


def python_figures(cpp: list[Figure], trials: int, seconds: float) -> list[Figure]:
    def of(threads: int) -> Figure:
        return next(
            f
            for f in cpp
            if f["what"] == "hover, K=1" and f["actions"] == "hold" and f["threads"] == threads
        )

    limit = of(1)["limit"]
    many, some = vec_rate(1024, trials, seconds) / 1e6, vec_rate(128, trials, seconds) / 1e6
    one = single_rate(trials, seconds) / 1e3
    wanted = 300.0 * limit / 38.0  # thousand steps/s
    cpp_rate = of(2)["ours"]
    return [
        figure(
            "Python, 1024 environments", (many, cpp_rate, many / cpp_rate), "the same in C++", 0.8
        ),
        figure("Python, 128 environments", (some, limit, some / limit), "limit of one core", 0.3),
        figure(
            "Python, one environment",
            (one, wanted, one / wanted),
            "300 k at a limit of 38 M",
            1.0,
            unit="k steps/s",
            threads=1,
        ),
    ]


def simbody_figure(more: list[str]) -> Figure:
    """The whole environment step against the faster of two bare loops over Simbody."""
    program = PROGRAMS / "bench_simbody_path"
    done = subprocess.run([program, *more], check=True, capture_output=True, text=True)
    times = [float(t) for t in re.findall(r"(\d+) ns a step", done.stdout)]
    bare, whole = min(times[:2]), times[3]
    return figure(
        "Simbody path",
        (whole, bare, whole / bare),
        "bare Simbody loop",
        1.2,
        unit="ns",
        sense="<=",
        threads=1,
    )


def cells(f: Figure) -> list[str]:
    limit = "" if f["limit"] is None else f"{f['limit']:.4g}"
    missed = f["ratio"] < f["goal"] if f["sense"] == ">=" else f["ratio"] > f["goal"]
    return [
        f["what"],
        f["actions"],
        str(f["threads"] or ""),
        f"{f['ours']:.4g}",
        "" if f.get("near_share") is None else f"{100.0 * f['near_share']:.3g}",
        limit,
        f["unit"],
        f["against"],
        f"{f['ratio']:.2f}",
        f"{f['sense']} {f['goal']:.3g}" if f["sense"] else "",
        "" if not f["sense"] else "missed" if missed else "met",
    ]


HEADINGS = ["figure", "actions", "threads", "ours", "near contact [%]", "other", "unit"]
HEADINGS += ["other is", "ratio", "goal", ""]  # met or missed


def table(figures: list[Figure]) -> str:
    rows = [HEADINGS, *(cells(f) for f in figures)]
    widths = [max(len(row[k]) for row in rows) for k in range(len(HEADINGS))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )


def markdown(facts: dict[str, Any]) -> str:
    lines = [
        "# Goals, measured",
        "",
        "Written by `./dev bench` (bench/goals.py); raw figures in data/goals.json.",
        f"{facts['machine']}, {facts['processors']} cores of {facts['processor']}, "
        f"{facts['date']}; "
        f"Simbody {facts['simbody']}{' with asserts' if facts['simbody_asserts'] else ''}; "
        f"load {facts['load'][0]:.1f} when it began. Rates are the best of many trials in turns"
        f"{'' if facts['full'] else ', here the short ones of `--quick`'}.",
        "",
        "| " + " | ".join(HEADINGS) + " |",
        "|" + " --- |" * len(HEADINGS),
    ]
    lines += ["| " + " | ".join(cells(f)) + " |" for f in facts["figures"]]
    return "\n".join(lines) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--full", action="store_true", help="longer trials, for published results")
    length.add_argument(
        "--trial", action="store_true", help="one short trial per figure, for tests"
    )
    parser.add_argument("--json", metavar="FILE", help="write the figures to this file")
    parser.add_argument("--markdown", metavar="FILE", help="write the table to this file")
    options = parser.parse_args()
    trials, seconds = (60, 0.1) if options.full else (1, 0.002) if options.trial else (40, 0.02)
    more = ["--full"] if options.full else ["--trial"] if options.trial else []

    load = os.getloadavg()
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "cpp.json"
        command = [str(PROGRAMS / "bench_goals"), "--out", str(out)]
        subprocess.run([*command, *more], check=True)
        facts = json.loads(out.read_text())
    facts["figures"] += python_figures(facts["figures"], trials, seconds)
    facts["figures"].append(simbody_figure(["--trial"] if options.trial else []))
    facts["load"] = load
    facts["date"] = datetime.date.today().isoformat()
    print(f"\n{facts['machine']} ({facts['processor']}), {facts['processors']} processors")
    print(table(facts["figures"]))
    if options.json:
        path = pathlib.Path(options.json)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(facts, indent=1) + "\n")
    if options.markdown:
        page_data.write(pathlib.Path(options.markdown), markdown(facts))


if __name__ == "__main__":
    run_program(main)
