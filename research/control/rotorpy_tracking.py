"""Errors of `geometric` compared with RotorPy's SE(3) controller on the same vehicles.

    python -m research run rotorpy_tracking [--quick] [--out DIR]

Both fly RotorPy's Crazyflie and Hummingbird with its rotors' lag and all of its aerodynamics. Both
controllers run at 1 kHz and get the same reference from the same functions. Flights
begin on the reference, level and with its velocity; errors count after `SETTLE` seconds.
"""

from __future__ import annotations

import importlib
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skybody import Simulation

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page
from research.control.rotorpy_vehicle import Constants, constants_of, write_scenario

PAGE = "rotorpy_tracking"

Reals = NDArray[np.float64]
DT = 0.001  # [s]
SETTLE = 5.0  # [s]
SECONDS = 15.0  # of a flight

multirotor: Any = importlib.import_module("rotorpy.vehicles.multirotor")
quadrotor_control: Any = importlib.import_module("rotorpy.controllers.quadrotor_control")


@dataclass(frozen=True)
class Harmonic:
    """p = centre + amplitude o sin(cycles w t + phase), with peak speed `peak`."""

    title: str
    amplitude: tuple[float, float, float]
    cycles: tuple[float, float, float]
    phase: tuple[float, float, float]
    peak: float  # [m/s]

    def rates(self) -> Reals:
        """Rates of each axis [rad/s]."""
        turn = np.linspace(0.0, 2.0 * np.pi, 20001)[:, None]
        speed = np.array(self.amplitude) * self.cycles * np.cos(turn * self.cycles + self.phase)
        return np.asarray(self.cycles) * self.peak / np.linalg.norm(speed, axis=1).max()

    def derivatives(self, t: float) -> Reals:
        """Position to snap, W axes: 5 x 3."""
        w = self.rates()
        values = [
            np.array(self.amplitude) * w**n * np.sin(w * t + self.phase + n * np.pi / 2)
            for n in range(5)
        ]
        values[0] = values[0] + np.array([0.0, 0.0, 3.0])
        return np.array(values)


@dataclass(frozen=True)
class Step:
    """A step of one metre to the side, after the transient."""

    title: str = "step of 1 m"

    def derivatives(self, t: float) -> Reals:
        values = np.zeros((5, 3))
        values[0] = [1.0 if t >= SETTLE else 0.0, 0.0, 3.0]
        return values


CIRCLE = Harmonic("circle, 2 m/s", (1.5, 1.5, 0.0), (1, 1, 1), (np.pi / 2, 0.0, 0.0), 2.0)
LISSAJOUS = Harmonic(
    "the paper's Lissajous, 1.25 m/s", (1.55, 1.55, 0.35), (1, 2, 1), (np.pi / 2, 0.0, 0.0), 1.25
)
EIGHT = Harmonic("figure of eight, 3 m/s", (2.0, 1.0, 0.0), (1, 2, 1), (0.0, 0.0, 0.0), 3.0)
FAST = Harmonic("figure of eight, 10 m/s", (6.0, 3.0, 0.0), (1, 2, 1), (0.0, 0.0, 0.0), 10.0)
CASES = {
    "crazyflie": (CIRCLE, LISSAJOUS, Step(), EIGHT),
    "hummingbird": (CIRCLE, LISSAJOUS, Step(), FAST),
}
Reference = Harmonic | Step
Flier = Callable[[Constants, Reference, float], Reals]


def fly_rotorpy(k: Constants, reference: Reference, seconds: float) -> Reals:
    """Positions after each millisecond."""
    hover = float(np.sqrt(k["mass"] * 9.81 / (4.0 * k["k_eta"])))
    start = reference.derivatives(0.0)
    state = {
        "x": start[0],
        "v": start[1],
        "q": np.array([0.0, 0.0, 0.0, 1.0]),
        "w": np.zeros(3),
        "wind": np.zeros(3),
        "rotor_speeds": np.full(4, hover),
    }
    vehicle = multirotor.Multirotor({**k, "motor_noise_std": 0.0}, initial_state=state)
    controller = quadrotor_control.SE3Control(k)
    path = []
    for i in range(round(seconds / DT)):
        p = reference.derivatives(i * DT)
        flat = {"x": p[0], "x_dot": p[1], "x_ddot": p[2], "x_dddot": p[3], "x_ddddot": p[4]}
        flat |= {"yaw": 0.0, "yaw_dot": 0.0, "yaw_ddot": 0.0}
        state = vehicle.step(state, controller.update(i * DT, state, flat), DT)
        path.append(state["x"])
    return np.array(path)


def fly_ours(k: Constants, reference: Reference, seconds: float) -> Reals:
    chain = (
        "[{plugin: geometric, parameters: {position_min: [-50, -50, -50], position_max: "
        "[50, 50, 50], max_acceleration_side: 30, max_acceleration_up: 30, "
        "max_acceleration_down: 8}}, {plugin: ctbt}]"
    )
    with tempfile.TemporaryDirectory() as folder:
        file = write_scenario(Path(folder), k, lag=float(k["tau_m"]))
        override = "robots.vehicle.rotor_speed=hover"
        sim = Simulation(str(file), control=chain, overrides=[override])
    sim.reset()
    start = reference.derivatives(0.0)
    sim.teleport(position=start[0], velocity=start[1])
    path = []
    for i in range(round(seconds / DT)):
        sim.command([*reference.derivatives(i * DT).ravel(), 0.0, 0.0])
        sim.advance(1)
        path.append(np.array(sim.base().position))
    return np.array(path)


def error_of(path: Reals, reference: Reference) -> tuple[float, float]:
    """RMS and largest distance to the reference after `SETTLE` [cm]."""
    wished = np.array([reference.derivatives((i + 1) * DT)[0] for i in range(len(path))])
    distance = 100.0 * np.linalg.norm(path - wished, axis=1)[round(SETTLE / DT) :]
    return float(np.sqrt(np.mean(distance**2))), float(distance.max())


def compare(vehicle: str, reference: Reference, seconds: float) -> dict[str, Any]:
    k = constants_of(vehicle)
    row: dict[str, Any] = {"vehicle": vehicle, "reference": reference.title}
    fliers: dict[str, Flier] = {"ours": fly_ours, "rotorpy": fly_rotorpy}
    for name, fly in fliers.items():
        began = time.perf_counter()
        rms, largest = error_of(fly(k, reference, seconds), reference)
        row |= {f"{name}_rms": rms, f"{name}_max": largest}
        row[f"{name}_seconds"] = time.perf_counter() - began
    return row


def table(rows: list[dict[str, Any]]) -> str:
    names = "vehicle | reference | geometric here [cm] | SE(3) in RotorPy [cm] | took here | took"
    cells = [head(names)]
    for row in rows:
        errors = [
            f"{row[f'{n}_rms']:.2f} (at most {row[f'{n}_max']:.2f})" for n in ("ours", "rotorpy")
        ]
        times = [f"{row[f'{n}_seconds']:.1f} s" for n in ("ours", "rotorpy")]
        cells.append([row["vehicle"], row["reference"], *errors, *times])
    return markdown_table(cells)


def page(found: dict[str, Any], rows: list[dict[str, Any]]) -> str:
    """The page."""
    return f"""# Beside RotorPy's SE(3) controller

{machine_line(found)}

    .venv/bin/python -m research run rotorpy_tracking

RotorPy's vehicles with its rotors' lag and all of its aerodynamics, flown by `geometric` and `ctbt`
with default gains here, and by RotorPy's own SE(3) controller in RotorPy. Both are evaluated at 1
kHz and get the same reference. RMS of the distance over {SECONDS - SETTLE:g} s; the step comes at
their beginning. RotorPy's controller feeds the acceleration forward, ours jerk, snap and the
rotors' drag as well. RotorPy's gains are the same for both vehicles but for the attitude's; ours
follow from the rotors' lag.

{table(rows)}

The lag of RotorPy's Crazyflie is 72 ms, for which default gains here become gentle; `skybody tune`
fits them to a vehicle.

Ours takes calls from Python each millisecond here; RotorPy is Python altogether.
"""


def main() -> int:
    options = Options(__doc__, __name__).given()
    found = facts()
    seconds = SETTLE + 1.0 if options.quick else SECONDS
    cases = [(vehicle, reference) for vehicle, own in CASES.items() for reference in own]
    rows = [compare(*case, seconds) for case in (cases[:1] if options.quick else cases)]
    write_page(options.out, PAGE, page(found, rows), {"facts": found, "flights": rows})
    return 0
