"""Errors of the baseline at its goal, by vehicle and control mode.

    python -m research run flights [--program PROGRAM] [--quick] [--out DIR]

Each flight is one episode of 20 s under the hold baseline, seed 1. The error is the distance
between the vehicle and its goal [mm], mean and maximum over the last second. Exit code 1 if a
flight faults or ends before its horizon.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np

from research.common.options import Options
from research.common.pages import markdown_table, write_page
from research.common.places import PROGRAM, ROOT
from research.common.programs import run_skybody

PAGE = "flights"

VEHICLES = ("qdrone2", "crazyflie", "hummingbird", "firefly")
RACER = ROOT.parent / "shared/data/urdf/racer.urdf"
MODES = {
    "rotor_speed": "[{plugin: rotor_speed}]",
    "srt": "[{plugin: srt}]",
    "ctbt, rotors": "[{plugin: ctbt}]",
    "ctbt, body": "[{plugin: ctbt, parameters: {apply: body}}]",
    "ctbr, rotors": "[{plugin: ctbr}]",
    "ctbr, body": "[{plugin: ctbr, parameters: {apply: body}}]",
    "ctbr, ideal rates": "[{plugin: ctbr, parameters: {apply: body, pd: false}}]",
    "wrench": "[{plugin: wrench}]",
    "velocity": "[{plugin: velocity}]",
    "velocity, position form": "[{plugin: velocity, parameters: {form: position}}]",
    "attitude": "[{plugin: attitude}, {plugin: ctbr}]",
    "position": "[{plugin: position}, {plugin: attitude}, {plugin: ctbr}]",
}


def fly(program: Path, overrides: list[str]) -> tuple[float, float, str]:
    """Makes one flight: mean and maximum error of the last second [mm], and how it ended."""
    with tempfile.TemporaryDirectory() as folder:
        words = ("run", "hover", "--policy", "hold", "--seed", "1", "--no-picture", "--out", folder)
        run_skybody(*words, overrides=overrides, program=program)
        with h5py.File(Path(folder) / "flight.h5") as log:
            episode = log["episodes/0001"]
            last = episode["time"][:] > episode["time"][-1] - 1.0
            goal = episode["goal"][:].reshape(len(last), -1, 4)[last][:, 0, :3]
            position = episode["bodies"][:].reshape(len(last), -1, 13)[last][:, 0, :3]
            events = [text.decode() for text in episode["events"]["text"][:]]
        error = 1e3 * np.linalg.norm(position - goal, axis=1)
        return float(error.mean()), float(error.max()), events[-1]


def vehicle_table(program: Path, vehicles: Sequence[str]) -> tuple[str, bool]:
    """Every vehicle, commanded by rotor speeds."""
    rows = [["vehicle", "mean error [mm]", "max error [mm]", "end"]]
    good = True
    models = [(name, [f"robots[0].model={name}"]) for name in vehicles]
    if RACER.exists():
        rotors = ROOT / "scenarios/models/racer/rotors.yaml"
        models.append(
            ("racer (another's URDF)", [f"robots[0].model={RACER}", f"robots[0].rotors={rotors}"])
        )
    for name, overrides in models:
        mean, most, end = fly(
            program, [*overrides, f"robots[0].controllers={MODES['rotor_speed']}"]
        )
        good &= end == "truncated"
        rows.append([name, f"{mean:.2g}", f"{most:.2g}", end])
    return markdown_table(rows), good


def mode_table(program: Path, vehicles: Sequence[str], modes: Sequence[str]) -> tuple[str, bool]:
    """Every mode on every vehicle: the mean error."""
    rows = [["mode", *(f"{name} [mm]" for name in vehicles)]]
    good = True
    for mode in modes:
        row = [mode]
        for vehicle in vehicles:
            mean, _, end = fly(
                program, [f"robots[0].model={vehicle}", f"robots[0].controllers={MODES[mode]}"]
            )
            good &= end == "truncated"
            row.append(f"{mean:.2g}" if end == "truncated" else f"{mean:.2g} ({end})")
        rows.append(row)
    return markdown_table(rows), good


def main() -> int:
    """Writes both tables."""
    trial = "one vehicle, two modes"
    options = Options(__doc__, __name__, trial, PROGRAM).given()
    flown = list(VEHICLES)[:1] if options.quick else list(VEHICLES)
    vehicles, vehicles_good = vehicle_table(options.program, flown)
    modes, modes_good = mode_table(
        options.program, flown, list(MODES)[:2] if options.quick else list(MODES)
    )
    text = (
        "# Flights under the hold baseline\n\n"
        "Distance from the goal in the last second of 20 s, seed 1; by\n"
        f"`python -m research run flights`.\n\n{vehicles}\n\nMean error by control mode:\n\n"
        f"{modes}\n"
    )
    write_page(options.out, PAGE, text)
    return 0 if vehicles_good and modes_good else 1
