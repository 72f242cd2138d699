"""The vehicle to tune, and the small scenario in which it flies."""

from __future__ import annotations

import json
import os
import re
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

from skybody._native import CompiledScenario, InputError

ROBOT = "vehicle"
START = (0.0, 0.0, 1.5)  # [m] within the default box of `position`
COMMAND_PERIOD = 0.01  # [s]
LATENCY = "latency_of_tuning"  # name of the delay behind the chain

DEFAULT_CHAIN = "position,attitude,ctbr"


class TuneError(ValueError):
    """A mistake that the user can correct."""


@dataclass(frozen=True)
class Vehicle:
    """A URDF with rotors and a chain of controllers."""

    model: str
    """URDF file, or the name of a shipped model."""
    rotors: str = ""
    """Rotors file; empty: rotors.yaml beside the URDF."""
    chain: str = DEFAULT_CHAIN
    """Names of controllers with commas between them, or a list as in a scenario's YAML."""
    dt: float = 0.001
    """Physics step [s]."""
    latency: float = 0.004
    """[s] between the last controller and the rotors."""
    plugin_path: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of the model, for files and titles."""
        return Path(self.model).stem

    def controllers(self) -> str:
        """The chain as a YAML list, without the latency."""
        chain = self.chain.strip()
        if chain.startswith("["):
            return chain
        names = [name.strip() for name in chain.split(",")]
        for name in names:
            if not re.fullmatch(r"[A-Za-z_]\w*", name):
                raise TuneError(
                    f"--chain is {self.chain!r}; it must be names of controllers with commas "
                    f"between them ({DEFAULT_CHAIN}), or a list as in YAML: [{{plugin: position, "
                    "parameters: {...}}, ...]"
                )
        return "[" + ", ".join(f"{{plugin: {name}}}" for name in names) + "]"

    def compile(self, latency: float | None = None) -> CompiledScenario:
        """The scenario, ready to step.

        Args:
            latency: in place of the vehicle's own [s].

        Raises:
            TuneError: an invalid file, controller or number, with every message.
        """
        delay = self.latency if latency is None else latency
        for option, file in (("", self.model), ("--rotors ", self.rotors)):
            is_file = option != "" or "/" in file or file.endswith((".urdf", ".xml"))
            if is_file and os.path.isdir(file):
                raise TuneError(f"{option}{file}: a folder; give a file in it")
            if file and is_file and not os.path.isfile(file):
                raise TuneError(f"{option}{file}: no such file")
        if self.model.endswith((".yaml", ".yml")):
            raise TuneError(
                f"{self.model}: a YAML file; `skybody tune` takes a robot's URDF, or the name of a "
                "shipped model such as `qdrone2`"
            )
        # The task `hover` needs no link name. It gives the name for `watch`, which ends no episode.
        learned = self._load("{plugin: hover}", delay)
        link = _base_link(learned)
        return self._load(f"{{plugin: watch, parameters: {{link: {json.dumps(link)}}}}}", delay)

    def _load(self, task: str, latency: float) -> CompiledScenario:
        with tempfile.TemporaryDirectory(prefix="skybody-tune-") as folder:
            file = Path(folder) / "tune.yaml"
            file.write_text(self._text(task, latency), encoding="utf-8")
            try:
                return CompiledScenario(str(file), plugin_path=list(self.plugin_path))
            except InputError as error:
                raise TuneError(self._translated(str(error), str(file))) from error

    def _translated(self, message: str, file: str) -> str:
        """Rewrites messages about the small scenario in terms of the command line."""
        if " has no rotors; " in message:
            return (
                f"{self.model} has no rotors file: give one by --rotors FILE (docs/rotors.md), or "
                "put it beside the URDF as rotors.yaml"
            )
        place = re.escape(file) + r"(:\d+){0,2}"
        told = re.sub(place, f"{self.model}, --chain {self.chain}", message)
        return told.replace(os.path.dirname(file) + "/", "")

    def _text(self, task: str, latency: float) -> str:
        repeat = max(1, round(COMMAND_PERIOD / self.dt))
        lines = [
            "name: tune",
            f"stepping: {{dt: {self.dt!r}, action_repeat: {repeat}}}",
            "contact: {ground: false}",
            "robots:",
            f"  - name: {ROBOT}",
            f"    model: {json.dumps(_absolute(self.model))}",
        ]
        if self.rotors:
            lines.append(f"    rotors: {json.dumps(_absolute(self.rotors))}")
        lines += [
            f"    pose: {{position: [{', '.join(map(repr, START))}]}}",
            "    rotor_speed: hover",
            f"    controllers: {self._with_delay(latency)}",
            "effects: [{plugin: wind}]",
            f"task: {task}",
        ]
        return "\n".join(lines) + "\n"

    def _with_delay(self, latency: float) -> str:
        """The chain with a latency before the rotors."""
        chain = self.controllers()
        if latency <= 0.0:
            return chain
        parameters = f"{{signal: rotor_speed, latency: {latency!r}}}"
        delay = f"{{plugin: delay, name: {LATENCY}, parameters: {parameters}}}"
        return chain.rstrip()[:-1] + ", " + delay + "]"


@dataclass(frozen=True)
class Use:
    """A controller of the chain as given by the user."""

    plugin: str
    name: str
    parameters: dict[str, str]
    """Values as YAML."""


def uses_of(compiled: CompiledScenario) -> list[Use]:
    """The chain's controllers, without the latency behind them.

    Reads the merged scenario, in which every key is on its own line.
    """
    uses: list[Use] = []
    text = compiled.scenario_text.split("    controllers:\n")[1]
    for line in text.splitlines():
        if not line.startswith("      "):
            break
        key, _, value = line.strip().removeprefix("- ").partition(": ")
        if line.startswith("      - "):
            uses.append(Use("", "", {}))
        if key == "plugin":
            uses[-1] = replace(uses[-1], plugin=value.strip('"'))
        elif key == "name":
            uses[-1] = replace(uses[-1], name=value.strip('"'))
        elif not line.endswith(":"):
            uses[-1].parameters[key] = value
    named = [use if use.name else replace(use, name=use.plugin) for use in uses]
    return [use for use in named if use.name != LATENCY]


def entries_of(uses: list[Use], gains: dict[str, dict[str, list[float]]]) -> list[str]:
    """The controllers as YAML, one string each, with the given gains (controller, parameter)."""
    entries = []
    for use in uses:
        parts = [f"plugin: {use.plugin}"]
        if use.name != use.plugin:
            parts.append(f"name: {use.name}")
        parameters = dict(use.parameters)
        for name, values in gains.get(use.name, {}).items():
            numbers = [f"{value:g}" for value in values]
            parameters[name] = numbers[0] if len(numbers) == 1 else f"[{', '.join(numbers)}]"
        if parameters:
            inner = ", ".join(f"{name}: {value}" for name, value in parameters.items())
            parts.append(f"parameters: {{{inner}}}")
        entries.append("{" + ", ".join(parts) + "}")
    return entries


def _absolute(path: str) -> str:
    """Absolute path of a file; a model's name is unchanged."""
    return os.path.abspath(path) if os.path.exists(path) else path


def _base_link(compiled: CompiledScenario) -> str:
    for path in compiled.param_paths:
        if found := re.fullmatch(rf"robots\.{ROBOT}\.links\.(.+)\.mass", path):
            return found[1]
    raise TuneError("the vehicle has no body whose mass could be drawn")
