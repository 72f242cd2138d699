"""Converts a policy.h5 of format 1, which has no checksum over its whole content, to format 2.

    python -P -m skybody.train.convert_policy FILE [FILE ...]

Each file is replaced as a whole. If it belongs to a checkpoint (meta.json beside it), the hash in
the checkpoint's record is updated. A file of format 2 and its checkpoint's record are unchanged.
If a file cannot be converted, the others still are.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from skybody._native import Error
from skybody.program import module_command, run_program
from skybody.train import files
from skybody.train.json_file import read_json
from skybody.train.policy_file import FORMAT, VERSION, Policy, policy_of, read_policy, write_policy
from skybody.train.requirements import demand_packages

SECONDS = 60.0  # for one file; HDF5 takes forever on some damaged ones
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def main(arguments: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="python -P -m skybody.train.convert_policy",
        description=(__doc__ or "").partition("\n")[0],
    )
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="a policy.h5")
    parser.add_argument("--here", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    work = convert if options.here else convert_in_child
    faults = [_try(work, path) for path in options.files]
    return 2 if any(faults) else 0


def _try(work: Callable[[Path], str], path: Path) -> bool:
    """Prints the result for a file, or the reason of a failure; returns whether it failed."""
    try:
        demand_packages(["h5py"])
        print(work(path))
    except (OSError, ValueError, KeyError, TypeError, Error) as error:
        print(f"convert_policy: {files.explain(error)}", file=sys.stderr)
        return True
    return False


def convert_in_child(path: Path) -> str:
    """convert() in a separate process: HDF5 crashes on some damaged files without checksums."""
    command = module_command("skybody.train.convert_policy", "--here", str(path))
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired:
        raise ValueError(f"{path}: HDF5 does not come to an end: the file is damaged") from None
    if done.returncode == 0:
        return done.stdout.strip()
    message = done.stderr.strip().removeprefix("convert_policy: ")
    if done.returncode != 2:
        message = f"{path}: HDF5 crashes: the file is damaged"
    raise ValueError(message)


def convert(path: Path) -> str:
    """Replaces one file; returns a message about the result."""
    if not path.is_file():
        raise ValueError(f"{path}: there is no such file")
    with path.open("rb") as file:
        is_old = file.read(len(HDF5_SIGNATURE)) == HDF5_SIGNATURE
    if not is_old:
        read_policy(path)  # raises if it is not a policy
        return f"{path}: has format {VERSION} already"
    write_policy(path, _read_old(path))
    _update_checkpoint(path)
    return f"{path}: converted to format {VERSION}"


def _read_old(path: Path) -> Policy:
    """A policy of format 1. Raises ValueError if it cannot be read."""
    import h5py  # type: ignore[import-untyped]

    meta = _read_meta(path)
    if meta is not None and meta["files"].get(path.name) != files.file_hash(path):
        raise ValueError(f"{path} is damaged: its SHA-256 is not that of meta.json beside it")
    try:
        with h5py.File(path, "r") as file:
            found = int(file.attrs.get("version", 0))
            if found != 1:
                raise ValueError(f"{FORMAT} {found} without a seal; only format 1 is converted")
            return policy_of(file)
    except (OSError, KeyError, ValueError) as error:
        raise ValueError(f"{path}: {error}") from error


def _read_meta(path: Path) -> dict[str, Any] | None:
    """meta.json of the policy's checkpoint, if any."""
    meta = path.with_name("meta.json")
    if path.name != "policy.h5" or not meta.is_file():
        return None
    values = read_json(meta)
    return values if isinstance(values, dict) and isinstance(values.get("files"), dict) else None


def _update_checkpoint(path: Path) -> None:
    meta = _read_meta(path)
    if meta is None or meta["files"].get(path.name) == files.file_hash(path):
        return
    meta["files"][path.name] = files.file_hash(path)
    files.write_file(path.with_name("meta.json"), (json.dumps(meta, indent=2) + "\n").encode())


if __name__ == "__main__":
    run_program(main)
