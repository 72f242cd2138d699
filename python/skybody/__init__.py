"""Skybody: a drone-learning simulator, from Python.

* `make_vec`: many environments as a Gymnasium vector environment (`skybody.vector`).
* `make_pool` (`Pool`): the asynchronous form (send, recv).
* `Simulation` and `SimulationPool`: environments under direct control.
* `DifferentiableEnv`: transitions with derivatives, for gradients through the dynamics.
* `skybody.sb3`: Stable-Baselines3. `skybody.multi_agent`: PettingZoo.
* `skybody.env`: single Gymnasium environments. `skybody.python_task`: tasks written in Python.

`gymnasium.make` and `gymnasium.make_vec` accept the shipped scenarios as `skybody/Hover-v0` and so
on. The submodules above are imported at their first use.
"""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Any

from .native_problem import native_problem, refuse, version_problem

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
        FlightPolicy,
        InputError,
        MassProperties,
        ObservationColumn,
        Snapshot,
        built_for,
        versions,
    )
except ImportError as error:
    refuse(native_problem(error))
from .differentiable import DifferentiableEnv
from .extras import EXTRAS, missing_package
from .pool import Pool
from .registration import register
from .simulation import CONTROL_MODES, EnvStates, Simulation, SimulationPool

if TYPE_CHECKING:
    from .vector import SkybodyVectorEnv as make_vec

__version__ = versions()["skybody"]

_program = os.environ.get("SKYBODY_PROGRAM_VERSION", __version__)  # set where the program runs us
if _problem := version_problem(package=built_for, library=__version__, program=_program):
    refuse(_problem)
os.environ.pop("SKYBODY_PROGRAM_VERSION", None)  # programs that we start may have another package

__all__ = [
    "CONTROL_MODES",
    "Accelerations",
    "ActionChannel",
    "Batch",
    "BodyState",
    "Channel",
    "CompiledScenario",
    "Contact",
    "DifferentiableEnv",
    "EnvStates",
    "Error",
    "FlightPolicy",
    "InputError",
    "MassProperties",
    "ObservationColumn",
    "Pool",
    "Simulation",
    "SimulationPool",
    "Snapshot",
    "__version__",
    "make_pool",
    "make_vec",
    "register",
    "versions",
]

make_pool = Pool

_MODULES = tuple(EXTRAS)  # imported at their first use


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return _import(name)
    if name == "make_vec":  # importing Gymnasium takes longer than the rest
        return _import("vector").SkybodyVectorEnv
    raise AttributeError(f"module 'skybody' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_MODULES, "make_vec"])


def _import(name: str) -> Any:
    try:
        return importlib.import_module(f".{name}", __name__)
    except ModuleNotFoundError as error:
        if (error.name or "").startswith(__name__):
            raise
        raise missing_package(name, error) from error


register()
