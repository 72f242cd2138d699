"""The page and the picture of paper_protocol.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from training_runs import machine_line

PAPER_MINUTES = 220.0  # six runs of a task at once: two sets of three seeds


def learned_section(rows: list[dict[str, Any]]) -> str:
    """Table and picture of runs with their curves; empty without one."""
    if not rows:
        return ""
    lines = [
        "| task | learner | seed | transitions | return of training, first and last "
        "| error of training, first and last [m] | held-out flights succeeded | failed "
        "| their median error in the last second [m] |",
        "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for row in rows:
        course, flown = row["curve"], row.get("flown")
        ends = [
            ", ".join(known_or_dash(course[name][k]) for k in (0, -1))
            for name in ("return", "error")
        ]
        cells = [f"`{row['task']}`", row["learner"], str(row["seed"])]
        cells += [f"{row['transitions']:,}", *ends]
        cells += ["-"] * 3 if flown is None else flown_cells(flown)
        lines.append(f"| {' | '.join(cells)} |")
    return f"""
## What is learned

One seed of each form, by

{chr(10).join(dict.fromkeys(f"    {row['command']}" for row in rows))}

![Return and error over transitions](images/paper_protocol.png)

{chr(10).join(lines)}

Runs of fewer than 5,000,000 transitions were cut there: what they had not learned by then, they may
learn later. First and last: means over an eightieth of the run. Return and error are those of
training, with its noise, and the error is a mean over whole episodes. Success is what the head of
the scenario's file says, in episodes of a seed that training does not know, by the last policy
without noise.

Beside the paper's curves (its figure 10, payload on the left and trajectory on the right): there
all four learn within the 5,000,000 transitions, and on the trajectory modular control is ahead
early on. Its returns are not comparable: the scenarios here end an episode where the paper's code
does, and mend what its code got wrong (their heads say what). The paper's question is asked with
five seeds a form and presets that learn in [control_abstractions.md](control_abstractions.md).
"""


def known_or_dash(value: float | None) -> str:
    """Four digits, or a dash."""
    return "-" if value is None else f"{value:.4g}"


def flown_cells(flown: dict[str, Any]) -> list[str]:
    """Cells on the held-out flights."""
    error = flown["median_error"]
    return [
        f"{flown['succeeded']} of {flown['episodes']}",
        str(flown["failed"]),
        "-" if error is None else f"{error:.3f}",
    ]


def draw(rows: list[dict[str, Any]], path: Path) -> None:
    """Return and error over transitions, one column per task, one line per form of control."""
    tasks = sorted({family(row) for row in rows})
    if not tasks:
        return
    figure = Figure(figsize=(4.6 * len(tasks), 5.6), layout="constrained")
    canvas = FigureCanvasAgg(figure)
    panels = np.array(figure.subplots(2, len(tasks), sharex="col", squeeze=False))
    for column, task in enumerate(tasks):
        for row in (row for row in rows if family(row) == task):
            course = row["curve"]
            steps = np.array(course["steps"]) / 1e6
            for axis, name in zip(panels[:, column], ("return", "error"), strict=True):
                label = f"{row['task']}, {row['learner']}"
                axis.plot(steps, np.array(course[name], float), label=label, linewidth=1.2)
        panels[0, column].set(title=task, ylabel="return of training")
        panels[1, column].set(xlabel="million transitions", ylabel="mean error in training [m]")
        panels[0, column].legend(fontsize=8)
        for axis in panels[:, column]:
            axis.grid(alpha=0.3)
    path.parent.mkdir(parents=True, exist_ok=True)
    canvas.print_png(path)


def family(row: dict[str, Any]) -> str:
    """A panel's title: the task without the form of control."""
    return str(row["task"]).partition("_")[0]


def markdown(content: dict[str, Any]) -> str:
    """The page."""
    rows = [
        "| task | learner | machine | runs at once | transitions each | measured [min] "
        "| steps/s, all runs | these runs, 5,000,000 each [min] "
        "| the paper's six, on 24 cores and two GPUs [min] |",
        "| --- | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for row in content["rows"]:
        whole = f"{row['minutes_for_all']:.1f}" + (" (extrapolated)" if row["extrapolated"] else "")
        rows.append(
            f"| `{row['task']}` | {row['learner']} | {machine_line(row['machine'])} "
            f"| {row['runs']} | {row['transitions']:,} "
            f"| {row['seconds'] / 60.0:.1f} | {row['steps_per_second']:,.0f} | {whole} "
            f"| {PAPER_MINUTES:.0f} |"
        )
    hyper = ", ".join(f"{name} {value}" for name, value in content["hyper"].items())
    commands = "\n".join(
        f"    {text}" for text in dict.fromkeys(r["command"] for r in content["rows"])
    )
    return f"""\
# The paper's training protocol

Runs of the GzDRL paper's training study (networks of [512, 512], seeds 1, 25 and 42, 15
environments each, 5,000,000 transitions), by

{commands}

{chr(10).join(rows)}

The paper trains six runs of a task at once (two groups of three seeds, 90 environments) in about
220 minutes on 24 cores and two GPUs. Here the runs of a row go side by side, with one thread each.
`extrapolated`: the runs were cut at the transitions that are shown; the rest is counted at the rate
between the first checkpoint and the last of the slowest run.

`ppo` is that of Stable-Baselines3, on processors alone. Both learners have the same
hyper-parameters: {hyper}.
{learned_section(content.get("learned", []))}"""
