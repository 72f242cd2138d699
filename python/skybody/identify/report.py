"""The report of an identification: text, figures for programs, table on the terminal."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from .identify import Identified
from .intervals import Interval
from .judge import TIMES, UNITS, Errors
from .windows import LENGTH


def number(value: float) -> str:
    """Four digits."""
    return f"{value:.4g}"


def parameter_rows(made: Identified) -> list[list[str]]:
    """Name, value, interval, nominal, unit, remark."""
    rows = [["parameter", "value", "95 % interval", "nominal", "unit", ""]]
    for i in made.intervals:
        interval = "" if i.kept == "kept by --fix" else f"{number(i.low)} .. {number(i.high)}"
        remark = f"nominal: {i.kept}" if i.kept else ""
        rows.append([i.name, number(i.value), interval, number(i.nominal), i.unit, remark])
    return rows


def error_rows(made: Identified) -> list[list[str]]:
    """Mean errors of held-out windows."""
    rows = [["mean error", *(f"{kind} at {time:g} s [{unit}]"
                             for kind, unit in UNITS.items() for time in TIMES)]]  # fmt: skip
    for name, errors in made.errors.items():
        found = [errors.mean(kind, time) for kind in UNITS for time in TIMES]
        rows.append([name, *("-" if value is None else number(value) for value in found)])
    return rows


def plain(rows: list[list[str]]) -> str:
    """A table for a terminal."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = ("  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(line.rstrip() for line in lines)


def markdown(rows: list[list[str]]) -> str:
    """A table of Markdown."""
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    lines.insert(1, "|" + " --- |" * len(rows[0]))
    return "\n".join(lines)


def terminal(made: Identified) -> str:
    """Lines for the terminal."""
    return f"{plain(parameter_rows(made))}\n\n{plain(error_rows(made))}"


def text(made: Identified, scenarios: list[str]) -> str:
    """report.md"""
    vehicle = made.model.vehicle
    held = "other flights" if made.test_by_flight else "the last quarter of each flight"
    flights = ", ".join(f"`{track.record.path.name}`" for track in made.train.tracks)
    judged = ", ".join(f"`{track.record.path.name}`" for track in made.test.tracks)
    notes = "".join(f"- {note}\n" for note in made.notes)
    share = f"Mean command: {made.model.scales.share:.4g}" if made.model.scales.is_share else ""
    volts = f", mean voltage {made.model.scales.voltage:.4g} V" if made.model.scales.voltage else ""
    return f"""# {vehicle.name}, identified

From {flights}: {len(made.train)} windows of {made.train.length:g} s. Mass {vehicle.mass:.4g} kg, as
given. {share}{volts if share else ""}

## Parameters

{markdown(parameter_rows(made))}

`command.*`: the rotors' speed for the command u, with x = u (V / mean V)^voltage / mean u - 1:
speed (1 + slope x + curve x^2). Their scale belongs to the nominal thrust constant.
docs/identify.md describes all parameters.

## Prediction

Open-loop replays of {len(made.test)} windows of {LENGTH:g} s of {held} ({judged}), which had no
part in the fit. "nominal, thrust scaled" is the nominal vehicle with the mean thrust right.

{markdown(error_rows(made))}

![errors](errors.png)

![one window](replay.png)

## Remarks

{notes or "None."}
Scenarios: {", ".join(f"`{name}`" for name in scenarios)}.
"""


def figures(made: Identified) -> dict[str, Any]:
    """report.json"""
    return {
        "model": made.model.vehicle.model,
        "mass": made.model.vehicle.mass,
        "flights": [str(track.record.path) for track in made.train.tracks],
        "held_out": [str(track.record.path) for track in made.test.tracks],
        "held_out_by_flight": made.test_by_flight,
        "windows": len(made.train),
        "held_out_windows": len(made.test),
        "mean_command": made.model.scales.share,
        "mean_voltage": made.model.scales.voltage or None,
        "parameters": {i.name: entry(i) for i in made.intervals},
        "start": {k: float(v) for k, v in made.start.items()},
        "errors": {name: errors_entry(e) for name, e in made.errors.items()},
        "notes": made.notes,
    }


def entry(interval: Interval) -> dict[str, Any]:
    """A parameter."""
    return {
        "value": interval.value,
        "interval": [interval.low, interval.high],
        "nominal": interval.nominal,
        "unit": interval.unit,
        "kept_nominal": interval.kept or None,
    }


def errors_entry(errors: Errors) -> dict[str, Any]:
    """Mean errors by kind and time."""
    return {kind: {f"{time:g}": errors.mean(kind, time) for time in TIMES} for kind in UNITS}


def write_report(made: Identified, folder: Path, scenarios: list[str]) -> None:
    """Writes report.md, report.json and the pictures."""
    from .pictures import draw

    (folder / "report.md").write_text(text(made, scenarios))
    (folder / "report.json").write_text(json.dumps(figures(made), indent=2) + "\n")
    draw(made, folder)
