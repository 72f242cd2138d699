"""The fitted numbers: randomizable parameters of the chain's controllers."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skybody._native import CompiledScenario

from .vehicle import ROBOT, TuneError

LARGEST_FACTOR = 30.0  # maximum factor between a gain and its default


@dataclass(frozen=True)
class Gain:
    """Values of one parameter that are scaled together, such as those of roll and pitch."""

    controller: str
    parameter: str
    paths: tuple[str, ...]
    nominal: tuple[float, ...]
    low: float
    high: float

    @property
    def name(self) -> str:
        """`ctbr.kp`, or `ctbr.kp[2]` for one component."""
        first = re.search(r"\[\d+\]$", self.paths[0])
        return f"{self.controller}.{self.parameter}" + (first[0] if first else "")


@dataclass(frozen=True)
class Gains:
    """All gains of a chain. A point of the search is the logarithm of a factor for each gain."""

    groups: tuple[Gain, ...]

    def __len__(self) -> int:
        return len(self.groups)

    @property
    def paths(self) -> list[str]:
        return [path for gain in self.groups for path in gain.paths]

    def values(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of all paths, in their order, for a point (gains,)."""
        return np.array(
            [
                min(max(nominal * float(np.exp(x)), gain.low), gain.high)
                for gain, x in zip(self.groups, point, strict=True)
                for nominal in gain.nominal
            ]
        )

    def parameters(self, point: NDArray[np.float64]) -> dict[str, dict[str, list[float]]]:
        """Controller -> parameter -> values, to five digits, for files."""
        found: dict[str, dict[str, dict[int, float]]] = {}
        for path, value in zip(self.paths, self.values(point), strict=True):
            controller, parameter, index = _parts(path)
            found.setdefault(controller, {}).setdefault(parameter, {})[index] = float(
                f"{value:.5g}"
            )
        return {
            controller: {
                name: [values[k] for k in sorted(values)] for name, values in parameters.items()
            }
            for controller, parameters in found.items()
        }


def find_gains(compiled: CompiledScenario, fixed: Iterable[str] = ()) -> Gains:
    """The chain's randomizable parameters that are not 0.

    A parameter of 0 is switched off, and is not fitted. Of three values along x, y and z the first
    two are scaled together: a multirotor turns about x and y by the same rotors.

    Args:
        fixed: `controller.parameter` each, which are not fitted.

    Raises:
        TuneError: there are none, or `fixed` names an unknown one.
    """
    found: dict[tuple[str, str], list[str]] = {}
    for path in compiled.param_paths:
        if path.startswith(f"robots.{ROBOT}.controllers."):
            controller, parameter, _ = _parts(path)
            found.setdefault((controller, parameter), []).append(path)
    names = {f"{controller}.{parameter}" for controller, parameter in found}
    for name in fixed:
        if name not in names:
            raise TuneError(
                f"--fix {name}: the chain has no such gain; there are {', '.join(sorted(names))}"
            )
    groups = [
        group
        for (controller, parameter), paths in found.items()
        if f"{controller}.{parameter}" not in set(fixed)
        for group in _groups(compiled, controller, parameter, paths)
    ]
    if not groups:
        raise TuneError(
            "the chain has no gains to fit: no controller of it has randomizable parameters above "
            "0 that are not fixed; `skybody plugins --verbose` lists them"
        )
    return Gains(tuple(groups))


def _parts(path: str) -> tuple[str, str, int]:
    found = re.fullmatch(rf"robots\.{ROBOT}\.controllers\.(.+)\.(\w+?)(?:\[(\d+)\])?", path)
    assert found is not None, path
    return found[1], found[2], int(found[3] or 0)


def _groups(
    compiled: CompiledScenario, controller: str, parameter: str, paths: list[str]
) -> list[Gain]:
    parts = [paths[:2], paths[2:]] if len(paths) == 3 else [[path] for path in paths]
    groups = []
    for part in parts:
        infos = [compiled.param_info(path) for path in part]
        nominal = tuple(info[0] for info in infos)
        if all(value > 0.0 for value in nominal):
            low, high = infos[0][1:3]
            groups.append(Gain(controller, parameter, tuple(part), nominal, low, high))
    return groups
