"""A trained policy with the scenario whose observations and actions it has."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from skybody import CompiledScenario, InputError
from skybody._native import Error
from skybody.train.checkpoint import read_meta, resolve
from skybody.train.hyperparameters import UsageError
from skybody.train.policy_file import Policy, read_policy, shipped_policy, write_policy

from .interface import Interface, identifier, interface_of

SHIPPED = "shipped"  # in place of a file
ONNX = ".onnx"  # ending of a policy of another program


@dataclass(frozen=True)
class PolicySource:
    """A policy that is to be exported."""

    file: Path  # policy.h5
    policy: Policy
    compiled: CompiledScenario
    interface: Interface
    name: str  # a C identifier: prefix of functions and types, and the files' name
    kept: tempfile.TemporaryDirectory[str] | None = None  # of `file`, if that was converted


@dataclass(frozen=True)
class Wanted:
    """A policy by the words of the command line."""

    source: str  # policy.h5, the folder of a run or checkpoint, SHIPPED, or a file in ONNX
    scenario: str | None = None  # None: the one that it was trained in
    name: str | None = None  # None: the scenario's
    overrides: Sequence[str] = ()
    plugin_path: Sequence[Path] = ()
    map: Path | None = None  # of ONNX


def open_policy(options: argparse.Namespace) -> PolicySource:
    """The policy of the command line. Raises InputError, as open_wanted()."""
    return open_wanted(
        Wanted(
            options.source,
            options.scenario,
            options.name,
            options.set or (),
            options.plugin_path or (),
            options.map,
        )
    )


def open_wanted(wanted: Wanted) -> PolicySource:
    """Opens a policy with its scenario.

    Raises:
        InputError: it cannot be read, its scenario is not found, or it does not fit it.
    """
    if wanted.source.endswith(ONNX):
        return _open_onnx(wanted)
    if wanted.map is not None:
        raise InputError(f"--map is for policies in ONNX; {wanted.source} is none")
    try:
        file, scenario, overrides = _file_and_scenario(wanted.source, wanted.scenario)
        policy = read_policy(file)
    except (ValueError, UsageError, Error, OSError) as error:
        raise InputError(str(error)) from None
    scenario = scenario or str(policy.attributes["scenario"])
    if not scenario:
        raise InputError(f"{file}: names no scenario: give --scenario NAME")
    compiled = _load(file, scenario, [*overrides, *wanted.overrides], wanted.plugin_path)
    _check_fits(file, policy, compiled, wanted.scenario is not None)
    name = _name(wanted, compiled)
    return PolicySource(file, policy, compiled, interface_of(policy, compiled), name)


def _open_onnx(wanted: Wanted) -> PolicySource:
    """Converts an ONNX file to policy.h5."""
    try:
        from ..onnx_in.map_file import Map, read_map
        from ..onnx_in.reader import read_onnx
    except ModuleNotFoundError as error:
        if error.name != "onnx":
            raise
        raise InputError(f"{wanted.source} needs the package `onnx`: `pip install onnx`") from None
    if wanted.scenario is None:
        raise InputError(f"{wanted.source}: give --scenario NAME, the one that it flies")
    compiled = CompiledScenario(wanted.scenario, wanted.overrides, wanted.plugin_path)
    chosen = Map() if wanted.map is None else read_map(wanted.map)
    policy = read_onnx(Path(wanted.source), compiled, chosen)
    kept = tempfile.TemporaryDirectory()
    file = Path(kept.name) / "policy.h5"
    write_policy(file, policy)
    name = _name(wanted, compiled)
    return PolicySource(file, policy, compiled, interface_of(policy, compiled), name, kept)


def _name(wanted: Wanted, compiled: CompiledScenario) -> str:
    name = str(wanted.name or identifier(compiled.name))
    if not name.isidentifier() or identifier(name) != name:
        raise InputError(f"--name: `{name}` is no C identifier: use letters, digits and _")
    return name


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


def _load(
    file: Path, scenario: str, overrides: Sequence[str], plugin_path: Sequence[Path]
) -> CompiledScenario:
    try:
        return CompiledScenario(scenario, overrides, plugin_path)
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
