"""How many physics steps pass between an observation and its action, in process and by middleware.

    python -m research run synchronization [--trials 100] [--quick]

The paper's figures 4 and 5, made anew: trials of 200 wrenches at 100 Hz, 10 physics steps of 1 ms
each, from the same state, as a list (open loop) and by a law of position (closed loop). In process;
and between two processes over ROS 2 (Fast DDS; Cyclone DDS at the policy's end), Gazebo Transport
and ROS 1: free-running (the simulator by the clock on the wall, odometry after each physics step)
and in lockstep (each wrench makes 10 steps). Middleware that is not installed is left out: `./dev
ros` installs it. Writes synchronization.md, its JSON and pictures. Fails if a step in process or in
lockstep has physics steps between, or other bits than in process.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import markdown_table, write_json, write_page
from research.speed.paper_tables import OTHERS
from research.sync.figures import draw_spread, draw_timing
from research.sync.summary import QUANTILES, label, rows_of, summary
from research.sync.two_processes import (
    MIDDLEWARES,
    Middleware,
    flown,
    flown_in_process,
    newest_rate,
)
from research.sync.work import LOOPS

PAGE = "synchronization"
COUNTED = 2.0  # of steps that do not wait [s]


def measured(trials: int, ways: Sequence[Middleware], runs: Path) -> list[dict[str, Any]]:
    """Figures of these ways, both loops; finished ones are kept in `runs`, and found again."""
    rows = []
    for loop in LOOPS:
        alone = flown_in_process(loop, trials)
        reference = alone.position[0]
        rows.append(summary("one process", "in process", loop, alone, reference))
        for way in ways:
            for stepping in ("lockstep", "free-running"):
                kept = runs / f"{way.agent}_{stepping}_{loop}_{trials}.json"
                if not kept.exists():
                    print(f"{way.title}, {loop} loop, {stepping}", flush=True)
                    found = flown(way, loop, trials, stepping == "free-running")
                    row = summary(way.title, stepping, loop, found, reference)
                    write_json(kept, row | {"load": os.getloadavg()[0]})
                rows.append(json.loads(kept.read_text()))
    return rows


def cell(row: dict[str, Any], key: str) -> str:
    """Median, 99 % and greatest of a quantity."""
    values = [row[key][QUANTILES.index(q)] for q in (50.0, 99.0, 100.0)]
    return " / ".join(f"{value:.3g}" for value in values)


def pace(row: dict[str, Any]) -> str:
    """Simulated time over time on the wall, where there is a clock."""
    return f"{row['pace']:.3f}" if row["stepping"] == "free-running" else ""


def timing_table(rows: list[dict[str, Any]]) -> str:
    """Figure 4 in numbers."""
    table = [["", "latency [ms]", "delay [ms]", "steps between", "their mean", "lost", "pace"]]
    for row in rows:
        words = (cell(row, key) for key in ("latency_ms", "delay_ms", "intervening"))
        mean, lost = f"{row['intervening_mean']:g}", str(row["lost"])
        table.append([label(row), *words, mean, lost, pace(row)])
    return markdown_table(table)


def spread_table(rows: list[dict[str, Any]]) -> str:
    """Figure 5 in numbers."""
    table = [["", "open: spread at the end", "RMSE", "closed: greatest spread", "RMSE", "pace"]]
    for opened, closed in zip(rows_of(rows, "open"), rows_of(rows, "closed"), strict=True):
        table.append(
            [
                label(opened),
                f"{opened['spread_mm'][-1]:.3g}",
                cell(opened, "error_mm"),
                f"{max(closed['spread_mm']):.3g}",
                cell(closed, "error_mm"),
                pace(closed),
            ]
        )
    return markdown_table(table)


def rate_table(rows: list[dict[str, Any]], newest: dict[str, Any]) -> str:
    """Rates of steps, counted in both ways."""
    table = [["steps/s", "counted as calls", "of these with new odometry", "as transitions"]]
    for row in rows_of(rows, "open"):
        if row["stepping"] == "in process":
            table.append([row["way"], f"{row['rate']:,.0f}", f"{row['rate']:,.0f}"])
        elif row["stepping"] == "lockstep":
            found = newest[row["way"]]
            calls, other = (found[key] / found["seconds"] for key in ("calls", "other"))
            table.append([row["way"], f"{calls:,.0f}", f"{other:,.0f}"])
        else:
            continue
        table[-1].append(f"{row['rate']:,.0f}")
    return markdown_table(table)


def paper_rows() -> str:
    """The paper's rows of ROS."""
    rows = [row for row in OTHERS if row.name.startswith("ROS")]
    return "; ".join(
        f"{row.name} {row.workstation.rate:g} and {row.laptop.rate:g} with "
        f"{row.workstation.envs} and {row.laptop.envs}"
        for row in rows
    )


def loads(rows: list[dict[str, Any]]) -> str:
    """How busy the machine was; empty without middleware."""
    found = [row["load"] for row in rows if "load" in row]
    if not found:
        return ""
    return (
        f"The machine's load when the trials of a way ended: {min(found):.1f} to {max(found):.1f}, "
        "about 1 of it from the trials; times and free-running flights are of a busy machine if "
        "it is above that of the processors.\n"
    )


def page(found: dict[str, Any]) -> str:
    """The page."""
    rows, left_out = found["rows"], found["left_out"]
    missing = [f"Left out: {', '.join(left_out)}.\n"] if left_out else []
    return "\n".join(
        [
            "# Synchronization of actions and physics\n",
            f"The paper's figures 4 and 5, made anew: {found['trials']} trials of 200 wrenches at "
            "100 Hz, 10 physics steps of 1 ms each, a QDrone2 from the same state. Open loop: a "
            "list of wrenches; closed loop: a law of position and attitude flies 1 m aside and "
            "up.\n",
            "In lockstep a wrench makes 10 physics steps and its odometry comes back. Free-running "
            "the simulator makes a physics step each millisecond on the wall, with an odometry "
            "message, and the policy sends a wrench every 10 ms on its newest odometry. Simulator "
            "(`skybody ros2`, `skybody ros1`, the same node on Gazebo Transport) and policy are "
            "Python processes on the loopback interface.\n",
            *missing,
            "In process and in lockstep each action of each trial had 0 physics steps between, and "
            "each flight the bits of the first one in process.\n",
            "## Figure 4\n",
            "![latency, delay and steps between](images/synchronization_timing.png)\n",
            "Boxes are quartiles, whiskers 1 % and 99 %, points extremes. In numbers (median / "
            "99 % / greatest, open loop):\n",
            timing_table(rows_of(rows, "open")) + "\n",
            "*Latency*: from sending an action to the start of its first physics step. *Delay*: "
            "from the end of a physics step to its odometry at the policy. *Steps between*: "
            "physics steps between an action's odometry and its first own step. *Lost*: actions "
            "that the next one replaced before a physics step. *Pace*: simulated time over time on "
            "the wall.\n",
            "## Figure 5\n",
            "![spread and errors](images/synchronization_spread.png)\n",
            "Where each action begins, [mm]: *spread* is the root mean square distance from the "
            "mean of all trials, *RMSE* (median / 99 % / greatest) that of a trial from the flight "
            "in process.\n",
            spread_table(rows) + "\n",
            "## The paper's Table III, counted in two ways\n",
            "The reference's ROS environments send an action and return the newest odometry that "
            "is there, without waiting: *calls*, here against the free-running simulator. A "
            "*transition* waits for the odometry that belongs to its action (10 physics steps), in "
            "lockstep. One environment, 10 physics steps an action.\n",
            rate_table(rows, found["newest"]) + "\n",
            "The paper's rows, in thousands of steps/s on its two computers, with their numbers "
            f"of environments: {paper_rows()}.\n",
            loads(rows),
            machine_line(found) + "\n",
        ]
    )


def main() -> int:
    """Measures, draws, writes; returns the exit code."""
    names = [way.agent for way in MIDDLEWARES]
    options = (
        Options(__doc__, __name__, "2 trials")
        .add("--trials", type=int, default=100, help="of each way and loop; default: 100")
        .add("--only", nargs="*", choices=names, default=names,
             help="some of the middleware, or none; default: all that is installed")
        .of_runs()
        .given()
    )  # fmt: skip
    ways = [way for way in MIDDLEWARES if way.agent in options.only and way.is_there]
    trials = 2 if options.quick else options.trials
    content: dict[str, Any] = facts() | {
        "trials": trials,
        "left_out": [way.title for way in MIDDLEWARES if way not in ways],
        "newest": {way.title: newest_rate(way, COUNTED) for way in ways},
        "rows": measured(trials, ways, options.runs),
    }
    images = options.out / "images"
    draw_timing(images / f"{PAGE}_timing.png", rows_of(content["rows"], "open"))
    draw_spread(images / f"{PAGE}_spread.png", content["rows"])
    write_page(options.out, PAGE, page(content), content)
    return 0
