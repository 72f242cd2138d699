"""Sensors for an autopilot: the scenario's own, and ideal ones where they are missing."""

from __future__ import annotations

import re
from collections.abc import Iterable

from skybody import CompiledScenario

KINDS = ("imu", "barometer", "gnss", "magnetometer")
PREFIX = "sitl_"  # of the names of added sensors


def sensor_of(compiled: CompiledScenario, kind: str, robot: str) -> str | None:
    """The name of a robot's first sensor of a plugin; None if it has none."""
    for name, plugin in compiled.sensors.items():
        if plugin == kind and compiled.sensor_parameters(name)["robot"][0] in ("", robot):
            return name
    return None


def with_missing_sensors(
    compiled: CompiledScenario, robot: str, altitude: float
) -> tuple[list[str], list[str]]:
    """Overrides that add an ideal sensor of each kind that the robot lacks, and their kinds.

    Args:
        altitude: of the origin of W above the sea, for a barometer [m].
    """
    missing = [kind for kind in KINDS if sensor_of(compiled, kind, robot) is None]
    if not missing:
        return [], []
    return [f"sensors=\n{sensor_list(compiled.scenario_text, robot, missing, altitude)}"], missing


def sensor_list(text: str, robot: str, missing: Iterable[str], altitude: float) -> str:
    """The scenario's list of sensors as YAML with further ones.

    Args:
        text: the merged scenario, as CompiledScenario.scenario_text.
    """
    found = re.search(r"^sensors:\n((?:[ -].*\n|\n)*)", text + "\n", re.MULTILINE)
    own = found[1] if found else ""
    indent = " " * (len(own) - len(own.lstrip(" ")))
    lines = []
    for kind in missing:
        more = f", altitude: {altitude!r}" if kind == "barometer" else ""
        lines.append(
            f"{indent}- {{plugin: {kind}, name: {PREFIX}{kind}, "
            f"parameters: {{robot: {robot}{more}}}}}\n"
        )
    return own + "".join(lines)
