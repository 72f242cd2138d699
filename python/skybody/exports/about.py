"""The description of a flight that formats with metadata carry."""

from __future__ import annotations

from skybody.look.flight import texts

from .table import Table

KEYS = ("format", "scenario", "scenario_hash", "seed", "policy", "dt", "action_repeat")


def about(table: Table) -> dict[str, str]:
    """Attributes of the log as texts (docs/flight-log.md), `episode` and `scenario_text`."""
    attributes = table.flight.attributes
    found = {key: texts(attributes[key])[0] for key in KEYS if key in attributes}
    found["episode"] = str(table.flight.episode)
    found["scenario_text"] = scenario_text(table)
    return found


def scenario_text(table: Table) -> str:
    """The flight's scenario in YAML, with the paths as they were."""
    return texts(table.flight.attributes["scenario_text"])[0]
