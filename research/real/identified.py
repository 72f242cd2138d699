"""A vehicle from a folder of `skybody identify`: its model, its law of commands, its offsets."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from skybody import CompiledScenario, InputError
from skybody.identify.rotation import inverse, of_vector, product

from research.real.engine import DT, fly
from research.real.log_detail import damped
from research.real.recorded_flights import MOST_PWM, Reals, Recorded
from research.real.windows import Windows

LEAST_DELAY = 0.002  # that the scenario has, as in skybody.identify [s]


SCENARIO = f"""
name: identified
stepping: {{{{dt: {DT}, action_repeat: 1}}}}
contact: {{{{ground: false}}}}
robots:
  - name: vehicle
    model: {{model}}
    pose: {{{{position: [0, 0, 10]}}}}
    rotor_speed: hover
    controllers: [{{delay}}{{{{plugin: rotor_speed}}}}]
task: {{{{plugin: hover}}}}
{{effects}}
"""


class Identified:
    """An identified vehicle.

    Besides the vehicle its report has the part of the differences between rotors' commands that a
    log with gaps tells (`log.detail`, log_detail.py), the turn between the axes of
    the motion capture and of the body, and the bias of the gyroscope. Turn and bias are applied to
    starts, and taken back from predictions.

    Args:
        folder: of `skybody identify`, with vehicle.urdf, effects.yaml and report.json.

    Raises:
        InputError: the folder is not usable.
    """

    inputs = "rotor speeds by its own law of PWM and voltage"
    trims = False
    is_damped = False

    def __init__(self, folder: Path) -> None:
        for name in ("report.json", "vehicle.urdf", "effects.yaml"):
            if not (folder / name).is_file():
                raise InputError(f"{folder}: has no {name}; `skybody identify` writes it")
        report = folder / "report.json"
        self._report: dict[str, Any] = json.loads(report.read_text(encoding="utf-8"))
        self.title = f"Skybody, identified `{Path(self._report['model']).stem}`"
        self.compiled = self._compiled(folder)

    def _compiled(self, folder: Path) -> CompiledScenario:
        """The vehicle under rotor speeds, without ground: its model, effects and delay."""
        delay = self.value("delay.command")
        latency = f"{{plugin: delay, parameters: {{signal: rotor_speed, latency: {delay}}}}}, "
        text = SCENARIO.format(
            model=json.dumps(str((folder / "vehicle.urdf").resolve())),
            delay=latency if delay >= LEAST_DELAY else "",
            effects=(folder / "effects.yaml").read_text(encoding="utf-8"),
        )
        with tempfile.TemporaryDirectory() as name:
            file = Path(name) / "identified.yaml"
            file.write_text(text, encoding="utf-8")
            return CompiledScenario(file)

    @property
    def detail(self) -> float | None:
        """Part of the differences between rotors' commands; None: the log has all commands."""
        return self.value("log.detail") if "log.detail" in self._report["parameters"] else None

    def value(self, name: str, default: float = 0.0) -> float:
        """An identified value; `default`: it is not among the parameters."""
        found = self._report["parameters"].get(name)
        return default if found is None else float(found["value"])

    def takes(self, flight: Recorded) -> bool:
        """Whether the voltage is known if it counts, and the flight is no part of the fit."""
        used = {Path(name).name.partition(".")[0] for name in self._report["flights"]}
        needs_voltage = self.value("command.voltage") != 0.0
        return flight.name not in used and (
            not needs_voltage or bool(np.isfinite(flight.voltage).all())
        )

    def commands(self, windows: Windows, factors: Reals) -> Reals:
        """Rotor speeds [rad/s] on the grid; as Model.commands."""
        flight = windows.flight if self.detail is None else damped(windows.flight, self.detail)
        share = np.clip(flight.pwm, 0.0, MOST_PWM) / MOST_PWM
        return windows.on_grid(self.speeds(share, flight.voltage))

    def speeds(self, share: Reals, voltage: Reals) -> Reals:
        """Rotor speeds [rad/s] of shares (rows, rotors) at voltages (rows,)."""
        exponent = self.value("command.voltage")
        if exponent != 0.0:
            share = share * (voltage[:, None] / self._report["mean_voltage"]) ** exponent
        x = share / self._report["mean_command"] - 1.0
        law = 1.0 + self.value("command.slope") * x + self.value("command.curve") * x * x
        return np.asarray(self.value("command.speed") * np.maximum(law, 0.0))

    def thrusts(self, flight: Recorded) -> Reals:
        """Not needed: it is not trimmed."""
        raise NotImplementedError("an identified vehicle is not trimmed")

    def fly(self, starts: Reals, commands: Reals) -> Reals:
        """As Model.fly; starts and states are those that the sensors would tell."""
        tilt = of_vector(np.array([self.value(f"pose.tilt_{axis}") for axis in "xyz"]))
        bias = np.array([self.value(f"gyro.bias_{axis}") for axis in "xyz"])
        own = starts.copy()
        own[:, 3:7] = product(starts[:, 3:7], inverse(tilt))
        own[:, 10:] -= bias
        states = fly(self.compiled, own, commands, {})
        states[..., 3:7] = product(states[..., 3:7], tilt)
        states[..., 10:] += bias
        return states
