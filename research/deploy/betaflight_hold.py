"""Betaflight's own SITL holds the attitude of three of our vehicles.

    python -m research run betaflight_hold --firmware PROGRAM [--quick] [--out DIR]

`scripts/build_betaflight.sh FOLDER` builds PROGRAM. Betaflight has its stock gains in angle mode.
Roll, pitch and yaw sticks stay in the middle; a pilot holds the height by the throttle stick. At
`KICKS` the vehicle is set turning at `KICK`. The IMU has the noise of an ICM-42688. Each flight is
flown twice, since Betaflight's clock is the wall's.
"""

from __future__ import annotations

import subprocess
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from skybody.sitl.betaflight_link import BetaflightLink
from skybody.sitl.betaflight_pilot import HoldPilot
from skybody.sitl.betaflight_program import BetaflightProgram, settings_for
from skybody.sitl.vehicle import Setup, Vehicle

from research.common.machine import facts, machine_line
from research.common.pages import head, markdown_table, write_page
from research.common.places import PROGRAM
from research.deploy.firmware import firmware_options

PAGE = "betaflight_hold"

Reals = NDArray[np.float64]
SECONDS = 60.0
QUICK = 16.0
KICK = (3.0, -3.0, 2.0)  # about forward, left, up [rad/s]
KICKS = (12.0, 24.0, 36.0, 48.0)  # [s]
SETTLED = 6.0  # after a kick [s]
IMU = "sensors=[{plugin: imu, parameters: {preset: icm42688}}]"
RACER = ("--mass", "0.7", "--arm", "0.11", "--thrust-to-weight", "5")


class Recorder(Vehicle):
    """A vehicle that is kicked, and that keeps its motion."""

    def __init__(self, setup: Setup) -> None:
        super().__init__("betaflight", setup)
        self.rows: list[Reals] = []

    def advance(self, throttles: ArrayLike, steps: int) -> None:
        """As Vehicle.advance."""
        if any(abs(self.time - kick) < 0.5 * self.dt for kick in KICKS):
            self.simulation.teleport(angular_velocity=KICK)
        super().advance(throttles, steps)
        now = self.simulation.base()
        self.rows.append(np.concatenate([[self.time], now.position, now.rotation]))


@dataclass(frozen=True)
class Flight:
    """One row of the table."""

    vehicle: str
    frame: str
    largest_tilt: float  # [deg]
    settled_tilt: float  # greatest, `SETTLED` after each kick and later [deg]
    height_error: float  # greatest, then [m]
    late: int  # answers of Betaflight


def fly(name: str, scenario: str, frame: str, firmware: Path, options: Any) -> tuple[Flight, Reals]:
    """One flight, and its rows (time, position, quaternion)."""
    vehicle = Recorder(Setup(scenario, frame=frame, overrides=(IMU,)))
    start = vehicle.read().position[2]
    link = BetaflightLink(vehicle, HoldPilot(vehicle, 1.0), options.factor)
    with BetaflightProgram(firmware, settings_for(vehicle.frame)) as program:
        link.serve(QUICK if options.quick else SECONDS, program)
    rows = np.array(vehicle.rows)
    tilt = tilts(rows)
    times = rows[:, 0]
    calm = times > KICKS[0] - 1.0
    for kick in KICKS:
        calm &= (times < kick) | (times > kick + SETTLED)
    late = link.messages.counts["late answers"]
    error = float(np.abs(rows[calm, 3] - start - 1.0).max())
    found = Flight(name, vehicle.frame, float(tilt.max()), float(tilt[calm].max()), error, late)
    return found, rows


def tilts(rows: Reals) -> Reals:
    """Angles between the vehicle's axis and the vertical [deg]."""
    return np.degrees(2.0 * np.arcsin(np.minimum(1.0, np.hypot(rows[:, 5], rows[:, 6]))))


def written_racer(folder: Path) -> str:
    """The scenario of a racer with propellers of 5 inches, by `skybody new vehicle`."""
    command = [str(PROGRAM), "new", "vehicle", "racer", *RACER, "--dir", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    return str(folder / "racer/scenario.yaml")


def measure(options: Any) -> list[dict[str, Any]]:
    """Both flights of each vehicle, and how far apart they are."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        cases = [
            ("crazyflie", "hover_crazyflie", ""),
            ("qdrone2", "hover", "x-reversed"),
            ("racer, 5 inches", written_racer(Path(folder)), ""),
        ]
        for name, scenario, frame in cases[:1] if options.quick else cases:
            (first, rows), (_, again) = (
                fly(name, scenario, frame, options.firmware, options) for _ in range(2)
            )
            apart = np.linalg.norm(rows[:, 1:4] - again[:, 1:4], axis=1)
            before = apart[rows[:, 0] < KICKS[0]].max()
            tilt = np.abs(tilts(rows) - tilts(again)).max()
            found.append(
                {
                    **asdict(first),
                    "apart_before_kicks": float(before),
                    "apart_at_end": float(apart[-1]),
                    "tilts_apart": float(tilt),
                }
            )
    return found


def page(about: dict[str, Any], flights: list[dict[str, Any]], options: Any) -> str:
    """The page."""
    rows: list[Any] = [
        head(
            "vehicle | frame | greatest tilt [deg] | settled tilt [deg] | height error [m] | "
            "late answers | two runs apart before the first kick [m] | at the end [m] | "
            "tilts apart [deg]"
        )
    ]
    for row in flights:
        rows.append(
            [
                row["vehicle"],
                f"`{row['frame']}`",
                f"{row['largest_tilt']:.1f}",
                f"{row['settled_tilt']:.2f}",
                f"{row['height_error']:.3f}",
                row["late"],
                f"{row['apart_before_kicks']:.3f}",
                f"{row['apart_at_end']:.2f}",
                f"{row['tilts_apart']:.2f}",
            ]
        )
    return f"""# Betaflight holds our vehicles

{machine_line(about)}

    python -m research run {PAGE} --firmware PROGRAM --factor {options.factor:g}

Betaflight 4.6.0 (SITL), stock gains, angle mode, {SECONDS:g} s of simulated time at
{options.factor:g} times real time, sticks in the middle; throttle by `skybody sitl betaflight
--pilot hold`. At 12, 24, 36 and 48 s the vehicle is set turning at 3, -3 and 2 rad/s. "Settled" is
from {SETTLED:g} s after a kick until the next. The IMU has the noise of an ICM-42688.
The height error is the overshoot of the take-off.

{markdown_table(rows, text=(0, 1))}

Two runs have other bits: Betaflight's loops run by the clock of the wall, which it scales by the
spacing of our packets. So the number of its control steps between two packets differs by chance.
Nothing holds the horizontal position, so that small differences of tilt grow into metres.
"""


def main() -> int:
    options = firmware_options(__doc__, __name__)
    about = facts()
    flights = measure(options)
    write_page(
        options.out, PAGE, page(about, flights, options), {"facts": about, "flights": flights}
    )
    return 0
