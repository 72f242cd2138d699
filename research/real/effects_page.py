"""The page of effects_against_data.py."""

from __future__ import annotations

from typing import Any

from research.common.machine import machine_line
from research.common.pages import markdown_table
from research.real.battery_case import CAPACITY, EFFICIENCY
from research.real.effect_cases import CIRCLE, RADIUS

LEFT_OUT = "Left out: no flights were given."


def page(found: dict[str, Any], head: dict[str, Any]) -> str:
    """The text of the page."""
    return f"""# Effects beside flights

{machine_line(head["facts"])}

    .venv/bin/{head["command"]}

Effects of the engine with the shipped `crazyflie` beside recorded flights of real Crazyflies. The
overview of all effects is [fidelity.md](../fidelity.md).

![Effects beside flights](images/effects_against_data.png)

## Downwash

Two Crazyflies 2.1 of about 33 g swap places, one above the other (neural-swarm, 11 flights;
G. Shi et al., T-RO 2021). The force on the lower one is m a - T: T by the flights' curve of thrust
from PWM and voltage, measured on a stand; m by the parts of the flight outside the jet. The
default is `downwash` with its own constants, which gym-pybullet-drones gives for its Crazyflie. The
constants of the last column were fitted on every second flight; the table has the other flights:

    {found["constants"] or "none"}

{downwash_table(found)}

## Ground effect

Four take-offs and landings of single Crazyflies (same source). The gain is m a over T. Heights are
those of the hubs: of the shipped model, 3.9 cm when it stands. The engine's gain is that of
`ground_effect`, form `cheeseman_bennett`: with the radius of a rotor ({1e3 * RADIUS:.0f} mm), as
the source has it, and with that of the circle around all rotors ({1e3 * CIRCLE:.0f} mm).

{ground_table(found)}

## Battery

The effect `battery` with one cell of {CAPACITY:g} A h, the default curve of a cell and the recorded
commands, as rotor speeds by Bitcraze's curve. The resistance is that with the least error on the
other flights; the efficiency is the default, {EFFICIENCY:g}. The charge at the start is that of the
voltage at rest. The error is the RMS over the flight; the sag is the measured drop from rest to the
mean in flight.

{battery_table(found)}
"""


def downwash_table(found: dict[str, Any]) -> str:
    """Forces by horizontal and vertical distance."""
    if not found["downwash"]:
        return LEFT_OUT
    lines = [["distance from the axis", "height [m]", "samples", "measured [g]"]]
    lines[0] += ["default [g]", "fitted [g]"]
    for name, curve in found["downwash"].items():
        rows = zip(curve.at, curve.counts, curve.measured, curve.default, curve.other, strict=True)
        lines += [
            [name, f"{at:.3f}", f"{count:.0f}", *(f"{force:.1f}" for force in forces)]
            for at, count, *forces in rows
        ]
    return markdown_table(lines)


def ground_table(found: dict[str, Any]) -> str:
    """Gains by height."""
    curve = found["ground"]
    if curve is None:
        return LEFT_OUT
    rows = zip(curve.at, curve.counts, curve.measured, curve.default, curve.other, strict=True)
    lines = [["height of the hubs [cm]", "samples", "measured", "rotor", "circle"]]
    lines += [
        [f"{1e2 * at:.1f}", f"{count:.0f}", *(f"{gain:.3f}" for gain in gains)]
        for at, count, *gains in rows
    ]
    return markdown_table(lines)


def battery_table(found: dict[str, Any]) -> str:
    """Errors of each flight."""
    if not found["battery"]:
        return LEFT_OUT
    lines = [["flight", "sag [V]", "error [V]", "resistance [ohm]"]]
    for case in found["battery"]:
        numbers = (case.sag, case.error, case.resistance)
        lines.append([case.name, *(f"{number:.3f}" for number in numbers)])
    return markdown_table(lines)
