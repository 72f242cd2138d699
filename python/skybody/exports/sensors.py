"""Sensors of a flight that other programs have own messages for, found by their outputs' names."""

from __future__ import annotations

from .table import Table

AXES = ("[0]", "[1]", "[2]")
BATTERY = {"voltage": "voltage_v", "current": "current_a", "charge": "remaining"}


def imus(table: Table) -> dict[str, tuple[list[int], list[int]]]:
    """Columns of specific force and angular rate of each IMU in `sensors`, by its name."""
    columns = table.series["sensors"].columns if "sensors" in table.series else ()
    place = {name: k for k, name in enumerate(columns)}
    found = {}
    for name in dict.fromkeys(column.partition(".")[0] for column in columns):
        force = [place.get(f"{name}.specific_force{axis}", -1) for axis in AXES]
        rate = [place.get(f"{name}.angular_rate{axis}", -1) for axis in AXES]
        if min(force) >= 0 and min(rate) >= 0:
            found[name] = (force, rate)
    return found


def batteries(table: Table) -> list[dict[str, tuple[str, int]]]:
    """Dataset and column of each value of PX4's battery_status, for each battery with a voltage."""
    found = []
    for dataset in ("info", "sensors"):
        columns = table.series[dataset].columns if dataset in table.series else ()
        place = {name: k for k, name in enumerate(columns)}
        for name in (c.removesuffix(".voltage") for c in columns if c.endswith(".voltage")):
            values = {
                theirs: (dataset, place[f"{name}.{ours}"])
                for ours, theirs in BATTERY.items()
                if f"{name}.{ours}" in place
            }
            found.append(values)
    return found
