"""Output of tuning: gains as YAML, all figures as JSON, a table."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .cost import WEIGHTS
from .margins import Margins
from .tuner import HELD_OUT, Outcome, Tuned
from .vehicle import entries_of


def gains_yaml(tuned: Tuned, robot: str) -> str:
    """The chain with its gains, for inclusion in a scenario, with the margins as comments."""
    vehicle, after = tuned.vehicle, tuned.after
    lines = [
        f"# Gains of {vehicle.name} for {vehicle.chain}, fitted by `skybody tune`: seed "
        f"{tuned.options.seed}, {tuned.history[-1][0]} candidates.",
        f"# Cost on {HELD_OUT} vehicles and winds that the search has not seen: "
        f"{tuned.before.cost:.3f} with default gains, {after.cost:.3f} with these.",
        *(f"# {line}" for line in margin_lines(after.margins, vehicle.latency)),
        f"# In a scenario: `include: [YOURS.yaml, gains.yaml]`; its robot is called `{robot}`.",
        "robots:",
        f"  {robot}:",
        f"    controllers:{_controllers(tuned)}",
    ]
    return "\n".join(lines) + "\n"


def _controllers(tuned: Tuned) -> str:
    """Controllers of the chain, each with its gains, as a list over several lines."""
    entries = entries_of(tuned.uses, tuned.after.parameters)
    return "".join(f"\n      - {entry}" for entry in entries)


def margin_lines(margins: Margins | None, latency: float) -> list[str]:
    """The margins in words."""
    if margins is None:
        return []
    turning, moving = margins.turning, margins.moving
    return [
        "Margins, by simulation:",
        f"  gain of turning: {_factor(turning.up)} up, {_factor(turning.down)} down",
        f"  gain of moving: {_factor(moving.up)} up, {_factor(moving.down)} down",
        f"  delay: {_milliseconds(margins.delay)} more than the {1000.0 * latency:g} ms that were "
        "flown",
    ]


def _factor(value: float) -> str:
    if math.isinf(value):
        return "more than 32"
    if value == 0.0:
        return "less than 1/32"
    return f"{value:.2f} ({20.0 * math.log10(value):+.1f} dB)"


def _milliseconds(value: float) -> str:
    return "more than 320 ms" if math.isinf(value) else f"{1000.0 * value:.0f} ms"


class _MarginRow(NamedTuple):
    """A margin before and after tuning."""

    name: str
    old: float
    new: float
    text: Callable[[float], str]
    room: Callable[[float], float]
    """The size of the margin, for comparison."""


def _margin_rows(tuned: Tuned) -> list[_MarginRow]:
    """All margins; empty if they are unknown."""
    a, b = tuned.before.margins, tuned.after.margins
    if a is None or b is None:
        return []
    factors = (
        ("turning gain, up", a.turning.up, b.turning.up),
        ("turning gain, down", a.turning.down, b.turning.down),
        ("moving gain, up", a.moving.up, b.moving.up),
        ("moving gain, down", a.moving.down, b.moving.down),
    )
    rows = [_MarginRow(*row, _factor, _room) for row in factors]
    return [*rows, _MarginRow("delay margin", a.delay, b.delay, _milliseconds, float)]


def table(tuned: Tuned) -> str:
    """Costs before and after, term by term, over the held-out draws."""
    rows = [("", "default", "tuned")]
    rows.append(("cost", f"{tuned.before.cost:.3f}", f"{tuned.after.cost:.3f}"))
    for name in WEIGHTS:
        values = [float(np.mean(o.costs.terms[name])) for o in (tuned.before, tuned.after)]
        rows.append((name, f"{values[0]:.4f}", f"{values[1]:.4f}"))
    rows.append(("lost flights", str(tuned.before.lost), str(tuned.after.lost)))
    rows += [(row.name, row.text(row.old), row.text(row.new)) for row in _margin_rows(tuned)]
    first, second, third = (max(len(row[k]) for row in rows) for k in range(3))
    return "".join(f"{name:<{first}}  {old:>{second}}  {new:>{third}}\n" for name, old, new in rows)


FALL = 0.1  # relative decrease of a margin that is reported


def fallen_margins(tuned: Tuned) -> list[str]:
    """The margins that are smaller with the tuned gains, in words; empty unless the cost is lower.

    A factor on a gain is a margin by its distance from 1 in dB, in both directions.
    """
    if tuned.after.cost >= tuned.before.cost:
        return []
    return [
        f"{row.name} from {row.text(row.old)} to {row.text(row.new)}"
        for row in _margin_rows(tuned)
        if row.room(row.new) < (1.0 - FALL) * row.room(row.old)
    ]


def _room(factor: float) -> float:
    """The distance of a factor from 1; infinite for a factor beyond all that were tried."""
    return math.inf if factor == 0.0 or math.isinf(factor) else abs(math.log(factor))


def report(tuned: Tuned) -> dict[str, Any]:
    """All figures, as a dictionary for programs."""
    return {
        "vehicle": tuned.vehicle.model,
        "chain": tuned.vehicle.chain,
        "level": tuned.program.level,
        "latency_s": tuned.vehicle.latency,
        "seed": tuned.options.seed,
        "candidates": tuned.history[-1][0],
        "draws": tuned.options.draws,
        "held_out_draws": HELD_OUT,
        "better_on": tuned.better_draws,
        "seconds": round(tuned.seconds, 2),
        "before": _outcome(tuned.before),
        "after": _outcome(tuned.after),
        "fallen_margins": fallen_margins(tuned),
        "search": [[tried, cost] for tried, cost in tuned.history],
    }


def _outcome(outcome: Outcome) -> dict[str, Any]:
    margins = outcome.margins
    return {
        "cost": outcome.cost,
        "terms": {name: float(np.mean(v)) for name, v in outcome.costs.terms.items()},
        "lost": outcome.lost,
        "margins": None
        if margins is None
        else {
            "turning": {"up": _finite(margins.turning.up), "down": margins.turning.down},
            "moving": {"up": _finite(margins.moving.up), "down": margins.moving.down},
            "delay_s": _finite(margins.delay),
        },
        "gains": outcome.parameters,
    }


def _finite(value: float) -> float | None:
    """Replaces infinity, which JSON does not have, by None."""
    return value if math.isfinite(value) else None


def write(tuned: Tuned, folder: Path, robot: str) -> list[Path]:
    """Writes gains.yaml, report.json and, if matplotlib is installed, step_response.png."""
    from .picture import draw

    folder.mkdir(parents=True, exist_ok=True)
    gains, figures = folder / "gains.yaml", folder / "report.json"
    gains.write_text(gains_yaml(tuned, robot), encoding="utf-8")
    figures.write_text(json.dumps(report(tuned), indent=2) + "\n", encoding="utf-8")
    return [gains, figures, *draw(tuned, folder / "step_response.png")]
