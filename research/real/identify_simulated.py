"""Whether `skybody identify` finds the constants of 20 drawn vehicles from noisy simulated flights.

Two flights of each vehicle, with a lively reference and some shaking, become CSV files with noise
and offsets of the sensors. The command reads them as it reads real ones.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from skybody import InputError
from skybody.identify.identify import Identified, identify
from skybody.identify.identify import Options as Choices
from skybody.identify.reading import Log, read
from skybody.identify.vehicle import Vehicle

from research.common.options import Options
from research.common.pages import markdown_table, write_page
from research.real.simulated_flights import Truth, drawn, write_flights

PAGE = "identify_simulated"
MODEL = "crazyflie"
VEHICLES, SECONDS, WINDOWS = 20, 15.0, 160
KINDS = ("position", "attitude", "rate")


@dataclass(frozen=True)
class Found:
    """One parameter of one vehicle."""

    vehicle: int
    name: str
    truth: float
    value: float
    low: float
    high: float
    kept: bool

    @property
    def inside(self) -> bool:
        """Whether the truth is in the interval."""
        return self.low <= self.truth <= self.high

    @property
    def far(self) -> float:
        """Distance of the truth from the value, in half widths of the interval."""
        return abs(self.truth - self.value) / max(0.5 * (self.high - self.low), 1e-300)


@dataclass(frozen=True)
class OneVehicle:
    """Results of one vehicle."""

    found: list[Found]
    errors: dict[str, list[float]]  # by model, at 0.5 s: position [m], attitude [rad], rate [rad/s]
    refused: str = ""  # the message, if its flights cannot be used

    def line(self, number: int) -> str:
        """For the terminal."""
        missed = ", ".join(f"{f.name} ({f.far:.1f})" for f in self.found if not f.inside)
        inside = sum(f.inside for f in self.found)
        return f"vehicle {number}: {self.refused or f'{inside} of {len(self.found)}; {missed}'}"


def attempt(number: int, seconds: float, windows: int) -> OneVehicle:
    """Flies and identifies a drawn vehicle."""
    try:
        truth, made = identified(number, seconds, windows)
    except InputError as error:
        return OneVehicle([], {}, str(error).split(": ", 1)[-1])
    errors = {
        name: [made.errors[name].mean(kind, 0.5) or 0.0 for kind in KINDS] for name in made.errors
    }
    return OneVehicle(found_of(number, truth, made), errors)


def identified(number: int, seconds: float, windows: int) -> tuple[Truth, Identified]:
    """A drawn vehicle, and the result of its identification."""
    vehicle, rng = Vehicle(MODEL), np.random.default_rng(1000 + number)
    truth = drawn(vehicle, rng)
    with tempfile.TemporaryDirectory() as folder:
        files, columns = write_flights(Path(folder), vehicle, truth, seconds, rng)
        records = [read(Log(file), vehicle, str(columns), {}) for file in files]
    return truth, identify(vehicle, records, [], Choices(windows), lambda _: None)


def found_of(number: int, truth: Truth, made: Identified) -> list[Found]:
    """All parameters beside the truth."""
    scales = made.model.scales
    true = truth.values | truth.command(scales.share, scales.voltage)
    return [
        Found(number, i.name, true[i.name], i.value, i.low, i.high, bool(i.kept))
        for i in made.intervals
    ]


def table(found: Sequence[Found]) -> list[list[str]]:
    """Coverage and errors by parameter."""
    rows = [["parameter", "in the interval", "kept nominal", "median error", "median half width"]]
    for name in dict.fromkeys(f.name for f in found):
        some = [f for f in found if f.name == name]
        error = np.median([abs(f.value - f.truth) for f in some])
        width = np.median([0.5 * (f.high - f.low) for f in some])
        rows.append(
            [
                f"`{name}`",
                f"{sum(f.inside for f in some)} of {len(some)}",
                str(sum(f.kept for f in some)),
                f"{error:.2g}",
                f"{width:.2g}",
            ]
        )
    return rows


def verdict(found: Sequence[Found]) -> str:
    """The coverage in words."""
    inside = sum(f.inside for f in found)
    worst = max(found, key=lambda f: f.far)
    vehicles = {f.vehicle for f in found} - {f.vehicle for f in found if not f.inside}
    count = len({f.vehicle for f in found})
    return (
        f"**{inside} of {len(found)} true values ({100.0 * inside / len(found):.1f} %) lie in "
        f"their intervals of 95 %**; all of them for {len(vehicles)} of {count} vehicles. The "
        f"farthest is `{worst.name}`: {worst.far:.1f} half widths from its value."
    )


def errors(made: Sequence[OneVehicle]) -> list[list[str]]:
    """Mean errors of prediction on held-out windows."""
    rows = [
        ["vehicle", "position at 0.5 s [m]", "attitude at 0.5 s [rad]", "rate at 0.5 s [rad/s]"]
    ]
    for name in made[0].errors:
        rows.append([name, *(f"{x:.3g}" for x in np.mean([m.errors[name] for m in made], axis=0))])
    return rows


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the experiment and writes its page."""
    options = Options(__doc__, __name__, "one vehicle, short flights")
    options.add("--vehicles", type=int, default=VEHICLES, help="number of vehicles")
    options.add("--seconds", type=float, default=SECONDS, help="of each flight")
    options.add("--windows", type=int, default=WINDOWS, help="of a fit")
    given = options.given(arguments)
    count = 1 if given.quick else given.vehicles
    seconds, windows = (5.0, 30) if given.quick else (given.seconds, given.windows)
    with ProcessPoolExecutor(min(count, os.cpu_count() or 1)) as pool:
        made = []
        for one in pool.map(partial(attempt, seconds=seconds, windows=windows), range(count)):
            print(one.line(len(made)), flush=True)
            made.append(one)
    found = [f for one in made for f in one.found]
    print(verdict(found))
    text = page(made, seconds, windows)
    write_page(given.out, PAGE, text, {"parameters": [vars(f) for f in found]})
    return 0


def page(made: Sequence[OneVehicle], seconds: float, windows: int) -> str:
    """The page."""
    used = [one for one in made if not one.refused]
    found = [f for one in used for f in one.found]
    refused = "".join(
        f"\nThe logs of vehicle {number} are refused: {one.refused}.\n"
        for number, one in enumerate(made)
        if one.refused
    )
    return f"""# Identification of simulated vehicles

{verdict(found)}
{refused}
{len(made)} vehicles are drawn about the Crazyflie: inertias, moment constant and rotor inertia
by 10 to 20 %, lags, delays, the law of the commands, drag, centre of mass, and offsets of the
sensors (`research/real/simulated_flights.py`). Each flies twice for {seconds:g} s. The logs
have rows at 500 Hz, with noise of 1 mm, 3 mrad, 0.02 rad/s and 0.15 m/s^2. `skybody identify` fits
{windows} windows.

## Intervals

"Kept nominal": the flights of so many vehicles do not tell the parameter; its interval then says
where it may be.

{markdown_table(table(found))}

## Prediction on held-out windows

{markdown_table(errors(used))}
"""
