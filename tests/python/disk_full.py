#!/usr/bin/env python3
"""Runs every program that writes files on a full disk, and checks its end.

    .venv/bin/python tests/python/disk_full.py [--program build/release/bin/skybody] [CASE ...]

The disk is a small file system in memory, mounted in a private namespace, filled up to a
few bytes. Each program must end with exit code 2 and one message on stderr that names the file and
contains `No space left on device`, and leave nothing half-written: no file under its final name,
and readable checkpoints. Training then gets its space back, is resumed, and must end with the
bits of a run that always had space. Prints a table; exit code 1 if a check fails, 3 if such a
file system cannot be mounted here.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from skybody.exports.formats import FLIGHT, FORMATS
from skybody.program import module_command

ROOT = Path(__file__).resolve().parents[2]


ROOT = Path(__file__).resolve().parents[2]
DISK_BYTES = 64 << 20
NOT_POSSIBLE = 3  # exit code
INSIDE = "--inside"  # the script calls itself with this in a new mount namespace
SECONDS = 120.0  # for one program

Prepare = Callable[[Path], None]
Check = Callable[[Path], list[str]]


@dataclass(frozen=True)
class Case:
    """A program, and the free space of the disk at its start."""

    name: str
    command: Callable[[Path], list[str]]
    free: int  # bytes
    left: tuple[str, ...] = ()  # names on the disk afterwards
    to_file: str = ""  # file on the disk for stdout
    check: Check | None = None  # further checks, after the disk has space again


def program() -> str:
    """The tested skybody program."""
    return os.environ["SKYBODY_PROGRAM"]


def train_command(algorithm: str, out: Path) -> list[str]:
    """A small run of 10 rollouts, with a checkpoint after each second one."""
    words = module_command("skybody.train", "hover_learn", "--algo", algorithm)
    words += ["--seed", "3", "--out", str(out), "--override", "stepping.horizon=40"]
    words += ["--total-steps", "3000", "--checkpoint-every", "600", "--eval-episodes", "0"]
    words += ["--threads", "1", "--envs", "6"]
    for setting in ("rollout_steps=50", "minibatch=100", "epochs=2", "hidden=8,8"):
        words += ["--set", setting]
    return words


def check_training(algorithm: str) -> Check:
    """Checkpoints are complete, and the resumed run has the bits of a run with space."""

    def check(disk: Path) -> list[str]:
        from skybody.train.checkpoint import checkpoint_folders, read_checkpoint, read_meta

        faults, run, whole = [], disk / "run", disk / "whole"
        before = checkpoint_folders(run)
        if not before:
            faults.append("no checkpoint was left")
        for folder in before:
            read_checkpoint(folder)
        if list(run.glob("checkpoints/.partial-*")):
            faults.append("a partial checkpoint was left")
        resume = module_command("skybody.train", "--resume", "--out", str(run))
        for command in (resume, train_command(algorithm, whole)):
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                return [*faults, f"exit code {done.returncode}: {done.stderr}"]
        hashes = [read_meta(checkpoint_folders(f)[-1])["parameter_hash"] for f in (run, whole)]
        if hashes[0] != hashes[1]:
            faults.append("the resumed run has other bits")
        return faults + check_exports(disk, run)

    return check


def check_exports(disk: Path, run: Path) -> list[str]:
    """Checks exports from an existing run onto a disk without space."""
    evaluated = ("skybody.train.evaluate", str(run), "--episodes", "1", "--json")
    exports = {
        "result.json": module_command(*evaluated),
        "curve.png": module_command("skybody.train.curve", str(run), "--out"),
    }
    filler, faults = fill(disk, 0), []
    for name, command in exports.items():
        done = subprocess.run(
            [*command, str(disk / name)], capture_output=True, text=True, check=False
        )
        faults += [f"{name}: {fault}" for fault in message_faults(done, str(disk / name))]
        if (disk / name).exists():
            faults.append(f"{name} was left")
    filler.unlink()
    return faults


def export_command(kind: str, disk: Path) -> list[str]:
    """An export of a flight that is made on the disk."""
    words = ["run", "hover", "--steps", "3000", "--no-picture", "--out", str(disk / "log")]
    subprocess.run([program(), *words], check=True, capture_output=True, timeout=SECONDS)
    return [program(), "export", str(disk / "log"), "--to", kind, "-o", str(disk / "out")]


def import_command(disk: Path) -> list[str]:
    """An import of an exported flight."""
    log = disk / "flight.mcap"
    words = export_command("mcap", disk)
    subprocess.run([*words[:-1], str(log)], check=True, capture_output=True, timeout=SECONDS)
    return [program(), "import", str(log), "-o", str(disk / "out.h5")]


CASES = (
    Case("import", import_command, free=32 << 10, left=("flight.mcap", "log")),
    *(
        Case(f"export {kind}", partial(export_command, kind), free=32 << 10, left=("log",))
        for kind, row in FORMATS.items()
        if row.reads == FLIGHT
    ),
    Case(
        "run",
        lambda disk: [program(), "run", "hover", "--out", str(disk / "out"), "--no-picture"],
        free=16 << 10,
    ),
    Case(
        "record",
        lambda disk: [
            *(program(), "hash", "hover", "--envs", "16", "--steps", "5000"),
            *("--record", str(disk / "run.h5")),
        ],
        free=1 << 20,
    ),
    Case(
        "new",
        lambda disk: [program(), "new", "controller", "my_law", "--dir", str(disk)],
        free=4 << 10,
    ),
    Case(
        "schema > file",
        lambda _: [program(), "schema"],
        free=4 << 10,
        left=("schema.json",),  # created by the shell
        to_file="schema.json",
    ),
    *(
        Case(
            f"train {algorithm}",
            lambda disk, algorithm=algorithm: train_command(algorithm, disk / "run"),
            free=free,
            left=("run",),
            check=check_training(algorithm),
        )
        for algorithm, free in (("ppo", 160 << 10), ("fast-ppo", 160 << 10))
    ),
    Case(
        "train, no space at all",
        lambda disk: train_command("fast-ppo", disk / "run"),
        free=0,
    ),
)


def fill(disk: Path, free: int) -> Path:
    """Fills the disk except for `free` bytes."""
    filler = disk / ".filler"
    space = os.statvfs(disk)
    with filler.open("wb") as file:
        os.posix_fallocate(file.fileno(), 0, max(1, space.f_bavail * space.f_frsize - free))
    return filler


def message_faults(done: subprocess.CompletedProcess[str], name: str) -> list[str]:
    """Faults in the exit code and messages of a program."""
    faults, lines = [], done.stderr.strip().splitlines()
    print(f"  exit code {done.returncode}: " + " / ".join(lines), flush=True)
    if done.returncode != 2:
        faults.append(f"exit code {done.returncode}, not 2")
    if len(lines) != 1:
        faults.append(f"{len(lines)} lines on stderr, not one")
    for text in (name, "No space left on device"):
        if text not in done.stderr:
            faults.append(f"the message does not have `{text}`")
    return faults


def run_case(case: Case, disk: Path) -> list[str]:
    """Runs a case; returns its faults."""
    command = case.command(disk)
    filler = fill(disk, case.free)
    out = (disk / case.to_file).open("w") if case.to_file else subprocess.DEVNULL
    done = subprocess.run(
        command,
        stdin=subprocess.DEVNULL,
        stdout=out,
        stderr=subprocess.PIPE,
        text=True,
        timeout=SECONDS,
        check=False,
        cwd="/",
    )
    if case.to_file:
        out.close()  # type: ignore[union-attr]
    left = tuple(sorted(path.name for path in disk.iterdir() if path != filler))
    filler.unlink()
    faults = message_faults(done, "standard output" if case.to_file else str(disk))
    if left != case.left:
        faults.append(f"left {', '.join(left) or 'nothing'}")
    return faults + (case.check(disk) if case.check else [])


def inside(names: list[str]) -> int:
    """Runs the cases in a namespace that can mount a disk."""
    disk = Path(tempfile.mkdtemp(prefix="skybody_disk_"))
    size = f"size={DISK_BYTES}"
    if subprocess.run(["mount", "-t", "tmpfs", "-o", size, "none", disk], check=False).returncode:
        return NOT_POSSIBLE
    wrong = 0
    try:
        for case in CASES:
            if names and case.name not in names:
                continue
            print(f"{case.name}:", flush=True)
            faults = run_case(case, disk)
            wrong += bool(faults)
            print(f"  {'; '.join(faults) or 'as it must be'}", flush=True)
            for path in disk.iterdir():
                shutil.rmtree(path) if path.is_dir() else path.unlink()
    finally:
        subprocess.run(["umount", disk], check=False)
        disk.rmdir()
    return 1 if wrong else 0


def main(arguments: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cases", nargs="*", metavar="CASE", help="cases; default: all")
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/bin/skybody")
    parser.add_argument(INSIDE, action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    unknown = set(options.cases) - {case.name for case in CASES}
    if unknown:
        parser.error(f"no case {', '.join(sorted(unknown))}: {', '.join(c.name for c in CASES)}")
    os.environ["SKYBODY_PROGRAM"] = str(options.program.resolve())
    if options.inside:
        return inside(options.cases)
    if shutil.which("unshare") is None:
        print("disk_full: no file system can be mounted here: there is no program `unshare`")
        return NOT_POSSIBLE
    words = ["unshare", "--user", "--map-root-user", "--mount"]
    probe = subprocess.run(
        [*words, "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True, check=False
    )
    if probe.returncode != 0:
        print(f"disk_full: no file system can be mounted here: {probe.stderr.decode().strip()}")
        return NOT_POSSIBLE
    words += [
        sys.executable,
        "-P",
        __file__,
        INSIDE,
        "--program",
        str(options.program),
        *options.cases,
    ]
    os.execvp(words[0], words)


if __name__ == "__main__":
    sys.exit(main())
