"""Latency of `skybody onboard` in real time on a machine under full load.

    python -m research run onboard_latency [--quick] [--seconds S] [--out DIR]

Programs of two kinds fly the shipped policy of trajectory_ctbr at the same time: one by the usual
scheduler, one with `--fifo 50 --lock-memory` where that is permitted. A process sends both the
poses of a recorded flight at 100 Hz, and on each core a process computes without a pause. A bare
timer with the same priority shows the lateness that the machine itself has.
"""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import os
import socket
import tempfile
import time
from collections.abc import Iterator, Sequence
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skybody import CompiledScenario, FlightPolicy, InputError, Simulation
from skybody._native import mission_bytes
from skybody.onboard import packets
from skybody.onboard.lockstep import HOST
from skybody.onboard.program import running
from skybody.train.policy_file import shipped_policy

from research.common.machine import facts, machine_line, processors
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page

PAGE = "onboard_latency"
SCENARIO = "trajectory_ctbr"
SECONDS, QUICK = 600.0, 2.0
RECORDED = 1000  # steps of the flight whose poses are sent again and again
KINDS = {
    "usual scheduler": [],
    "`--fifo 50 --lock-memory`": ["--fifo", "50", "--lock-memory"],
}
BARE, PRIORITY = "a bare timer in Python, SCHED_FIFO 50", 50
# The steps are measured, not the flight: the policy flies all the time.
LIMITS = [
    word
    for limit in ("stale=60", "lateness=60", "tilt=4")
    for word in ("--limit", limit)
]  # fmt: skip


def recorded_poses() -> NDArray[np.float64]:
    """Poses and twists (steps, 13) of a flight by the policy."""
    compiled = CompiledScenario(SCENARIO)
    simulation = Simulation(compiled)
    policy = FlightPolicy(compiled, str(shipped_policy(SCENARIO, SCENARIO)))
    simulation.reset()
    rows = []
    while len(rows) < RECORDED and not simulation.truncated:
        b = simulation.bodies[0]
        rows.append(np.concatenate([b.position, b.rotation, b.velocity, b.angular_velocity]))
        simulation.step(policy.act(simulation))
    return np.array(rows)


def send_poses(ports: Sequence[int], rows: NDArray[np.float64], period: float, ends: Event) -> None:
    """Sends a row each period to all ports, and takes the answers."""
    links = []
    for port in ports:
        link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        link.connect((HOST, port))
        link.setblocking(False)
        links.append(link)
    begin, sequence = time.monotonic(), 0
    while not ends.is_set():
        now = time.monotonic() - begin
        row = rows[int(now / period) % len(rows)]
        state = packets.state(sequence, now, row[:3], row[3:7], row[7:10], row[10:])
        for link in links:
            with contextlib.suppress(OSError):
                link.send(state)
            with contextlib.suppress(OSError):
                while link.recv(4096):
                    pass
        sequence += 1
        ends.wait(max(0.0, sequence * period - (time.monotonic() - begin)))


def compute(ends: Event) -> None:
    """Computes without a pause."""
    value = 1.0
    while not ends.is_set():
        for _ in range(100_000):
            value = 1.0 / (1.0 + value)


def wake(period: float, priority: int, file: Path, ends: Event) -> None:
    """Wakes up each period with SCHED_FIFO and writes the delays [us]."""
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    delays = []
    due = time.monotonic_ns()
    while not ends.is_set():
        due += round(1e9 * period)
        time.sleep(max(0, due - time.monotonic_ns()) * 1e-9)
        delays.append((time.monotonic_ns() - due) * 1e-3)
        due = max(due, time.monotonic_ns() - round(1e9 * period))
    np.save(file, np.array(delays))


def bare_row(delays: NDArray[np.float64]) -> dict[str, Any]:
    """The delays of wake() as a report of the program."""
    names = {"p50_us": 50.0, "p99_us": 99.0, "p99_9_us": 99.9, "max_us": 100.0}
    late = {name: float(np.percentile(delays, share)) for name, share in names.items()}
    late["above_1_ms"] = int((delays > 1000.0).sum())
    return {"kind": BARE, "steps": len(delays), "late": late, "work": None, "left_out": None}


def stolen() -> float:
    """Processor time that the host has taken from this machine so far [s]."""
    return float(Path("/proc/stat").read_text().split()[8]) / os.sysconf("SC_CLK_TCK")


@contextlib.contextmanager
def processes(*calls: tuple[Any, tuple[Any, ...]]) -> Iterator[None]:
    """Runs functions in processes of their own within this scope; their last argument ends them."""
    spawn = multiprocessing.get_context("spawn")
    ends = spawn.Event()
    started = [spawn.Process(target=call, args=(*given, ends)) for call, given in calls]
    for process in started:
        process.start()
    try:
        yield
    finally:
        ends.set()
        for process in started:
            process.join()


def is_permitted(mission: Path, options: Sequence[str]) -> bool:
    """Whether the program starts with these options here."""
    try:
        with running(mission, [*options, "--seconds", "0.1"]):
            return True
    except InputError:
        return False


def measure(seconds: float) -> list[dict[str, Any]]:
    """Reports of all kinds that are permitted."""
    compiled = CompiledScenario(SCENARIO)
    period = compiled.dt * compiled.action_repeat
    poses = recorded_poses()
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        folder = Path(name)
        mission = folder / "m"
        policy = str(shipped_policy(SCENARIO, SCENARIO))
        mission.write_bytes(mission_bytes(compiled, policy))
        kinds = [kind for kind, words in KINDS.items() if is_permitted(mission, words)]
        flights = []
        for k, kind in enumerate(kinds):
            report = folder / f"{k}.json"
            words = [*KINDS[kind], *LIMITS, "--seconds", str(seconds), "--json", str(report)]
            port, process = stack.enter_context(running(mission, words))
            flights.append((kind, report, port, process))
        ports = [port for _, _, port, _ in flights]
        load: list[tuple[Any, tuple[Any, ...]]] = [(compute, ())] * processors()
        delays = folder / "delays.npy"
        if len(kinds) == len(KINDS):  # SCHED_FIFO is permitted
            load.append((wake, (period, PRIORITY, delays)))
        with processes((send_poses, (ports, poses, period)), *load):
            for *_, process in flights:
                process.wait(seconds + 60.0)
        rows = [{"kind": kind, **json.loads(file.read_text())} for kind, file, _, _ in flights]
        if delays.exists() and len(found := np.load(delays)) > 0:
            rows.append(bare_row(found))
        return rows


def page(
    about: dict[str, Any],
    rows: list[dict[str, Any]],
    seconds: float,
    stolen_seconds: float,
    command: str,
) -> str:
    """The page."""
    table: list[Any] = [
        head(
            "scheduling | steps | late p50 [us] | p99 [us] | p99.9 [us] | max [us] | above 1 ms | "
            "left out | work p50 [us] | work p99 [us]"
        )
    ]
    for row in rows:
        late, work = row["late"], row["work"]
        table.append(
            [
                row["kind"],
                f"{row['steps']:,}",
                *(f"{late[name]:,.0f}" for name in ("p50_us", "p99_us", "p99_9_us", "max_us")),
                late["above_1_ms"],
                "" if row["left_out"] is None else row["left_out"],
                *(f"{work[name]:.0f}" if work else "" for name in ("p50_us", "p99_us")),
            ]
        )
    return f"""# Latency of `skybody onboard`

{machine_line(about)}

    {command}

The shipped policy of `{SCENARIO}` (700 observations) at 100 Hz for {seconds:g} s, on a machine
under full load: {about["cores"]} processes that compute without a pause, one for each core, beside
other work. "Late" is the time from the moment at which a step is due until its command is sent;
"work" is that part of it that the step computes and sends. "Left out" counts periods in which no
step could begin. A command is due at its step's time; above 1 ms it counts as missed.

{markdown_table(table)}

All ran at the same time, in a virtual machine whose kernel has no PREEMPT_RT
({os.uname().release}); the host took {stolen_seconds:.1f} s of processor time from it. The
bare timer does nothing but wake up: delays that it has, too, are the machine's. `--fifo` needs
root, CAP_SYS_NICE or a limit of `ulimit -r`. For deadlines that hold, give the vehicle a kernel
with PREEMPT_RT and a core of its own (`taskset`).
"""


def main() -> int:
    parser = Options(__doc__, __name__, trial=f"{QUICK:g} s")
    parser.add("--seconds", type=float, help=f"of the flight; default: {SECONDS:g}")
    options = parser.given()
    seconds = options.seconds or (QUICK if options.quick else SECONDS)
    about = facts()
    before = stolen()
    rows = measure(seconds)
    taken = stolen() - before
    text = page(about, rows, seconds, taken, options.command)
    data = {"facts": about, "seconds": seconds, "stolen": taken, "rows": rows}
    write_page(options.out, PAGE, text, data)
    return 0
