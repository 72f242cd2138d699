"""The page and the pictures of real_flights.py."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from skybody.identify.windows import SLOW

from research.common.machine import machine_line
from research.common.pages import markdown_table
from research.common.plots import panels, plain_logarithms, save
from research.real.errors import QUANTITIES, UNITS
from research.real.windows import (
    CLEARANCE,
    HORIZONS,
    MOST_BRIDGED,
    MOST_GAP,
    REASONS,
    WARM_UP,
    Windows,
)

if TYPE_CHECKING:
    from research.real.real_flights import Row

LAST = f"{HORIZONS[-1]:g}"
OURS = "Skybody `crazyflie`"
COLOURS = ("0.4", "#1f77b4", "#2ca02c", "#d62728", "#ff7f0e", "#9467bd", "#8c564b", "#e377c2")
STYLES = {"published": ":", "trimmed": "--"}  # of lines by forms; "-": others
NOTE_ON_PARTS = """The hubs are 24 mm above the centre of mass. There the drag of the rotors turns
the vehicle against its motion. By the commands as recorded, a model without that moment turns over
sooner. By damped commands it is the other way: the shipped model is worse than RotorPy's and
Crazyflow's, whose hubs are at the height of the centre.
"""
NOTE_ON_INPUTS = """The curve of speeds ends at 2269 rad/s, and the shipped model hovers at 2323
rad/s: as published, it falls. The other models rise: this vehicle hovers at 87 % of PWM and
3.45 V, at which the firmware's table promises twice its weight.
"""
SHOWN_PATHS, ACROSS = 12, 3  # windows of a flight in the picture; its columns


def page(
    rows: Sequence[Row], parts: Sequence[Row], windows: Sequence[Windows], found: dict[str, Any]
) -> str:
    """The text of the page.

    Args:
        rows: of the models.
        parts: of the shipped model without a part.
        windows: of all flights.
        found: facts of the machine, command, models that were left out, stride of windows [s].
    """
    return introduction(rows, found) + results(rows, parts, found) + screening(windows, found)


def introduction(rows: Sequence[Row], found: dict[str, Any]) -> str:
    """The part before the tables."""
    count = max(len(row.states) for row in rows)
    return f"""# Replays of recorded flights

{machine_line(found["facts"])}

    .venv/bin/{found["command"]}

Open-loop replays of recorded flights of a real vehicle{source(found)}: {count} windows of
{HORIZONS[-1]:g} s, one every {found["stride"]:g} s. A window begins at the recorded state:
position, attitude and velocity by motion capture, body rates by the gyroscope.
Then each model gets the recorded motor commands, and no correction. The rotors of all models follow
the commands of the {WARM_UP:g} s before. No model or factor saw the flight on which it is judged.

- **published**: constants and curves as their authors give them. The inputs are below.
- **trimmed**: four factors on the rotors' thrusts, from the other flights: each rotor carries a
  quarter of the mean specific force along z. This is the least that a user would do at hover.
- **identified**: a vehicle of `skybody identify`, from other flights.{damped_text(found)}

Errors are distances (cm, m/s, rad/s) and angles (deg) between predicted and recorded states.
Figures in parentheses are 95 % intervals: flights, and blocks of 2 s in them, are drawn with
replacement. With so few flights they are coarse.

"""


def results(rows: Sequence[Row], parts: Sequence[Row], found: dict[str, Any]) -> str:
    """Errors, parts of the shipped model, and inputs."""
    skipped = "".join(f"\n{name}: left out, {why}.\n" for name, why in found["skipped"].items())
    return f"""## After {LAST} s

{last_table(rows)}
{skipped}
![Errors over time](images/real_flights.png)

## Medians after {", ".join(f"{h:g}" for h in HORIZONS)} s

{medians_table(rows)}

## Parts of the shipped model

The shipped model, trimmed, with a part switched off; medians as above.

{medians_table([*(row for row in rows if row.model.title == OURS and row.form), *parts])}

{NOTE_ON_PARTS if found["is_shared"] else ""}
{turns_text(found["turns"])}## Inputs

{inputs_table(rows)}

{NOTE_ON_INPUTS if found["is_shared"] else ""}
The models `so_rpy` take the angles that the onboard controller asked for, not motor commands. Their
fitted response contains that controller, so that their attitude cannot drift away. They answer an
easier question, and a comparison with models of motor commands is not like with like.

"""


def screening(windows: Sequence[Windows], found: dict[str, Any]) -> str:
    """Windows that are used, and the reasons against the others."""
    return f"""## Screening

{screening_table(windows, found["clocks"])}

A window is left out if one of its rows is near the ground (less than {100 * CLEARANCE:g} cm above
rest, or before take-off and after landing), has impossible commands (below 0 or above 65535), lies
in a gap, or has a saturated rotor. Gaps are pauses of more than {1e3 * MOST_GAP:g} ms between
poses, and straight lines of all commands or all rates that last more than {MOST_BRIDGED:g} s: the
data set fills lost telemetry by straight lines. Each window counts once, by the first reason.
Commands and onboard sensors are moved to the clock of the poses: by the offset at which the
gyroscope agrees best with the rates of the recorded attitude.

![Paths of a flight](images/real_flights_paths.png)

Horizontal paths of one flight: recorded (black), and predicted from some of its windows.
"""


def source(found: dict[str, Any]) -> str:
    """The data set."""
    if not found["is_shared"]:
        return ""
    return ", a Crazyflie 2.1 of the data set nanobench\n(Ullah and Baca, arXiv 2603.09908)"


def damped_text(found: dict[str, Any]) -> str:
    """Of the form with damped commands."""
    if found["detail"] is None:
        return ""
    return f"""
- **damped**: the log has too few commands of the rotors. Identification therefore uses only a part
  of the differences between rotors, {found["detail"]:.2f} about moving means over {SLOW:g} s
  (`log.detail` of the first identified vehicle). These rows have the same commands. So they show
  how much of the gain is the vehicle's, and how much is the treatment of the log."""


def last_table(rows: Sequence[Row]) -> str:
    """Medians and means after the longest horizon, with intervals."""
    columns = [f"{q} [{UNITS[q]}]" for q in QUANTITIES]
    lines = [["model", "form", "windows", "", *columns]]
    for row in rows:
        figures = row.figures
        for name in ("median", "mean"):
            values = [str(figures[q][LAST][name]) for q in QUANTITIES]
            head = [row.model.title, row.form, str(len(row.states))]
            lines.append([*(head if name == "median" else ["", "", ""]), name, *values])
    return markdown_table(lines, text=(0, 1, 3))


def medians_table(rows: Sequence[Row]) -> str:
    """Medians of all quantities and horizons."""
    lines = [["model", "form", *(f"{q} [{UNITS[q]}]" for q in QUANTITIES)]]
    for row in rows:
        medians = np.median(row.errors, axis=0)
        texts = [", ".join(f"{value:.3g}" for value in column) for column in medians.T]
        lines.append([row.model.title, row.form, *texts])
    return markdown_table(lines, text=(0, 1))


def turns_text(rows: Sequence[Row]) -> str:
    """The section of logs without poses; empty without any."""
    if not rows:
        return ""
    flights = {w.flight.name: len(w.starts) for row in rows for w in row.windows}
    names = "; ".join(f"{name} ({count} windows)" for name, count in flights.items())
    chosen = [QUANTITIES.index(quantity) for quantity in ("attitude", "rates")]
    lines = [["model", "form", *(f"{QUANTITIES[q]} [{UNITS[QUANTITIES[q]]}]" for q in chosen)]]
    for row in rows:
        medians = np.median(row.errors, axis=0)
        texts = [", ".join(f"{value:.3g}" for value in medians[:, q]) for q in chosen]
        lines.append([row.model.title, row.form, *texts])
    return f"""## Logs without poses

Logs of another Crazyflie at 1 kHz without motion capture (Eschmann, arXiv 2404.07837): {names}.
Attitudes are those of the gyroscope since the start of a window. The velocity is unknown and set to
0, so that moments of the air are missing. Without the battery's voltage models that need it are
left out. Medians as above.

{markdown_table(lines, text=(0, 1))}

"""


def inputs_table(rows: Sequence[Row]) -> str:
    """The inputs of each model."""
    inputs = {row.model.title: row.model.inputs for row in rows}
    return markdown_table([["model", "input"], *map(list, inputs.items())], text=(0, 1))


def screening_table(windows: Sequence[Windows], clocks: Mapping[str, float]) -> str:
    """Windows of each flight, used and left out, and the offset of its clocks."""
    lines = [["flight", "used", *REASONS, "clock [ms]"]]
    for w in windows:
        counts = [str(len(w.starts)), *(str(w.rejected[r]) for r in REASONS)]
        lines.append([w.flight.name, *counts, f"{1e3 * clocks[w.flight.name]:.0f}"])
    return markdown_table(lines)


def draw_errors(rows: Sequence[Row], path: Path) -> None:
    """Medians over the horizons, logarithmic; STYLES."""
    drawing, axes = panels(1, len(QUANTITIES), (13.0, 5.2), sharex=True)
    titles = list(dict.fromkeys(row.model.title for row in rows))
    for row in rows:
        medians = np.median(row.errors, axis=0)
        is_only = sum(other.model is row.model for other in rows) == 1
        style = "-" if is_only else STYLES.get(row.form, "-")
        colour = COLOURS[titles.index(row.model.title) % len(COLOURS)]
        for q, axis in enumerate(axes[0]):
            label = ", ".join(filter(None, [row.model.title, row.form])) if q == 0 else None
            axis.plot(HORIZONS, medians[:, q], style, marker=".", color=colour, label=label)
    for axis, quantity in zip(axes[0], QUANTITIES, strict=True):
        axis.set(title=f"{quantity} [{UNITS[quantity]}]", xlabel="horizon [s]", yscale="log")
        plain_logarithms(axis.yaxis)
    drawing.legend(loc="outside lower center", ncols=3, fontsize=9)
    save(drawing, path)


def draw_flight(rows: Sequence[Row], path: Path) -> None:
    """Recorded and predicted horizontal paths of the flight with most windows."""
    best = max(range(len(rows[0].windows)), key=lambda k: len(rows[0].windows[k].starts))
    flight = rows[0].windows[best].flight
    chosen = [row for row in rows if any(w.flight.name == flight.name for w in row.windows)]
    last = {row.model.title: row for row in chosen}  # the trimmed form, if there is one
    columns = min(len(last), ACROSS)
    lines = -(-len(last) // columns)
    size = (4.2 * columns, 4.4 * lines)
    drawing, axes = panels(lines, columns, size, sharex=True, sharey=True)
    inside = usable_span(rows[0].windows[best])
    for axis in axes.flat[len(last) :]:
        axis.set_visible(False)
    for axis, row in zip(axes.flat, last.values(), strict=False):
        axis.plot(*flight.states[inside, :2].T, color="black", linewidth=0.8)
        k = next(k for k, w in enumerate(row.windows) if w.flight.name == flight.name)
        first = sum(len(w.starts) for w in row.windows[:k])
        own = row.windows[k]
        some = np.linspace(0, len(own.starts) - 1, min(SHOWN_PATHS, len(own.starts))).astype(int)
        starts = own.states(0.0)[some, :2]
        path_of = np.concatenate([starts[:, None], row.states[first + some, :, :2]], axis=1)
        for line in path_of:
            axis.plot(*line.T, color="#d62728", linewidth=1.4, marker=".", markersize=3)
        axis.set(title=f"{row.model.title}\n{row.form}", xlabel="x [m]", aspect="equal")
        axis.title.set_fontsize(9)
    for axis in axes[:, 0]:
        axis.set_ylabel("y [m]")
    save(drawing, path)


def usable_span(windows: Windows) -> slice:
    """Rows of the flight from the first to the last window."""
    ends = np.searchsorted(windows.flight.time, [windows.starts[0], windows.starts[-1] + 0.5])
    return slice(int(ends[0]), int(ends[1]))
