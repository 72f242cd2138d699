"""The nominal vehicle, and the small scenario in which its flights are replayed."""

from __future__ import annotations

import json
import os
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from skybody import InputError
from skybody._native import CompiledScenario
from skybody.look.flight import Array

ROBOT = "vehicle"
DT = 0.0025  # physics step of the replay [s]
ROOM = 4.0  # largest speed of the replay's rotors over the model's

ROTOR_VALUES = (
    "thrust_constant", "moment_constant", "drag_constant", "rolling_moment_constant", "inertia",
    "max_speed", "tau_up", "tau_down",
)  # fmt: skip


@dataclass(frozen=True)
class Hub:
    """A rotor of the model."""

    name: str
    position: tuple[float, ...]  # in the body's frame [m]
    axis: tuple[float, ...]
    direction: float  # +1 counter-clockwise


class Vehicle:
    """A model with one body and rotors that are alike."""

    def __init__(self, model: str, rotors: str = "", mass: float = 0.0) -> None:
        """Loads it.

        Args:
            model: URDF, or the name of a shipped model.
            rotors: rotors file; empty: rotors.yaml beside the URDF.
            mass: in place of the model's [kg]; 0: the model's.

        Raises:
            InputError: the files cannot be used, or the vehicle has several bodies or no rotors.
        """
        self.model = model if model.endswith((".urdf", ".xml")) else f"models/{model}/{model}.urdf"
        self.rotors_file = rotors
        compiled = self._load()
        self.link = self._base_link(compiled)
        self.nominal = {path: compiled.param_info(path)[0] for path in compiled.param_paths}
        if mass > 0.0:
            self._scale_mass(mass)
        self.hubs = tuple(
            Hub(r.name.partition(".")[2], tuple(r.position), tuple(r.axis), r.direction)
            for r in compiled.rotors
        )
        # The controller cuts commands at the model's largest speed: the replay has faster rotors.
        fast = {
            self.rotor_path(k, "max_speed"): ROOM * self.max_speed for k in range(len(self.hubs))
        }
        self.compiled = self._load(self.rotors_text({**self.nominal, **fast}))

    def _scale_mass(self, mass: float) -> None:
        factor = mass / self.mass
        self.nominal[self.path("mass")] = mass
        for k in range(6):
            self.nominal[self.path(f"inertia[{k}]")] *= factor

    # --- values ---------------------------------------------------------------------------------

    def path(self, name: str) -> str:
        """Path of a value of the body, such as `mass`."""
        return f"robots.{ROBOT}.links.{self.link}.{name}"

    @staticmethod
    def rotor_path(rotor: int, name: str) -> str:
        """Path of a constant of a rotor."""
        return f"robots.{ROBOT}.rotors[{rotor}].{name}"

    @property
    def name(self) -> str:
        """Name of the model."""
        return Path(self.model).stem

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.nominal[self.path("mass")]

    @property
    def gravity(self) -> float:
        """Magnitude of gravity [m/s^2]."""
        return float(np.linalg.norm(self.compiled.gravity))

    @property
    def rotor_names(self) -> list[str]:
        """Names of the rotors, in the order of the rotors file."""
        return [hub.name for hub in self.hubs]

    def rotor(self, name: str) -> float:
        """A constant of the first rotor."""
        return self.nominal[self.rotor_path(0, name)]

    @property
    def max_speed(self) -> float:
        """Largest speed of a rotor by the model [rad/s]."""
        return self.rotor("max_speed")

    @property
    def arm(self) -> float:
        """Mean distance of the hubs from the body's z axis [m]."""
        return float(np.mean([np.hypot(hub.position[0], hub.position[1]) for hub in self.hubs]))

    @property
    def hover_speed(self) -> float:
        """Speed of all rotors at which they carry the weight [rad/s]."""
        total = len(self.hubs) * self.rotor("thrust_constant")
        return float(np.sqrt(self.mass * self.gravity / total))

    @property
    def spin_by_mass(self) -> float:
        """Speeds of all rotors in hover over the mass [rad/(s kg)].

        Times the rotors' drag constant it is the specific force of their drag by speed [1/s].
        """
        return len(self.hubs) * self.hover_speed / self.mass

    @cached_property
    def directions(self) -> Array:
        """+1 or -1 of each rotor."""
        return np.array([hub.direction for hub in self.hubs])

    # --- files ----------------------------------------------------------------------------------

    def rotors_text(self, values: Mapping[str, float], source: str = "") -> str:
        """A rotors file.

        Args:
            values: constants of the rotors by path.
            source: of the constants, for the file.
        """
        lines = [f"source: {json.dumps(source)}"] if source else []
        lines.append("rotors:")
        for k, hub in enumerate(self.hubs):
            turn = "ccw" if hub.direction > 0.0 else "cw"
            lines += [
                f"  - name: {hub.name}",
                f"    position: {[float(f'{x:.6g}') for x in hub.position]}",
                f"    axis: {[float(f'{x:.6g}') for x in hub.axis]}",
                f"    direction: {turn}",
            ]
            lines += [f"    {n}: {values[self.rotor_path(k, n)]:.6g}" for n in ROTOR_VALUES]
        return "\n".join(lines) + "\n"

    def _text(self, rotors_file: str) -> str:
        lines = [
            "name: identify",
            f"stepping: {{dt: {DT!r}, action_repeat: 1}}",
            "contact: {ground: false}",
            "robots:",
            f"  - name: {ROBOT}",
            f"    model: {json.dumps(_absolute(self.model))}",
        ]
        if rotors_file:
            lines.append(f"    rotors: {json.dumps(_absolute(rotors_file))}")
        lines += [
            "    pose: {position: [0, 0, 1]}",
            "    rotor_speed: hover",
            "    controllers: [{plugin: rotor_speed}]",
            "effects: [{plugin: body_drag}]",
            "task: {plugin: hover}",
        ]
        return "\n".join(lines) + "\n"

    def _load(self, rotors_text: str = "") -> CompiledScenario:
        for option, name in (("--model ", self.model), ("--rotors ", self.rotors_file)):
            is_own = name and not name.startswith("models/")
            if is_own and not os.path.isfile(name):
                raise InputError(f"{option}{name}: no such file")
        with tempfile.TemporaryDirectory(prefix="skybody-identify-") as folder:
            file, rotors = Path(folder) / "identify.yaml", self.rotors_file
            if rotors_text:
                rotors = str(Path(folder) / "rotors.yaml")
                Path(rotors).write_text(rotors_text, encoding="utf-8")
            file.write_text(self._text(rotors), encoding="utf-8")
            try:
                return CompiledScenario(file)
            except InputError as error:
                first = str(error).splitlines()[0]
                told = re.sub(re.escape(str(file)) + r"(:\d+){0,2}(: error)?", self.model, first)
                raise InputError(told.replace(f"{folder}{os.sep}", "")) from None

    def _base_link(self, compiled: CompiledScenario) -> str:
        if not compiled.rotors:
            raise InputError(
                f"--model {self.model}: has no rotors; give --rotors FILE (docs/rotors.md), or put "
                "rotors.yaml beside the URDF"
            )
        if len(compiled.bodies) != 1:
            raise InputError(
                f"--model {self.model}: has {len(compiled.bodies)} bodies; allowed here: one"
            )
        return compiled.bodies[0].partition(".")[2]


def _absolute(path: str) -> str:
    """Absolute path of a file; a shipped model's name is unchanged."""
    return os.path.abspath(path) if os.path.exists(path) else path
