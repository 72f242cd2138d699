"""The description of a flight that formats with metadata carry."""

from __future__ import annotations

from skybody.look.flight import texts

from .table import Table

KEYS = ("format", "scenario", "scenario_hash", "seed", "policy", "dt", "action_repeat")
SCENARIO = "scenario_text"  # the flight's scenario in YAML, with the paths as they were


def about(table: Table, *more: str) -> dict[str, str]:
    """Attributes of the log as texts (docs/flight-log.md): some, `episode`, and `more` keys."""
    attributes = table.flight.attributes
    found = {key: texts(attributes[key])[0] for key in (*KEYS, *more) if key in attributes}
    return found | {"episode": str(table.flight.episode)}
