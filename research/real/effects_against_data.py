"""Downwash, ground effect and battery of the engine beside flights of real Crazyflies.

    python -m research run effects_against_data [--neural-swarm FOLDER] [--flights PATH...]

--neural-swarm: a checkout of github.com/aerorobotics/neural-swarm (G. Shi et al., Neural-Swarm2,
T-RO 2021), whose flights have the thrust by a curve of the motors measured on a stand. Of these
flights the residual force along z is compared: m a - T, with m by the same flight's free parts.
--flights: as for real_flights, for the battery. Missing data are left out, and the page says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from research.common.machine import facts
from research.common.options import Options
from research.common.pages import write_page
from research.common.plots import panels, save
from research.real import battery_case, effect_cases
from research.real.effects_page import page
from research.real.real_flights import SHARED
from research.real.recorded_flights import Reals, files_of, read

PAGE = "effects_against_data"


@dataclass(frozen=True)
class Curve:
    """Measured values beside those of the engine with default and with other constants."""

    at: Reals
    measured: Reals
    default: Reals
    other: Reals
    counts: Reals  # samples of each measured value

    @property
    def facts(self) -> dict[str, list[float]]:
        """As plain numbers."""
        return {name: np.round(values, 6).tolist() for name, values in vars(self).items()}


def downwash(folder: Path) -> tuple[str, dict[str, Curve]]:
    """Constants that fit every second flight; forces [g] on the lower vehicle of the others."""
    fitted = effect_cases.fitted_downwash(effect_cases.downwash_samples(folder, 0))
    samples = effect_cases.downwash_samples(folder, 1)
    curves = {}
    for name, (near, far) in effect_cases.DISTANCES.items():
        beside = (samples[:, 1] >= near) & (samples[:, 1] < far)
        at, measured, counts = effect_cases.binned(
            samples[beside, 0], samples[beside, 2], effect_cases.HEIGHTS
        )
        default, other = (
            np.array([effect_cases.downwash_force(k, 0.5 * (near + far), h) for h in at])
            for k in (effect_cases.SHIPPED, fitted)
        )
        curves[name] = Curve(at, measured, default, other, counts)
    return fitted, curves


def ground(folder: Path) -> Curve:
    """Thrust near the ground over that far from it, by the height of the hubs [m]."""
    heights, gains = effect_cases.ground_samples(folder)
    at, measured, counts = effect_cases.binned(heights, gains, effect_cases.HUB_HEIGHTS)
    rotor, circle = (
        effect_cases.ground_gain(at, radius)
        for radius in (effect_cases.RADIUS, effect_cases.CIRCLE)
    )
    return Curve(at, measured, rotor, circle, counts)


def draw(found: dict[str, Any], path: Path) -> None:
    """The curves and one flight of the battery."""
    drawing, axes = panels(1, 3, (13.0, 3.8))
    for (name, curve), colour in zip(found["downwash"].items(), ("C0", "C1", "C2"), strict=False):
        axes[0][0].plot(curve.at, curve.measured, "o", color=colour, label=f"{name}, measured")
        axes[0][0].plot(curve.at, curve.default, ":", color=colour, label=f"{name}, default")
        axes[0][0].plot(curve.at, curve.other, "-", color=colour, label=f"{name}, fitted")
    axes[0][0].set(title="downwash on the lower Crazyflie", xlabel="vertical distance [m]")
    axes[0][0].set_ylabel("force [g]")
    if (curve := found["ground"]) is not None:
        axes[0][1].plot(1e2 * curve.at, curve.measured, "o", color="C0", label="measured")
        for values, style, name in (
            (curve.default, ":", "a rotor"),
            (curve.other, "-", "all rotors"),
        ):
            label = f"radius of {name}"
            axes[0][1].plot(1e2 * curve.at, values, style, color="C1", label=label)
    axes[0][1].set(title="ground effect", xlabel="height of the hubs [cm]", ylabel="gain of thrust")
    for case in found["battery"][:1]:
        axes[0][2].plot(case.time, case.measured, color="C0", label=f"{case.name}, measured")
        axes[0][2].plot(case.time, case.ours, color="C1", label="engine, fitted on the others")
    axes[0][2].set(title="battery", xlabel="time [s]", ylabel="voltage [V]")
    for axis in axes[0]:
        if axis.lines:
            axis.legend(fontsize=7)
    save(drawing, path)


def main() -> int:
    options = (
        Options(__doc__, __name__, "the same")
        .add("--neural-swarm", type=Path, metavar="FOLDER")
        .add("--flights", type=Path, nargs="+", default=[SHARED], metavar="PATH")
        .add("--map", default="nanobench", help="default: nanobench")
        .given()
    )
    folder = options.neural_swarm
    constants, curves = downwash(folder) if folder else ("", {})
    found: dict[str, Any] = {
        "constants": constants,
        "downwash": curves,
        "ground": ground(folder) if folder else None,
        "battery": battery(options.flights, options.map),
    }
    draw(found, options.out / f"images/{PAGE}.png")
    head = {"facts": facts(), "command": options.command}
    write_page(options.out, PAGE, page(found, head), head | plain(found))
    return 0


def battery(paths: Sequence[Path], map_name: str) -> list[battery_case.Case]:
    """Voltages of each flight by a pack that was fitted on the others; none without flights."""
    if not all(path.exists() for path in paths):
        return []
    return battery_case.cases([read(file, map_name) for file in files_of(list(paths))])


def plain(found: dict[str, Any]) -> dict[str, Any]:
    """The figures as plain numbers."""
    return {
        "constants": found["constants"],
        "downwash": {name: curve.facts for name, curve in found["downwash"].items()},
        "ground": found["ground"].facts if found["ground"] else None,
        "battery": [case.facts for case in found["battery"]],
    }
