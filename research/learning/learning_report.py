"""Page and pictures of learning.py."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from research.common.machine import machine_line, versions_line
from research.common.pages import head, markdown_table
from research.common.plots import panels, save
from research.learning.learning_courses import Course

Row = dict[str, Any]
COLUMNS = 5  # of panels in a picture
SCALES = {"steps": (1e-6, "million steps"), "seconds": (1.0, "seconds")}
TABLE = (
    *("task", "learned means", "reached by seeds", "figures", "median error [m]", "steps"),
    *("seconds (allowed)", "parameter hashes"),
)
TEXTS = (0, 1, 3, 4, 6, 7)  # columns of it that are not numbers
SHORT, LONG = 8, 16  # hexadecimal digits of a hash; data/learning.json has all 64

TEXT = """\
# Learning

Scenarios of every task with their presets (`scenarios/TASK/training`), {seeds} seeds each, by

    {command}

Networks, optimizer and environments start from the seed alone, and one seed gives the same bits on
any number of threads ([training.md](../training.md)): a test trains the beginning of every run
again and compares hashes, and `research run learning --check` trains up to the first checkpoint.

{table}

Figures are of {episodes} drawn episodes of each seed's last checkpoint, flown by
`skybody run SCENARIO --policy RUN --episodes {episodes} --seed {seed}`, which neither training nor
its evaluations know; a figure a seed. A failed episode counts against every share. Laps may take
1.3 times as long as a line that `skybody plan` finds ([race_lines.md](race_lines.md)). The error is
the distance from the goal in the last second, its median over the episodes. Seconds are training's
own, from its first rollout to its last, without the evaluations; most runs shared the machine's
processors with others, and the table of runs has their threads.

{missed}
## Over steps and seconds

Lines: training's mean return of the last 100 episodes, a colour a seed, with the noise of its
actions. Dots: share of the evaluation's episodes that succeed at a checkpoint, from 0 at the bottom
to 1 at the top, under the deterministic policy.

![Return and successes over steps](images/learning_steps.png)

![Return and successes over seconds](images/learning_seconds.png)

## Runs

{runs}

"Successes" is the line of `skybody run`, by the task's own info `success` at the end of an episode.
A policy that is shipped is in `scenarios/TASK/policies`: `skybody run SCENARIO --policy shipped`.

Flown on {machine}. Versions of training: {versions}.
"""


def markdown(content: dict[str, Any], courses: Sequence[Course]) -> str:
    """The page."""
    rows = content["runs"]
    return TEXT.format(
        seeds=max((len(course.seeds) for course in courses), default=0),
        command=content["command"],
        table=table(rows, courses),
        episodes=content["flights"]["episodes"],
        seed=content["flights"]["seed"],
        missed=missed(rows, courses),
        runs=runs_table(rows),
        machine=machine_line(content["machine"]),
        versions=versions_line(rows),
    )


def of(rows: Sequence[Row], course: Course) -> list[Row]:
    """A course's rows."""
    return [row for row in rows if row["scenario"] == course.scenario]


def table(rows: Sequence[Row], courses: Sequence[Course]) -> str:
    """A course's rows."""
    rows_of = ((course, of(rows, course)) for course in courses)
    cells = [course_cells(course, found) for course, found in rows_of if found]
    return markdown_table([list(TABLE), *([row[name] for name in TABLE] for row in cells)], TEXTS)


def course_cells(course: Course, rows: Sequence[Row]) -> dict[str, str]:
    """A course's cells in tables, by the names of their columns."""
    reached = sum(row["learned"] for row in rows)
    seconds = ", ".join(f"{row['seconds']:.0f}" for row in rows)
    return {
        "task": f"`{course.scenario}`",
        "learned means": "; ".join(limit.text for limit in course.learned),
        "reached by seeds": f"{reached} of {len(rows)}",
        "figures": "; ".join(", ".join(row["figures"][k] for row in rows) for k in _limits(course)),
        "median error [m]": ", ".join(_error(row) for row in rows) if course.error else "",
        "steps": f"{rows[0]['total_steps'] / 1e6:g} M",
        "seconds (allowed)": f"{seconds} ({60 * course.minutes:.0f})",
        "parameter hashes": " ".join(f"`{row['parameter_hash'][:SHORT]}`" for row in rows),
    }


def _limits(course: Course) -> range:
    return range(len(course.learned))


def _error(row: Row) -> str:
    return "-" if row["median_error"] is None else f"{row['median_error']:.3f}"


def missed(rows: Sequence[Row], courses: Sequence[Course]) -> str:
    """Courses that miss a limit, took too long or were not run."""
    lines = []
    for course in courses:
        found = of(rows, course)
        if below := [row for row in found if not row["learned"]]:
            seeds = ", ".join(f"seed {row['seed']} ({'; '.join(row['figures'])})" for row in below)
            lines.append(f"- `{course.scenario}` falls short with {seeds}.")
        late = [row for row in found if row["seconds"] > 60.0 * course.minutes]
        if late:
            seeds = ", ".join(f"seed {row['seed']} ({row['seconds']:.0f} s)" for row in late)
            lines.append(f"- `{course.scenario}` took longer than allowed: {seeds}.")
        there = {row["seed"] for row in found}
        if absent := [str(seed) for seed in course.seeds if seed not in there]:
            lines.append(f"- `{course.scenario}`: not run with seed {', '.join(absent)}.")
    return f"## What falls short\n\n{chr(10).join(lines) or 'Nothing.'}\n"


def runs_table(rows: Sequence[Row]) -> str:
    """One line per run."""
    names = "scenario | seed | successes | failed | seconds | threads | trained | shipped"
    table = [head(f"{names} | parameter hash")]
    for row in rows:
        on = machine_line(row["machine"]) if row["machine"] else "a machine that is not recorded"
        flights = row["flights"].removeprefix("success: ").removesuffix(" episodes")
        numbers = [row["failed"], f"{row['seconds']:.0f}", row["threads"] or "all"]
        shipped = "yes" if row["is_shipped"] else ""
        digits = f"`{row['parameter_hash'][:LONG]}`"
        start = [row["scenario"], row["seed"], flights, *numbers]
        table.append([*start, f"{row['date']}, {on}", shipped, digits])
    return markdown_table(table, (0, 2, 6, 7, 8))


# --- pictures -----------------------------------------------------------------------------------


def draw(rows: Sequence[Row], over: str, out: Path) -> None:
    """One panel per scenario.

    Args:
        over: `steps` or `seconds`.
    """
    names = list(dict.fromkeys(row["scenario"] for row in rows))
    lines = max(1, math.ceil(len(names) / COLUMNS))
    figure, axes = panels(lines, COLUMNS, (3.0 * COLUMNS, 2.3 * lines))
    for axis, name in zip(axes.flat, names, strict=False):
        _panel(axis, [row for row in rows if row["scenario"] == name], over)
        axis.set_title(name, fontsize=9)
    for axis in axes.flat[len(names) :]:
        axis.axis("off")
    figure.legend(handles=_legend(rows), loc="outside upper center", ncols=5, fontsize=9)
    figure.supxlabel(SCALES[over][1], fontsize=9)
    figure.supylabel("mean return in training", fontsize=9)
    save(figure, out)


def _legend(rows: Sequence[Row]) -> list[Artist]:
    """The meaning of colours, lines and dots."""
    numbers = sorted({row["seed"] for row in rows})
    seeds = [Patch(color=_color(seed), label=f"seed {seed}") for seed in numbers]
    line = Line2D([], [], color="black", linewidth=1.0, label="mean return in training")
    label = "share of successes at a checkpoint, 0 (bottom) to 1 (top)"
    return [*seeds, line, Line2D([], [], color="black", marker=".", linestyle="", label=label)]


def _color(seed: int) -> str:
    return f"C{seed - 1}"


def _panel(axis: Axes, rows: Sequence[Row], over: str) -> None:
    scale, key = SCALES[over][0], "steps" if over == "steps" else "wall_clock"
    shares = axis.twinx()
    shares.set_ylim(-0.05, 1.05)
    shares.set_yticks([])
    for row in rows:
        color = _color(row["seed"])
        curve, points = row["curve"], row["checkpoints"]
        returns = [math.nan if y is None else y for y in curve["recent_return_mean"]]
        axis.plot([scale * x for x in curve[key]], returns, color=color, linewidth=1.0)
        where = [scale * point[key] for point in points]
        shares.plot(where, [p["reached_share"] for p in points], ".", color=color, markersize=4)
    axis.tick_params(labelsize=7)
