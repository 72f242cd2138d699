"""A trained policy with the scenario whose observations and actions it has."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

from skybody import CompiledScenario, InputError
from skybody._native import Error
from skybody.train.checkpoint import read_meta, resolve
from skybody.train.hyperparameters import UsageError
from skybody.train.policy_file import Policy, read_policy, shipped_policy

from .interface import Interface, identifier, interface_of

SHIPPED = "shipped"  # in place of a file


@dataclass(frozen=True)
class PolicySource:
    """A policy that is to be exported."""

    file: Path  # policy.h5
    policy: Policy
    compiled: CompiledScenario
    interface: Interface
    name: str  # a C identifier: prefix of functions and types, and the files' name


def open_policy(options: argparse.Namespace) -> PolicySource:
    """Opens the policy of the options.

    Raises:
        InputError: it cannot be read, its scenario is not found, or it does not fit it.
    """
    try:
        file, scenario, overrides = _file_and_scenario(options.source, options.scenario)
        policy = read_policy(file)
    except (ValueError, UsageError, Error, OSError) as error:
        raise InputError(str(error)) from None
    scenario = scenario or str(policy.attributes["scenario"])
    if not scenario:
        raise InputError(f"{file}: names no scenario: give --scenario NAME")
    compiled = _load(file, scenario, overrides)
    _check_fits(file, policy, compiled, options.scenario is not None)
    name = options.name or identifier(compiled.name)
    if not name.isidentifier() or identifier(name) != name:
        raise InputError(f"--name: `{name}` is no C identifier: use letters, digits and _")
    return PolicySource(file, policy, compiled, interface_of(policy, compiled), name)


def _file_and_scenario(source: str, scenario: str | None) -> tuple[Path, str | None, list[str]]:
    """The file, the scenario (None: not known) and its overrides."""
    if source == SHIPPED:
        if scenario is None:
            raise InputError("shipped: give --scenario NAME")
        name = CompiledScenario(scenario).name
        return shipped_policy(name, scenario), scenario, []
    path = Path(source)
    if not path.exists():
        raise InputError(f"{path}: neither a file nor a folder")
    if not path.is_dir():
        return path, scenario, []
    folder = path if (path / "policy.h5").exists() else resolve(path)
    if scenario is not None or not (folder / "meta.json").exists():
        return folder / "policy.h5", scenario, []
    meta = read_meta(folder)
    return folder / "policy.h5", meta["scenario"], meta["overrides"]


def _load(file: Path, scenario: str, overrides: list[str]) -> CompiledScenario:
    try:
        return CompiledScenario(scenario, overrides)
    except InputError as error:
        raise InputError(
            f"{file}: its scenario `{scenario}` cannot be loaded ({error}): give --scenario FILE"
        ) from None


def _check_fits(file: Path, policy: Policy, compiled: CompiledScenario, is_chosen: bool) -> None:
    """Raises InputError unless sizes, images and, if not `is_chosen`, the hash are the policy's."""
    sizes = policy.sizes()
    has = (compiled.observation_size, compiled.action_size)
    if (sizes["observation_size"], sizes["action_size"]) != has:
        raise InputError(
            f"{file}: has {sizes['observation_size']} observations and {sizes['action_size']} "
            f"actions; `{compiled.name}` has {has[0]} and {has[1]}: give --scenario FILE, the "
            "scenario that it was trained in"
        )
    shapes = {c.name: _three(c.shape) for c in compiled.observation_columns if c.image >= 0}
    for image in policy.images:
        if shapes.get(image.column) != image.shape:
            raise InputError(
                f"{file}: sees `{image.column}` of {image.shape} pixels, which `{compiled.name}` "
                "does not observe: give --scenario FILE, the scenario that it was trained in"
            )
    trained, here = policy.attributes["scenario_hash"], f"{compiled.scenario_hash:016x}"
    if trained != here and not is_chosen:
        raise InputError(
            f"{file}: was trained in `{policy.attributes['scenario']}` with the hash "
            f"{trained or 'unknown'}; `{compiled.name}` has {here}, so names and units may "
            f"differ; if they do not, give --scenario {compiled.name}"
        )


def _three(shape: tuple[int, ...]) -> tuple[int, ...]:
    return shape if len(shape) == 3 else (*shape, 1)
