"""Skybody: learn to fly, from Python.

`make_vec` gives many environments as a Gymnasium vector environment, `make_pool` the asynchronous
form (send, recv), `Simulation` and `SimulationPool` environments under direct control.
`skybody.sb3` serves Stable-Baselines3, `skybody.multi_agent` PettingZoo, `skybody.env` single
Gymnasium environments, `skybody.python_task` tasks written in Python;
`gymnasium.make` and `gymnasium.make_vec` know the shipped scenarios as `skybody/Hover-v0` and so
on. All of them are imported when they are first used.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

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
from .pool import Order, Pool
from .registration import register
from .simulation import CONTROL_MODES, EnvStates, Simulation, SimulationPool

if TYPE_CHECKING:
    from gymnasium.vector import AutoresetMode

    from .pool import Autoreset
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
    "Simulation",
    "SimulationPool",
    "Snapshot",
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


def make_vec(
    scenario: Scenario,
    num_envs: int,
    *,
    num_threads: int = 0,
    seed: int = 0,
    order: Order = "fixed",
    autoreset: str | AutoresetMode = "next_step",
    overrides: Iterable[str] = (),
    plugin_path: Iterable[str | os.PathLike[str]] = (),
    joint: bool = False,
    dict_observations: bool = False,
    pin_threads: bool = False,
    keep_hash: bool = False,
    infos: bool = True,
    debug: bool = False,
) -> SkybodyVectorEnv:
    """Many environments of one scenario as a `gymnasium.vector.VectorEnv`.

    The arguments are those of `skybody.vector.SkybodyVectorEnv`, whose text says what they mean.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: a number is out of range, or an option's word is unknown.
        ImportError: Gymnasium is not installed.
    """
    vector: SkybodyVectorEnv = _import("vector").SkybodyVectorEnv(
        scenario,
        num_envs,
        num_threads=num_threads,
        seed=seed,
        order=order,
        autoreset=autoreset,
        overrides=overrides,
        plugin_path=plugin_path,
        joint=joint,
        dict_observations=dict_observations,
        pin_threads=pin_threads,
        keep_hash=keep_hash,
        infos=infos,
        debug=debug,
    )
    return vector


def make_pool(
    scenario: Scenario,
    num_envs: int,
    *,
    batch_size: int = 0,
    num_threads: int = 0,
    seed: int = 0,
    order: Order = "arrival",
    autoreset: Autoreset = "next_step",
    overrides: Iterable[str] = (),
    plugin_path: Iterable[str | os.PathLike[str]] = (),
    dict_observations: bool = False,
    pin_threads: bool = False,
    keep_hash: bool = False,
    infos: bool = True,
    debug: bool = False,
) -> Pool:
    """Many environments of one scenario, asynchronously: send, recv, batches of `batch_size`.

    The arguments are those of `skybody.Pool`, whose text says what they mean.

    Raises:
        skybody.InputError: every mistake in the scenario, each with file:line:column.
        ValueError: a number is out of range, or an option's word is unknown.
    """
    return Pool(
        scenario,
        num_envs,
        batch_size=batch_size,
        num_threads=num_threads,
        seed=seed,
        order=order,
        autoreset=autoreset,
        overrides=overrides,
        plugin_path=plugin_path,
        dict_observations=dict_observations,
        pin_threads=pin_threads,
        keep_hash=keep_hash,
        infos=infos,
        debug=debug,
    )


register()
