"""Checkpoints: the complete state for resuming training bit for bit, in one folder.

step_NNNNNNNNNNNN/state.pt           networks, optimizer, statistics, generators, bookkeeping;
                                     of learners in C++ state.npz
                  environments.bin   every word of every environment
                  policy.h5          the policy for `skybody run --policy` and evaluation
                  meta.json          stamps, and the SHA-256 of the files above
                  evaluation.json    added by an evaluation, later
"""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skybody.train import files
from skybody.train.json_file import read_json, wrong_kinds
from skybody.train.policy_file import Policy, policy_bytes
from skybody.train.state_file import pack_state, state_file, unpack_state

STAMPS: dict[str, Any] = {  # fields of meta.json that other code reads
    "steps": int,
    "parameter_hash": str,
    "algorithm": str,
    "seed": int,
    "scenario": str,
    "overrides": list[str],
    "plugin_path": list[str],
    "scenario_hash": str,
    "hyper": dict[str, Any],
    "wall_clock": float,
    "files": dict[str, str],
}
REMEDY = "remove this checkpoint's folder to go on from the one before"


@dataclass(frozen=True)
class Checkpoint:
    """The contents of a checkpoint that was read."""

    path: Path
    meta: dict[str, Any]
    state: dict[str, Any]
    environments: bytes


def checkpoint_folders(run: Path) -> list[Path]:
    """All complete checkpoints of a run, oldest first."""
    return sorted(path for path in run.glob("checkpoints/step_*") if (path / "meta.json").exists())


def write_checkpoint(
    run: Path, meta: dict[str, Any], state: dict[str, Any], environments: bytes, policy: Policy
) -> Path:
    """Writes the checkpoint of meta["steps"] steps: complete or not at all, even after a kill.

    The same holds if writing fails: it raises OSError, which names the file.
    """
    final = run / "checkpoints" / f"step_{meta['steps']:012d}"
    if final.exists():
        return final
    partial = final.with_name(f".partial-{final.name}")
    shutil.rmtree(partial, ignore_errors=True)
    try:
        _write_files(partial, meta, state, environments, policy)
        files.publish_folder(partial, final)
    except OSError:
        shutil.rmtree(partial, ignore_errors=True)
        raise
    return final


def _write_files(
    folder: Path, meta: dict[str, Any], state: dict[str, Any], environments: bytes, policy: Policy
) -> None:
    with files.naming(folder):
        folder.mkdir(parents=True)
    algorithm = meta["algorithm"]
    # publish_folder() syncs all of them to the disk at once.
    files.write_part(folder / "policy.h5", policy_bytes(policy))
    files.write_part(folder / state_file(algorithm), pack_state(algorithm, state))
    files.write_part(folder / "environments.bin", environments)
    hashes = {path.name: files.file_hash(path) for path in sorted(folder.iterdir())}
    text = json.dumps({**meta, "files": hashes}, indent=2) + "\n"
    files.write_part(folder / "meta.json", text.encode())


def read_meta(folder: Path) -> dict[str, Any]:
    """The stamps of a checkpoint. Raises ValueError if they cannot be read."""
    path = folder / "meta.json"
    try:
        meta = read_json(path)
    except ValueError as error:
        raise ValueError(f"{path} is damaged ({error}): {REMEDY}") from error
    if not isinstance(meta, dict):
        raise ValueError(f"{path} is damaged (no map of stamps): {REMEDY}")
    wrong = wrong_kinds(meta, STAMPS)
    if not wrong:
        wrong = [f"files.{name}" for name in file_names(meta) if name not in meta["files"]]
    if wrong:
        raise ValueError(f"{path} is damaged ({', '.join(wrong)}): {REMEDY}")
    return meta


def file_names(meta: dict[str, Any]) -> tuple[str, ...]:
    """Names of a checkpoint's files other than meta.json."""
    return (state_file(meta["algorithm"]), "environments.bin", "policy.h5")


def check_file(folder: Path, meta: dict[str, Any], name: str) -> Path:
    """The path of a checkpoint's file. Raises ValueError unless its hash is the recorded one."""
    path = folder / name
    if not path.is_file():
        raise ValueError(f"{path} is missing: {REMEDY}")
    try:
        found = files.file_hash(path)
    except ValueError as error:
        raise ValueError(f"{path} {error}: {REMEDY}") from None
    if found != meta["files"][name]:
        raise ValueError(f"{path} is damaged: its SHA-256 is not that of meta.json; {REMEDY}")
    return path


def read_checkpoint(folder: Path) -> Checkpoint:
    """Reads a checkpoint. Raises ValueError if a file differs from its recorded hash."""
    meta = read_meta(folder)
    for name in file_names(meta):
        check_file(folder, meta, name)
    path = folder / state_file(meta["algorithm"])
    try:
        state = unpack_state(path)
    except ValueError as error:
        raise ValueError(f"{path} is damaged ({error}): {REMEDY}") from error
    return Checkpoint(folder, meta, state, files.read_file(folder / "environments.bin"))


def resolve(path: Path) -> Path:
    """The checkpoint of `path`: itself, or the newest one of a run folder."""
    if (path / "meta.json").exists():
        return path
    found = checkpoint_folders(path)
    if not found:
        raise FileNotFoundError(
            f"{path} is neither a checkpoint (a folder with meta.json) nor a run with one"
        )
    return found[-1]
