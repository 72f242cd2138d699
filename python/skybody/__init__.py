"""Skybody: a drone-learning simulator, from Python.

* `make_vec`: many environments as a Gymnasium vector environment.
* `make_pool`: the asynchronous form (send, recv).
* `Simulation` and `SimulationPool`: environments under direct control.
* `skybody.sb3`: Stable-Baselines3. `skybody.multi_agent`: PettingZoo.
* `skybody.env`: single Gymnasium environments. `skybody.python_task`: tasks written in Python.

`gymnasium.make` and `gymnasium.make_vec` accept the shipped scenarios as `skybody/Hover-v0` and so
on. The submodules above are imported at their first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, Unpack

try:
    from ._native import (
        Accelerations,
        ActionChannel,
        Batch,
        BodyState,
        Channel,
        CompiledScenario,
        Contact,
        Error,
        InputError,
        MassProperties,
        ObservationColumn,
        Snapshot,
        versions,
    )
except ImportError as error:
    raise ImportError(
        f"skybody's native module is not built for this Python ({error}): run `./dev build` in "
        "Skybody's source tree and use .venv/bin/python, or install the package: `pip install .`"
    ) from error
from .arguments import Scenario
from .extras import INSTALLED_BY, missing_package
from .options import PoolOptions, VectorOptions, takes
from .pool import Pool
from .registration import register
from .simulation import CONTROL_MODES, EnvStates, Simulation, SimulationPool

if TYPE_CHECKING:
    from .vector import SkybodyVectorEnv

__version__ = versions()["skybody"]

__all__ = [
    "CONTROL_MODES",
    "Accelerations",
    "ActionChannel",
    "Batch",
    "BodyState",
    "Channel",
    "CompiledScenario",
    "Contact",
    "EnvStates",
    "Error",
    "InputError",
    "MassProperties",
    "ObservationColumn",
    "Pool",
    "PoolOptions",
    "Simulation",
    "SimulationPool",
    "Snapshot",
    "VectorOptions",
    "__version__",
    "make_pool",
    "make_vec",
    "register",
    "versions",
]

_MODULES = tuple(INSTALLED_BY)  # imported at their first use


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return _import(name)
    raise AttributeError(f"module 'skybody' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_MODULES])


def _import(name: str) -> Any:
    try:
        return importlib.import_module(f".{name}", __name__)
    except ModuleNotFoundError as error:
        if (error.name or "").startswith(__name__):
            raise
        raise missing_package(name, error) from error


@takes(VectorOptions)
def make_vec(
    scenario: Scenario,
    num_envs: int,
    **options: Unpack[VectorOptions],
) -> SkybodyVectorEnv:
    """Creates many environments of one scenario as a `gymnasium.vector.VectorEnv`.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `CompiledScenario`.
        num_envs: number of environments.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: a number is out of range, or the value of an option is unknown.
        ImportError: Gymnasium is not installed.
    """
    vector: SkybodyVectorEnv = _import("vector").SkybodyVectorEnv(scenario, num_envs, **options)
    return vector


@takes(PoolOptions)
def make_pool(
    scenario: Scenario,
    num_envs: int,
    **options: Unpack[PoolOptions],
) -> Pool:
    """Creates many environments of one scenario, stepped asynchronously by `send` and `recv`.

    `recv` returns batches of `batch_size` environments.

    Args:
        scenario: name of a shipped scenario, a YAML file, or a loaded `CompiledScenario`.
        num_envs: number of environments.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: a number is out of range, or the value of an option is unknown.
    """
    return Pool(scenario, num_envs, **options)


register()
