"""map.yaml: which observations are the inputs of an ONNX policy.

inputs:
  obs: [position_error, velocity, "attitude[1,2,3,0]"]   # quaternion x y z w
  camera: front.depth
output: actions
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from skybody import CompiledScenario, InputError
from skybody._native import ObservationColumn

ENTRY = re.compile(r"([^\[\]]+)(?:\[([\d, ]+)\])?")


@dataclass(frozen=True)
class Map:
    """A map; empty: names of inputs are those of columns."""

    file: str = ""
    inputs: dict[str, list[str]] = field(default_factory=dict)  # columns, with chosen entries
    output: str = ""


def read_map(path: Path) -> Map:
    """Reads a map.

    Raises:
        InputError: the package yaml is missing, or the file is no map.
    """
    try:
        import yaml
    except ModuleNotFoundError:
        raise InputError("--map needs `yaml`: `pip install PyYAML`") from None
    try:
        values = yaml.safe_load(path.read_text())
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = "" if mark is None else f":{mark.line + 1}:{mark.column + 1}"
        raise InputError(f"{path}{place}: is no YAML: {error.problem}") from None
    except (yaml.YAMLError, UnicodeDecodeError):
        raise InputError(f"{path}: is no YAML file") from None
    if not isinstance(values, dict) or set(values) - {"inputs", "output"}:
        raise InputError(f"{path}: must have the keys `inputs` and `output` alone")
    inputs = values.get("inputs") or {}
    output = values.get("output") or ""
    if not isinstance(inputs, dict) or not isinstance(output, str):
        raise InputError(f"{path}: `inputs` must be a map, `output` a name")
    return Map(str(path), {str(name): _names(path, name, v) for name, v in inputs.items()}, output)


def _names(path: Path, name: Any, value: Any) -> list[str]:
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list) or not all(isinstance(entry, str) for entry in names):
        raise InputError(f"{path}: `inputs.{name}` must be a column, or a list of columns")
    return names


def places_of(
    names: Iterable[str], compiled: CompiledScenario, file: str
) -> list[int] | ObservationColumn:
    """Entries of the observation, or the column of an image.

    Raises:
        InputError: no such column, or entries that it lacks.
    """
    columns = {c.name: c for c in compiled.observation_columns if not c.privileged}
    places: list[int] = []
    for text in names:
        found = ENTRY.fullmatch(text)
        column = columns.get(found[1].strip()) if found else None
        if found is None or column is None:
            raise InputError(
                f"{file}: `{compiled.name}` observes no `{text}`; there are {', '.join(columns)}"
            )
        if column.image >= 0:
            return column
        chosen = range(column.shape[0])
        entries = [int(word) for word in found[2].split(",")] if found[2] else list(chosen)
        if not all(entry in chosen for entry in entries):
            raise InputError(f"{file}: `{text}`: `{column.name}` has {column.shape[0]} values")
        places += [column.first + entry for entry in entries]
    return places
