"""The parameters of the identification, and their meaning for the engine and the sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from skybody.look.flight import Array

from .record import SHARE, CommandLaw
from .vehicle import Vehicle

LOG, LINEAR = "log", "linear"
ENGINE, COMMAND, SENSOR = "engine", "command", "sensor"  # places in which a parameter acts
AXES = "xyz"
FLAT = 0.99  # most moment of inertia about z, over the sum of the others; 1: a flat plate


@dataclass(frozen=True)
class Parameter:
    """One number to identify. Its coordinate is ln(value / nominal), or value - nominal."""

    name: str
    unit: str
    nominal: float
    prior: float
    """Standard deviation of the coordinate before any data."""
    place: str
    form: str = LINEAR
    low: float = -np.inf
    high: float = np.inf

    def value(self, coordinate: Any) -> Any:
        """Value of a coordinate, or of many."""
        if self.form == LOG:
            return self.nominal * np.exp(coordinate)
        return self.nominal + coordinate

    def slope(self, coordinate: float) -> float:
        """Derivative of the value by the coordinate."""
        return float(self.value(coordinate)) if self.form == LOG else 1.0

    def coordinate(self, value: float) -> float:
        """Coordinate of a value."""
        return float(np.log(value / self.nominal)) if self.form == LOG else value - self.nominal

    @property
    def bounds(self) -> tuple[float, float]:
        """Of the coordinate."""
        if self.form == LOG:
            return -8.0 * self.prior, 8.0 * self.prior
        return self.low - self.nominal, self.high - self.nominal


@dataclass(frozen=True)
class Scales:
    """Typical values of the flights."""

    share: float  # mean command
    voltage: float  # mean [V]
    law: CommandLaw

    @property
    def is_share(self) -> bool:
        """Whether commands are shares, whose speeds are to be found."""
        return self.law.kind == SHARE


def parameters_of(vehicle: Vehicle, scales: Scales, has: Mapping[str, bool]) -> list[Parameter]:
    """All parameters that the flights could tell.

    Args:
        vehicle: the nominal one.
        scales: of the flights.
        has: whether there are `voltage`, `gyro`, `force`, `pose`; `detail`: the log lacks commands,
            so that the differences between the rotors tell little.
    """
    return [
        *command_parameters(vehicle, scales, has),
        *(body_parameters(vehicle) if not has["detail"] else []),
        *drag_parameters(vehicle, has),
        *sensor_parameters(has),
    ]


def command_parameters(
    vehicle: Vehicle, scales: Scales, has: Mapping[str, bool]
) -> list[Parameter]:
    """From commands to thrust."""
    made: list[Parameter] = []
    if scales.is_share:
        speed, slope, curve = nominal_law(scales)
        made += [
            Parameter("command.speed", "rad/s", speed, 0.7, COMMAND, LOG),
            Parameter("command.slope", "", slope, 0.5, COMMAND, low=0.0, high=4.0),
            Parameter("command.curve", "", curve, 0.5, COMMAND),
        ]
        if has["voltage"]:
            made.append(Parameter("command.voltage", "", 0.0, 0.7, COMMAND, low=-2.0, high=4.0))
    else:
        k_f = vehicle.rotor("thrust_constant")
        made.append(Parameter("thrust_constant", "N s^2/rad^2", k_f, 0.7, ENGINE, LOG))
    for name, least in (("tau_up", 0.02), ("tau_down", 0.02)):
        nominal = max(vehicle.rotor(name), 1e-3) or least
        made.append(Parameter(name, "s", nominal, 1.0, ENGINE, LOG))
    made.append(Parameter("delay.command", "s", 0.0, 0.02, COMMAND, low=-0.1, high=0.2))
    if has["detail"]:
        made.append(Parameter("log.detail", "", 0.1, 0.5, COMMAND, low=0.0, high=1.0))
    else:
        made.append(Parameter("thrust_spread", "", 0.0, 0.05, ENGINE, low=-0.5, high=0.5))
    return made


def body_parameters(vehicle: Vehicle) -> list[Parameter]:
    """Parameters of the rigid body, and of the reaction to the rotors."""
    made = [
        Parameter(f"inertia.{a}", "kg m^2", vehicle.nominal[vehicle.path(f"inertia[{k}]")], p,
                  ENGINE, LOG)
        for k, (a, p) in enumerate(zip(AXES, (0.7, 0.7, 0.15), strict=True))
    ]  # fmt: skip
    made.append(
        Parameter("moment_constant", "N m s^2/rad^2", vehicle.rotor("moment_constant"), 0.7,
                  ENGINE, LOG)
    )  # fmt: skip
    if vehicle.rotor("inertia") > 0.0:
        made.append(
            Parameter("rotor_inertia", "kg m^2", vehicle.rotor("inertia"), 0.7, ENGINE, LOG)
        )
    for k, axis in enumerate(AXES):
        nominal = vehicle.nominal[vehicle.path(f"com[{k}]")]
        made.append(Parameter(f"com.{axis}", "m", nominal, 0.15 * vehicle.arm, ENGINE))
    return made


def drag_parameters(vehicle: Vehicle, has: Mapping[str, bool]) -> list[Parameter]:
    """Parameters of the drag.

    Without poses gravity and attitude tell how the velocity changes, and the accelerometer feels
    the rotors' drag; other drag stays unknown.
    """
    nominal = vehicle.rotor("drag_constant")
    if not has["pose"]:
        if not (has["gyro"] and has["force"] and nominal > 0.0):
            return []
        return [Parameter("drag.rotor", "N s^2/(m rad)", nominal, 0.7, ENGINE, LOG)]
    per_rotor = vehicle.mass / (len(vehicle.hubs) * vehicle.hover_speed)
    return [
        Parameter("drag.rotor", "N s^2/(m rad)", nominal, 0.3 * per_rotor, ENGINE, low=0.0),
        Parameter("drag.linear_z", "N s/m", 0.0, 0.3 * vehicle.mass, ENGINE, low=0.0),
        Parameter("drag.quadratic_xy", "N s^2/m^2", 0.0, 0.1 * vehicle.mass, ENGINE, low=0.0),
        Parameter("drag.quadratic_z", "N s^2/m^2", 0.0, 0.1 * vehicle.mass, ENGINE, low=0.0),
    ]  # fmt: skip


def sensor_parameters(has: Mapping[str, bool]) -> list[Parameter]:
    """Offsets and delays of the measurements."""
    made: list[Parameter] = []
    if has["pose"]:
        made += [Parameter(f"pose.tilt_{a}", "rad", 0.0, 0.03, SENSOR) for a in AXES]
    if has["pose"] and (has["gyro"] or has["force"]):
        made.append(Parameter("delay.imu", "s", 0.0, 0.02, SENSOR, low=-0.1, high=0.1))
    if has["gyro"]:
        made += [Parameter(f"gyro.bias_{a}", "rad/s", 0.0, 0.05, SENSOR) for a in AXES]
    if has["force"]:
        made += [Parameter(f"accelerometer.bias_{a}", "m/s^2", 0.0, 0.3, SENSOR) for a in AXES]
    return made


def nominal_law(scales: Scales) -> tuple[float, float, float]:
    """Speed, slope and curve of the map's law at the mean command."""
    x = np.linspace(-0.3, 0.3, 31)
    speeds = scales.law.nominal(np.clip(scales.share * (1.0 + x), 0.0, 1.0))
    curve, slope, speed = np.polyfit(x, speeds, 2)
    return float(speed), float(slope / speed), float(curve / speed)


class Model:
    """From values of the parameters to those of the engine, and to rotor speeds."""

    def __init__(self, vehicle: Vehicle, parameters: list[Parameter], scales: Scales) -> None:
        self.vehicle, self.parameters, self.scales = vehicle, parameters, scales
        self.names = [p.name for p in parameters]
        self.paths = self._paths()

    def values(self, coordinates: Array) -> dict[str, float]:
        """Values by name."""
        pairs = zip(self.parameters, coordinates, strict=True)
        return {p.name: float(p.value(x)) for p, x in pairs}

    def _paths(self) -> list[str]:
        vehicle, rotors = self.vehicle, range(len(self.vehicle.hubs))
        names = ("thrust_constant", "moment_constant", "drag_constant", "inertia", "tau_up",
                 "tau_down")  # fmt: skip
        paths = [vehicle.rotor_path(k, name) for name in names for k in rotors]
        paths += [vehicle.path("mass"), *(vehicle.path(f"com[{k}]") for k in range(3))]
        paths += [vehicle.path(f"inertia[{k}]") for k in range(6)]
        paths += [
            f"effects.body_drag.{kind}[{k}]" for kind in ("linear", "quadratic") for k in range(3)
        ]
        return paths

    def engine(self, values: Mapping[str, float]) -> dict[str, float]:
        """Values of the engine's parameters by path."""
        v = self.vehicle
        made = {path: v.nominal[path] for path in self.paths}
        self._set_rotors(made, values)
        for k, axis in enumerate(AXES):
            if f"com.{axis}" in values:
                made[v.path(f"com[{k}]")] = values[f"com.{axis}"]
        for k, value in enumerate(self.inertia(values)):
            made[v.path(f"inertia[{k}]")] = value
        drag = "effects.body_drag."
        made[f"{drag}linear[2]"] = values.get("drag.linear_z", 0.0)
        for k, name in enumerate(("xy", "xy", "z")):
            made[f"{drag}quadratic[{k}]"] = values.get(f"drag.quadratic_{name}", 0.0)
        return made

    def _set_rotors(self, made: dict[str, float], values: Mapping[str, float]) -> None:
        v = self.vehicle
        constants = {
            "thrust_constant": "thrust_constant", "moment_constant": "moment_constant",
            "drag.rotor": "drag_constant", "rotor_inertia": "inertia",
            "tau_up": "tau_up", "tau_down": "tau_down",
        }  # fmt: skip
        for k, turn in enumerate(v.directions):
            for name, key in constants.items():
                if name in values:
                    made[v.rotor_path(k, key)] = values[name]
            share = 1.0 + turn * values.get("thrust_spread", 0.0)
            made[v.rotor_path(k, "thrust_constant")] *= share
            made[v.rotor_path(k, "moment_constant")] *= share

    def inertia(self, values: Mapping[str, float]) -> list[float]:
        """xx yy zz xy xz yz [kg m^2].

        The yaw moments have no scale of their own: `inertia.z` is relative to the mean of x and y,
        and no body has more about z than about x and y together.
        """
        nominal = [self.vehicle.nominal[self.vehicle.path(f"inertia[{k}]")] for k in range(6)]
        if "inertia.x" not in values:
            return nominal
        x, y = (values[f"inertia.{a}"] / nominal[k] for k, a in enumerate("xy"))
        mean = float(np.sqrt(x * y))
        flat = FLAT * (nominal[0] * x + nominal[1] * y)
        found = [nominal[0] * x, nominal[1] * y, min(values["inertia.z"] * mean, flat)]
        return [*found, *(mean * p for p in nominal[3:])]

    def speeds(self, values: Mapping[str, float], command: Array, voltage: Array | None) -> Array:
        """Commanded speeds of rotors [rad/s] of commands (..., rotors), voltages (..., 1)."""
        if not self.scales.is_share:
            return command
        share = np.clip(command, 0.0, 1.0)
        if voltage is not None and "command.voltage" in values:
            share = share * (voltage / self.scales.voltage) ** values["command.voltage"]
        x = share / self.scales.share - 1.0
        factor = 1.0 + values["command.slope"] * x + values["command.curve"] * x * x
        return np.asarray(values["command.speed"] * np.maximum(factor, 0.0) * (command > 0.0))
