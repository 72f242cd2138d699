"""The scenario of an imported flight: the models of its robots, so that they can be drawn."""

from __future__ import annotations

import re
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skybody import CompiledScenario, InputError, Simulation
from skybody._native import scenario_file
from skybody.look.flight import Array

from .map_file import Map, Robot

MOST_URDF_BYTES = 16 << 20


@dataclass(frozen=True)
class World:
    """A scenario, and the names of the bodies and rotors in it."""

    name: str
    file: Path  # its place, for relative paths; there is no such file
    compiled: CompiledScenario
    bodies: tuple[str, ...]  # ROBOT.LINK, one of each robot, in the order of the map

    def rotors(self, robot: str) -> list[str]:
        """Names of a robot's rotors."""
        names = [rotor.name for rotor in self.compiled.rotors]
        return [n.partition(".")[2] for n in names if n.startswith(f"{robot}.")]

    def greatest_speeds(self, robot: str) -> Array:
        """Of a robot's rotors [rad/s]."""
        paths = [f"robots.{robot}.rotors[{k}].max_speed" for k in range(len(self.rotors(robot)))]
        return np.array([self.compiled.param_info(path)[0] for path in paths])


def world_of(used: Map, name: str, starts: Mapping[str, Array]) -> World:
    """Makes the scenario of a map.

    Args:
        used: the map.
        name: of the flight.
        starts: position of each robot at the start, W [m].

    Raises:
        InputError: a model cannot be used, or has several bodies.
    """
    clean = re.sub(r"\W", "_", name, flags=re.ASCII)
    text = scenario_text(used, clean, starts)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{clean}.yaml"
        file.write_text(text)
        try:
            compiled = CompiledScenario(file)
        except InputError as error:
            problem = str(error).replace(str(file), str(used.file)).splitlines()[0]
            raise InputError(f"the models of the map cannot be used: {problem}") from None
    bodies = tuple(Simulation(compiled).body_names)
    for robot in used.robots:
        own = [body for body in bodies if body.startswith(f"{robot.name}.")]
        if len(own) != 1:
            raise InputError(
                f"{used.file}: robots.{robot.name}.model: {robot.model} has {len(own)} bodies; "
                "allowed: one, since one pose was recorded; give each body as a robot"
            )
    return World(clean, used.file.resolve().parent / file.name, compiled, bodies)


def scenario_text(used: Map, name: str, starts: Mapping[str, Array]) -> str:
    """The scenario in YAML."""
    import yaml

    first = used.robots[0]
    link = root_link(used, first)
    content = {
        "name": name,
        "robots": [entry_of(used, robot, starts.get(robot.name)) for robot in used.robots],
        "obstacles": used.obstacles,
        "task": {"plugin": "watch", "parameters": {"robot": first.name, "link": link}},
    }
    return str(yaml.safe_dump({k: v for k, v in content.items() if v is not None}, sort_keys=False))


def entry_of(used: Map, robot: Robot, start: Array | None) -> dict[str, object]:
    """A robot of the scenario, at its start."""
    place = [0.0, 0.0, 0.0] if start is None else [round(float(x), 6) for x in start]
    entry: dict[str, object] = {"name": robot.name, "model": local_path(used, robot.model)}
    if robot.rotors_file:
        entry["rotors"] = local_path(used, robot.rotors_file)
    return entry | {"pose": {"position": place}}


def local_path(used: Map, name: str) -> str:
    """The path of a file beside the map, or the name of a shipped one."""
    beside = used.file.resolve().parent / name
    return str(beside) if beside.exists() else name


def root_link(used: Map, robot: Robot) -> str:
    """Name of the link of a model that has no parent.

    Raises:
        InputError: the model cannot be read.
    """
    place = f"{used.file}: robots.{robot.name}.model"
    file = model_file(used, robot.model)
    if file is None:
        raise InputError(f"{place}: no file `{robot.model}`; give a URDF, here or by --model")
    try:
        if file.stat().st_size > MOST_URDF_BYTES:
            raise InputError(f"{place}: {file} has more than {MOST_URDF_BYTES} bytes")
        root = ElementTree.parse(file).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise InputError(f"{place}: {file} cannot be read as a URDF ({error})") from None
    children = {child.get("link") for child in root.iterfind("joint/child")}
    for link in root.iterfind("link"):
        if (name := link.get("name")) and name not in children:
            return name
    raise InputError(f"{place}: {file} has no link without a parent")


def model_file(used: Map, name: str) -> Path | None:
    """The file of a model: beside the map, or shipped."""
    shipped = Path(scenario_file("hover")).parents
    folders = [used.file.resolve().parent, *shipped]
    return next((f / name for f in folders if (f / name).is_file()), None)
