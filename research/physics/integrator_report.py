"""The page and the picture of integrators.py."""

from __future__ import annotations

import math
import statistics
from pathlib import Path
from typing import Any

from research.common.machine import machine_line
from research.common.pages import markdown_table
from research.common.plots import panels, save

Facts = dict[str, Any]
Row = dict[str, Any]
COLOURS = ("#1f77b4", "#ff7f0e", "#d62728", "#9467bd", "#8c564b", "#2ca02c", "#e377c2")


def error_text(row: Row) -> str:
    if row["fault"]:
        return "fault"
    text = f"{1e3 * row['position']:.2g} mm, {math.degrees(row['angle']):.2g}°"
    return f"**{text}**" if row["is_good"] else text


def integrators(facts: Facts) -> list[str]:
    return list(dict.fromkeys(row["integrator"] for row in facts["results"]))


def of_scenario(facts: Facts, scenario: str) -> list[Row]:
    return [row for row in facts["results"] if row["scenario"] == scenario]


def own_row(facts: Facts, flight: Row) -> Row:
    """The result with the scenario's own integrator and step."""
    return next(
        row
        for row in of_scenario(facts, flight["scenario"])
        if row["integrator"] == flight["own"] and math.isclose(row["dt"], flight["own_dt"])
    )


def largest_exact_step(rows: list[Row], integrator: str) -> str:
    """The largest dt up to which all audited ones are exact [ms]."""
    largest = "none"
    for row in sorted((r for r in rows if r["integrator"] == integrator), key=lambda r: r["dt"]):
        if not row["is_good"]:
            break
        largest = f"{1e3 * row['dt']:g}"
    return largest


def summary(facts: Facts) -> str:
    names = integrators(facts)
    rows = [["scenario", "its own choice", "error", "energy [mJ]", "reference's own [mm]"]]
    rows[0] += [f"{name} [ms]" for name in names]
    for flight in facts["flights"]:
        own, mine = own_row(facts, flight), of_scenario(facts, flight["scenario"])
        numbers = [f"{1e3 * own['energy']:.2g}", f"{1e3 * flight['reference_error']:.1g}"]
        start = [flight["scenario"], f"{flight['own']}, {1e3 * flight['own_dt']:g} ms"]
        steps = [largest_exact_step(mine, name) for name in names]
        rows.append([*start, error_text(own), *numbers, *steps])
    return markdown_table(rows)


def is_whole(rows: list[Row]) -> bool:
    """Whether semi-implicit Euler succeeds at 1 ms, as the reference for others."""
    return not cost_of_euler(rows)["fault"]


def cost_of_euler(rows: list[Row]) -> Row:
    return next(
        row
        for row in rows
        if row["integrator"] == "semi_implicit_euler" and math.isclose(row["dt"], 1e-3)
    )


def costs(facts: Facts) -> str:
    """Median over scenarios of the cost relative to semi-implicit Euler at 1 ms."""
    scenarios = [of_scenario(facts, flight["scenario"]) for flight in facts["flights"]]
    scenarios = [rows for rows in scenarios if is_whole(rows)]
    steps = sorted({row["dt"] for row in facts["results"]})
    table = [["integrator", *(f"{1e3 * dt:g} ms" for dt in steps)]]
    for name in integrators(facts):
        shares = [
            [
                row["cost"] / cost_of_euler(rows)["cost"]
                for rows in scenarios
                for row in rows
                if row["integrator"] == name and row["dt"] == dt and not row["fault"]
            ]
            for dt in steps
        ]
        table.append([name, *(f"{statistics.median(share):.2g}" for share in shares)])
    return markdown_table(table)


def details(facts: Facts, flight: Row) -> list[str]:
    mine = of_scenario(facts, flight["scenario"])
    steps = sorted({row["dt"] for row in mine})
    table = [["integrator", *(f"{1e3 * dt:g} ms" for dt in steps)]]
    for name in integrators(facts):
        cells = []
        for row in sorted((r for r in mine if r["integrator"] == name), key=lambda r: r["dt"]):
            text = error_text(row)
            if not row["fault"]:
                text += f"; {1e3 * row['energy']:.2g} mJ; {1e3 * row['cost']:.2g} ms"
            cells.append(text)
        table.append([name, *cells])
    held = f"Commands are held for {1e3 * flight['interval']:g} ms."
    if flight.get("first_touch") is not None:
        held += f" Things touch from {flight['first_touch']:.2f} s on: errors are those after it."
    return [f"### {flight['scenario']}", "", held, "", markdown_table(table), ""]


INTRODUCTION = """\
# Integrators and time steps, audited

Written by `research/physics/integrators.py`; raw figures in data/integrators.json.
{machine}.

Which time step and which integrator is a scenario accurate with, and what does that cost? Each
shipped scenario's baseline flight (`skybody run SCENARIO --policy hold`, `zero` for hard_landing;
1 s) gives commands, of rotors or of the actuators that a robot has instead, held for the least
common multiple of the scenario's action interval and 4 ms. Hard dashes are made of them: each is
multiplied by a factor of 0.8 to 1.2, drawn anew for each command of a robot every 0.1 s, and there
is no ground. Two are flown as they are: hard_landing, onto the ground, and collision, which begins
0.3 s before the two robots of the scenario's own flight are near to each other. All are flown, open
loop, by every integrator and step, and compared with CVODE (BDF) at a relative tolerance of 1e-10:
the integrator is audited, not the controller's rate. How exact that is itself says its distance
from CVODE (Adams) at 1e-11. Where things touch, rk4 with steps of 0.025 ms is the reference, and
its distance from steps of 0.05 ms is given: contact is a correction of each step, whatever
integrates the rest ([contact.md](../contact.md)), so that cvode and arkode do not see it.

- Error: largest distance of any body's origin and largest angle of any body after 1 s. **Bold**:
  less than {position:g} mm and {angle:.2g}°, here called exact.
- Energy: the mechanical energy (kinetic and gravitational) less the reference's. That in springs is
  left out (boom has some).
- Cost: time of the same flight's physics steps, one environment alone, for a simulated second.

`skybody check` warns where dt is larger than 1 ms with semi_implicit_euler, or 4 ms with another
integrator: up to there the largest errors of shipped scenarios that are not made to be stiff (boom
is) and in which nothing touches stay below 8 mm and 0.5°, or 1 mm and 0.1°.

## In short

The last columns: the step from which down every audited one is exact, by integrator; `none`: the
smallest is not.
"""

COSTS = """
cvode and arkode begin anew at every physics step, where commands jump: their own memory would
outlive the step. A start takes small steps of low order, so that they are for stiff systems alone:
elsewhere cvode's errors are of the size of midpoint's, some 30 to 150 times those of rk4, at
many times the cost. That cost, in times of semi-implicit Euler at 1 ms: medians over the scenarios
where that comes through. All go alone here; in batches the fixed steps go 32 side by
side in vector lanes, cvode and arkode one by one.

The stiff scenario, boom, has cvode (BDF) because it asks for no step to be found first. It is not
the cheapest that works. Where the stiffness is mild, as there, smaller fixed steps or explicit
methods (`rk4` at 0.5 ms, `arkode` erk) may do better, as the tables below say; BDF and dirk are for
modes that are far quicker than the motion and die out.
"""


def page(facts: Facts) -> str:
    """The page."""
    good = facts["good"]
    words = {"position": 1e3 * good["position"], "angle": math.degrees(good["angle"])}
    lines = [
        INTRODUCTION.format(machine=machine_line(facts), **words),
        summary(facts),
        "",
        "![error against cost](images/integrators.png)",
        "",
        "## What it costs",
        COSTS,
        costs(facts),
        "",
        "## Every scenario",
        "",
        "Error; energy; time for a simulated second.",
        "",
    ]
    for flight in facts["flights"]:
        lines += details(facts, flight)
    return "\n".join(lines).rstrip() + "\n"


def write_picture(facts: Facts, path: Path) -> None:
    """Error against cost, one panel per scenario; the scenario's own choice is ringed."""
    flights = facts["flights"]
    columns = 4
    rows = math.ceil(len(flights) / columns)
    figure, axes = panels(rows, columns, (3.6 * columns, 2.9 * rows))
    for panel in axes.flat[len(flights) :]:
        panel.axis("off")
    for panel, flight in zip(axes.flat, flights, strict=False):
        draw(panel, facts, flight)
    handles, labels = axes.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    figure.suptitle("Position error after 1 s against cost; dots are dt = 0.25 ... 4 ms")
    save(figure, path, 110)


def draw(panel: Any, facts: Facts, flight: Row) -> None:
    for name, colour in zip(integrators(facts), COLOURS, strict=True):
        mine = [
            row
            for row in of_scenario(facts, flight["scenario"])
            if row["integrator"] == name and not row["fault"]
        ]
        x = [1e3 * row["cost"] for row in mine]
        y = [max(1e3 * row["position"], 1e-9) for row in mine]
        panel.loglog(x, y, "o-", color=colour, label=name, markersize=3.5, linewidth=1)
    own = own_row(facts, flight)
    if not own["fault"]:
        at = (1e3 * own["cost"], max(1e3 * own["position"], 1e-9))
        panel.plot(*at, "o", markersize=10, fillstyle="none", color="black")
    panel.axhline(1e3 * facts["good"]["position"], color="grey", linestyle=":", linewidth=1)
    panel.set_title(f"{flight['scenario']} ({flight['own']})", fontsize=9)
    panel.set_xlabel("ms for a simulated second", fontsize=8)
    panel.set_ylabel("error [mm]", fontsize=8)
    panel.tick_params(labelsize=7)
