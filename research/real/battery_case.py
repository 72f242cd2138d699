"""The battery: voltages of recorded flights beside the engine's pack, fitted on other flights."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from skybody import CompiledScenario, Pool

from research.real import curves
from research.real.engine import order_of
from research.real.recorded_flights import Reals, Recorded
from research.real.windows import faults_of

CAPACITY = 0.25  # of the Crazyflie's pack [A h]
RESISTANCES = np.linspace(0.02, 1.0, 99)  # candidates [ohm]
EFFICIENCY = 0.7  # the default
CELL = (3.27, 3.69, 3.73, 3.77, 3.8, 3.84, 3.87, 3.95, 4.02, 4.11, 4.2)  # the default curve [V]
STEP = 0.05  # of the comparison [s]
MAX_SPEED = 2618.0  # of the shipped model [rad/s]
SETTLE = 1.0  # after the rotors have started [s]

SCENARIO = f"""
name: battery
stepping: {{dt: 0.005, action_repeat: {round(STEP / 0.005)}}}
contact: {{ground: false}}
gravity: [0, 0, 0]
robots:
  - name: vehicle
    model: models/crazyflie/crazyflie.urdf
    rotor_speed: hover
    pose: {{position: [0, 0, 10]}}
    controllers: [{{plugin: rotor_speed, parameters: {{max_speed: {MAX_SPEED}}}}}]
effects:
  - plugin: battery
    parameters: {{cells: 1, capacity: {CAPACITY}, efficiency: {EFFICIENCY}, speed_per_volt: 5000}}
  - {{plugin: body_drag, parameters: {{linear: [1, 1, 1]}}}}
task: {{plugin: watch, parameters: {{link: base_link}}}}
"""


@dataclass(frozen=True)
class Case:
    """One flight by the pack that was fitted on the others."""

    name: str
    time: Reals
    measured: Reals  # [V]
    ours: Reals  # [V]
    resistance: float  # [ohm]
    sag: float  # measured, from rest to the mean in flight [V]

    @property
    def error(self) -> float:
        """RMS of the voltage [V]."""
        return float(np.sqrt(np.mean((self.ours - self.measured) ** 2)))

    @property
    def facts(self) -> dict[str, object]:
        """The figures without the series."""
        names = ("name", "resistance", "sag", "error")
        return {name: getattr(self, name) for name in names}


@dataclass(frozen=True)
class Replay:
    """A flight's voltages: measured, and of all candidates."""

    flight: Recorded
    time: Reals
    measured: Reals  # (samples,)
    ours: Reals  # (samples, candidates)


def cases(flights: Sequence[Recorded]) -> list[Case]:
    """Each flight by the candidate with the least error on the others."""
    replays = [replay(flight, RESISTANCES) for flight in flights]
    made = []
    for own in replays:
        others = [other for other in replays if other is not own]
        if not others:
            continue
        squares = [((r.ours - r.measured[:, None]) ** 2).mean(axis=0) for r in others]
        best = int(np.argmin(np.mean(squares, axis=0)))
        sag = float(own.flight.voltage[0] - own.measured.mean())
        voltages_of_best, resistance = own.ours[:, best], float(RESISTANCES[best])
        name = own.flight.name
        made.append(Case(name, own.time, own.measured, voltages_of_best, resistance, sag))
    return made


def replay(flight: Recorded, candidates: Reals) -> Replay:
    """Flies the recorded speeds with all candidates; the pack begins at the voltage at rest."""
    end = end_of(flight)
    times = np.arange(flight.time[0], end, STEP)
    speeds = curves.speed(flight.pwm)
    commands = np.stack([np.interp(times, flight.time, column) for column in speeds.T], axis=1)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "battery.yaml"
        file.write_text(SCENARIO, encoding="utf-8")
        compiled = CompiledScenario(file)
    charge = float(np.interp(flight.voltage[0], CELL, np.linspace(0.0, 1.0, len(CELL))))
    made = voltages(compiled, candidates, charge, commands[:, order_of(compiled)])
    turning = commands.mean(axis=1) > 0.5 * commands.mean()
    first = times[np.argmax(turning)] + SETTLE
    last = times[len(turning) - 1 - np.argmax(turning[::-1])]
    used = (times > first) & (times < last)
    measured = np.interp(times, flight.time, flight.voltage)
    return Replay(flight, times[used], measured[used], made[used])


def voltages(
    compiled: CompiledScenario, candidates: Reals, charge: float, commands: Reals
) -> Reals:
    """Voltages of the engine's packs [V], (steps, candidates).

    Args:
        candidates: resistances [ohm].
        charge: at the start.
        commands: rotor speeds in each step [rad/s], (steps, rotors).
    """
    actions = (2.0 * commands / MAX_SPEED - 1.0).clip(-1.0, 1.0).astype(np.float32)
    made = []
    with Pool(compiled, len(candidates), order="fixed") as pool:
        for env, resistance in enumerate(candidates):
            pool.set_param(env, "effects.battery.internal_resistance", resistance)
            pool.set_param(env, "effects.battery.initial_charge", charge)
        pool.reset()
        for row in actions:
            infos = pool.step(np.tile(row, (len(candidates), 1)))[-1]
            made.append(np.array(infos["battery.voltage"], np.float64).ravel())
    return np.array(made)


def end_of(flight: Recorded) -> float:
    """The time from which commands are impossible, or the end [s]."""
    wrong = faults_of(flight)["impossible"]
    return float(flight.time[np.argmax(wrong)] - 0.5 if wrong.any() else flight.time[-1])
