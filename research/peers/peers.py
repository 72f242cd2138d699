"""Speed of MuJoCo, Bullet, Crazyflow and others on the same work.

    python -m research run peers [--quick] [--json FILE] [--picture FILE] [--markdown FILE]
        [--only NAMES] [--gym-pybullet-drones CHECKOUT]

Creates each peer's virtual environment below .peers if its requirements changed, runs its script,
and prints one table with the goals below it. Peers that cannot be installed or run are skipped with
a message. Every contestant, including ours, runs twice, the second time in reverse order, and the
best of both counts, because other programs may run on the machine. README.md describes how the
work is made equal.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import pathlib
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from typing import Any, NoReturn

from research.common import page_data
from research.common.pages import write_json
from research.peers import environments, goals, report, results
from research.peers.environments import HERE, ROOT, Skipped
from research.peers.results import Row

PAGE = "peers"

PROGRAMS = ROOT / "build" / "release" / "bin"
SKYBODY = PROGRAMS / "skybody"


@dataclass(frozen=True)
class Contestant:
    """Ours, a peer's script with its virtual environment, or a peer's C++ program."""

    name: str
    program: bool = False

    def command(self, options: argparse.Namespace) -> list[str]:
        """The command line.

        Raises:
            Skipped: it cannot run here.
        """
        if self.name == "ours":
            return [sys.executable, str(HERE / "ours.py")]
        if self.program:
            path = PROGRAMS / f"bench_peer_{self.name.removesuffix('_cpp')}"
            if not path.is_file():
                raise Skipped(
                    f"no {path.name} was built: its library is not there, or not asked for"
                )
            return [str(path)]
        script = HERE / f"peer_{self.name}.py"
        extra = []
        if self.name == "gym_pybullet_drones":
            if options.gym_pybullet_drones is None:
                raise Skipped("no checkout was given (--gym-pybullet-drones)")
            extra = ["--checkout", str(options.gym_pybullet_drones)]
        return [str(environments.python_of(self.name)), str(script), *extra]


OURS = Contestant("ours")
PEERS = (
    Contestant("mujoco_cpp", program=True),
    Contestant("bullet_cpp", program=True),
    Contestant("mujoco"),
    Contestant("mjbatch"),
    Contestant("pybullet"),
    Contestant("gym_pybullet_drones"),
    Contestant("crazyflow"),
    Contestant("l2f"),
    Contestant("rotorpy"),
    Contestant("envpool"),
)


class Results:
    """Rows and skips of a run, in order of arrival."""

    def __init__(self, quick: bool) -> None:
        self.rows: list[Row] = []
        self.skipped: dict[str, None] = {}  # in order, each once
        # Many short trials find the machine's quiet moments.
        self.effort = ["--seconds", "0.03", "--trials", "8", "--quick"]
        if not quick:
            self.effort = ["--seconds", "0.05", "--trials", "25"]
        self.most = 240.0 if quick else 3600.0  # [s] per run of a contestant

    def skip(self, name: str, why: str) -> None:
        line = f"skipped: {name}: {environments.plain(why)}"
        if line not in self.skipped:
            self.skipped[line] = None
            print(line, file=sys.stderr, flush=True)

    def sitting(self, contestant: Contestant, options: argparse.Namespace, *more: str) -> None:
        started = time.monotonic()
        try:
            command = contestant.command(options)
        except Skipped as why:
            self.skip(contestant.name, str(why))
            return
        before = len(self.rows)
        self.run([*command, *self.effort, *more], contestant.name)
        taken = time.monotonic() - started
        found = len(self.rows) - before
        print(f"  {contestant.name}: {found} rows in {taken:.0f} s", file=sys.stderr, flush=True)

    def run(self, command: list[str], name: str) -> None:
        done, late = run_group(command, self.most)
        self.take(done.stdout, name)
        if late:
            self.skip(name, f"took more than {self.most:.0f} s; rows until then are kept")
        elif done.returncode != 0:
            last = done.stderr.strip().splitlines()[-1:] or [f"exit code {done.returncode}"]
            self.skip(name, last[0])

    def take(self, output: str, name: str) -> None:
        """Lines that are not rows are output of a library and are ignored."""
        for line in output.splitlines():
            if not line.startswith("{"):
                continue
            try:
                facts = json.loads(line)
                if "skipped" in facts:
                    self.skip(str(facts.get("peer", name)), str(facts["skipped"]))
                else:
                    self.rows.append(results.read(facts))
            except ValueError as error:
                self.skip(name, f"printed what is no row: {error}")


def run_group(command: list[str], most: float) -> tuple[subprocess.CompletedProcess[str], bool]:
    """Runs a command; returns its output, and whether it took more than `most` seconds.

    In that case, or if this run is stopped, the command ends with all processes that it started.
    """
    with subprocess.Popen(
        command,
        cwd=environments.workplace(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as script:
        late = False
        try:
            output, errors = script.communicate(timeout=most)
        except subprocess.TimeoutExpired:
            late = True
            os.killpg(script.pid, signal.SIGKILL)
            output, errors = script.communicate()
        except BaseException:
            os.killpg(script.pid, signal.SIGKILL)
            raise
    return subprocess.CompletedProcess(command, script.returncode, output, errors), late


def measure(options: argparse.Namespace) -> Results:
    """Runs each contestant twice, first in this order, then in reverse."""
    peers = [peer for peer in PEERS if not options.only or peer.name in options.only]
    found = Results(options.quick)
    for order in ([OURS, *peers], [OURS, *reversed(peers)]):
        for contestant in order:
            found.sitting(contestant, options)
    found.sitting(OURS, options, "--limit")
    found.rows = results.best_of_sittings(found.rows)
    return found


def machine() -> dict[str, Any]:
    """Name and processors of the machine, as in `skybody bench`."""
    command = [str(SKYBODY), "bench", "hover", "--envs", "1", "--json"]
    done = subprocess.run([*command, "--seconds", "0.05"], check=True, capture_output=True)
    facts = json.loads(done.stdout)
    return {key: facts[key] for key in ("machine", "processor", "processors", "skybody_version")}


def parse(arguments: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="shorter trials, fewer sizes")
    for name, content in (
        ("json", "all rows"),
        ("picture", "a bar chart"),
        ("markdown", "the tables"),
    ):
        to_file = f"write {content} to this file"
        parser.add_argument(f"--{name}", type=pathlib.Path, metavar="FILE", help=to_file)
    only, place = "names of peers, separated by commas", "its repository: it is in no registry"
    parser.add_argument("--only", type=names, metavar="NAMES", help=only)
    parser.add_argument("--gym-pybullet-drones", type=folder, metavar="CHECKOUT", help=place)
    return parser.parse_args(arguments)


def names(text: str) -> list[str]:
    known = [peer.name for peer in PEERS]
    found = text.split(",")
    for name in found:
        if name not in known:
            raise argparse.ArgumentTypeError(f"no peer {name!r}; there are {', '.join(known)}")
    return found


def folder(text: str) -> pathlib.Path:
    path = pathlib.Path(text)
    if not (path / "gym_pybullet_drones").is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} has no folder gym_pybullet_drones")
    return path.resolve()


def main() -> None:
    options = parse()
    if not SKYBODY.is_file():
        refuse(f"no {SKYBODY.relative_to(ROOT)}; ./dev build makes it")
    check_outputs(options)
    with environments.alone():
        compare(options)


def check_outputs(options: argparse.Namespace) -> None:
    """Rejects files that cannot be written, before any measurement."""
    for path in (options.json, options.picture, options.markdown):
        if path is None:
            continue
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            refuse(f"cannot write {path}: {error.strerror}; give another file")
        if path.is_dir() or not os.access(path if path.exists() else path.parent, os.W_OK):
            refuse(f"cannot write {path}; give a file in a folder of yours")


def refuse(message: str) -> NoReturn:
    print(f"peers.py: {message}", file=sys.stderr)
    sys.exit(2)


def compare(options: argparse.Namespace) -> None:
    """Measures, prints and writes."""
    facts = machine() | {
        "date": datetime.date.today().isoformat(),
        "load": os.getloadavg(),
        "quick": options.quick,
    }
    found = measure(options)
    if not any(row.peer == results.OURS for row in found.rows):
        sys.exit("peers.py: nothing of ours was measured: " + "; ".join(found.skipped))
    whole = report.Report(facts, found.rows, list(found.skipped), goals.figures(found.rows))
    print(whole.text())
    if options.json:
        write_json(options.json, whole.facts())
    if options.markdown:
        page_data.write(options.markdown, whole.markdown(options.picture))
    if options.picture:
        from research.peers import picture

        picture.draw(whole, options.picture)
    for path in (options.json, options.markdown, options.picture):
        if path is not None:
            print(f"written: {path}")
