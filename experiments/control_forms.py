"""The tasks of figure 10 of the GzDRL paper, with policies that command rotor speeds or a force."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

# Steps over which the error in training is averaged: episodes of `payload` in 256 environments.
AVERAGED = 256_000
Row = dict[str, Any]
COLORS = {"end-to-end": "C1", "modular": "C0"}


@dataclass(frozen=True)
class Compared:
    """A task in both forms."""

    scenarios: dict[str, str]  # by form; their presets are equal
    overrides: tuple[str, ...]  # of both forms
    total_steps: int
    thresholds: tuple[float, ...]  # of the mean error [m]
    doc: str


TASKS = {
    "trajectory": Compared(
        scenarios={"end-to-end": "trajectory", "modular": "trajectory_modular"},
        overrides=("randomization.lissajous.parameters.along=0",),
        total_steps=8_000_000,
        thresholds=(0.5, 0.2, 0.1),
        doc="700 and 680 observations, the heading fixed, which no force commands",
    ),
    "payload": Compared(
        scenarios={"end-to-end": "payload_learn", "modular": "payload_modular_learn"},
        overrides=(),
        total_steps=12_000_000,
        thresholds=(2.0, 1.0),
        doc="26 and 25 observations",
    ),
}
FORMS = tuple(COLORS)


def own_of(records: Sequence[Row], task: str, form: str) -> list[Row]:
    """The records of one form of a task, one per seed."""
    return [r for r in records if (r["task"], r["form"]) == (task, form)]
