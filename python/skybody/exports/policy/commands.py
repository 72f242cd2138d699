"""Names, units and frames of the values of commands (docs/control-modes.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from skybody import CompiledScenario
from skybody._native import ActionChannel

AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Value:
    """One value of a command."""

    name: str
    unit: str  # SI; empty: a pure number
    meaning: str  # with its frame


def _vector(name: str, unit: str, meaning: str, axes: Sequence[str] = AXES) -> list[Value]:
    return [Value(f"{name}_{axis}", unit, f"{meaning}, {axis}") for axis in axes]


THRUST = Value("thrust", "N", "collective thrust along z of B")
YAW = Value("yaw", "rad", "yaw about z of W")
RATES = _vector("rate", "rad/s", "angular velocity, B")
ATTITUDE = _vector("attitude", "", "quaternion, W from B", ("w", "x", "y", "z"))
POSITION = _vector("position", "m", "position, W")
FIXED = {
    "ctbt": [THRUST, *_vector("torque", "N m", "torque, B")],
    "ctbr": [THRUST, *RATES],
    "velocity": [*_vector("velocity", "m/s", "velocity, B"), *RATES],
    "pose": [*POSITION, *ATTITUDE],
    "attitude": [THRUST, *ATTITUDE, *RATES],
    "position": [*POSITION, YAW],
    "force": [*_vector("force", "N", "total force of the rotors, W"), YAW],
    "acceleration": [*_vector("acceleration", "m/s^2", "acceleration, W"), YAW],
    "velocity_tracking": [
        *_vector("velocity", "m/s", "velocity, W"),
        Value("yaw_rate", "rad/s", "rate of yaw about z of W"),
    ],
}
PER_ROTOR = {
    "rotor_speed": ("rad/s", "speed of rotor"),
    "srt": ("N", "thrust along the axis of rotor"),
    "throttle": ("", "share of the largest speed of rotor"),
}


def values_of(compiled: CompiledScenario, channel: ActionChannel) -> list[Value]:
    """The values of a part of the action, in order."""
    robot = compiled.robots[channel.robot]
    if channel.name in PER_ROTOR:
        unit, meaning = PER_ROTOR[channel.name]
        names = [
            r.name.partition(".")[2] for r in compiled.rotors if r.name.startswith(f"{robot}.")
        ]
        if len(names) == channel.count:
            return [Value(name, unit, f"{meaning} `{name}`") for name in names]
    if channel.name in FIXED and channel.count <= len(FIXED[channel.name]):
        return FIXED[channel.name][: channel.count]
    if channel.name == "wrench":
        site = [*_vector("force", "N", "force, W"), *_vector("moment", "N m", "moment, W")]
        sites = channel.count // len(site)
        return site if sites == 1 else [_of_site(v, k) for k in range(sites) for v in site]
    meaning = f"value of `{channel.name}` (docs/control-modes.md)"
    return [Value(f"{channel.name}_{k}", channel.unit, meaning) for k in range(channel.count)]


def _of_site(value: Value, site: int) -> Value:
    return Value(f"site{site}_{value.name}", value.unit, f"{value.meaning}, site {site}")
