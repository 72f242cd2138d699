"""The engine's speed relative to a loop written by hand.

every rate and that of the limit, from one run on this machine.

    python -m research run goals [--full | --trial] [--json FILE] [--markdown FILE]

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
import tempfile
from collections.abc import Callable
from typing import Any

import numpy as np
import skybody

from research.common import page_data
from research.common.pages import head, markdown_table, plain_table, write_json
from research.common.places import PROGRAMS
from research.common.programs import output_of
from research.common.trials import rounds_a_second

PAGE = "goals"

HOLD = np.float32(2.0 * 1391.0 / 2300.0 - 1.0)  # hover speed of the QDrone2 as an action
Figure = dict[str, Any]


def best_rate(step: Callable[[], object], count: int, trials: int, seconds: float) -> float:
    """Environment steps per second of the best trial; `step` takes `count` of them."""
    return count * max(rounds_a_second(step, seconds) for _ in range(trials + 1))


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
    usual = {"actions": "hold", "threads": 2, "unit": "M steps/s", "sense": ">="}
    rates = dict(zip(("ours", "limit", "ratio"), numbers, strict=True))
    return {"what": what, **usual, **rates, "against": against, "goal": goal, **more}


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
    single, alone = (one, wanted, one / wanted), {"unit": "k steps/s", "threads": 1}
    return [
        figure(
            "Python, 1024 environments", (many, cpp_rate, many / cpp_rate), "the same in C++", 0.8
        ),
        figure("Python, 128 environments", (some, limit, some / limit), "limit of one core", 0.3),
        figure("Python, one environment", single, "300 k at a limit of 38 M", 1.0, **alone),
    ]


def simbody_figure(more: list[str]) -> Figure:
    """The whole environment step against the faster of two bare loops over Simbody."""
    program = PROGRAMS / "bench_simbody_path"
    printed = output_of([program, *more])
    times = [float(t) for t in re.findall(r"(\d+) ns a step", printed)]
    bare, whole = min(times[:2]), times[3]
    numbers, more_of = (whole, bare, whole / bare), {"unit": "ns", "sense": "<=", "threads": 1}
    return figure("Simbody path", numbers, "bare Simbody loop", 1.2, **more_of)


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


HEADINGS = head(
    "figure | actions | threads | ours | near contact [%] | other | unit | other is | ratio | goal"
    " |"
)


def markdown(facts: dict[str, Any]) -> str:
    lines = [
        "# Goals, measured",
        "",
        "Written by `./dev bench` (research/speed/goals.py); raw figures in data/goals.json.",
        f"{facts['machine']}, {facts['processors']} cores of {facts['processor']}, "
        f"{facts['date']}; "
        f"Simbody {facts['simbody']}{' with asserts' if facts['simbody_asserts'] else ''}; "
        f"load {facts['load'][0]:.1f} when it began. Rates are the best of many trials in turns"
        f"{'' if facts['full'] else ', here the short ones of `--quick`'}.",
        "",
        markdown_table([HEADINGS, *map(cells, facts["figures"])], range(len(HEADINGS))),
    ]
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
    print(plain_table([HEADINGS, *map(cells, facts["figures"])]))
    if options.json:
        write_json(pathlib.Path(options.json), facts)
    if options.markdown:
        page_data.write(pathlib.Path(options.markdown), markdown(facts))
