#!/usr/bin/env python3
"""How exact every shipped scenario is by integrator and time step, and what that costs.

    .venv/bin/python experiments/integrator_audit.py [--only NAME...] [--quick] [--out docs]

A scenario's baseline flight (`skybody run`, 1 s, commands held for the least common multiple of its
action interval and the largest step) gives rotor commands. They are flown again, open loop, with
every integrator and step, and compared with CVODE at a tight tolerance: so the integrator is
audited, not the controller's rate. Writes integrators.md, data/integrator_audit.json and
images/integrator_audit.png. --quick: three scenarios, two steps, nothing but the table.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import skybody
from integrator_report import facts_of_machine, write_page, write_picture
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "build/release/bin/skybody"
SEED = 0  # as `skybody run` has it
FLIGHT = 1.0  # [s]
STEPS_US = (250, 500, 1000, 2000, 4000)  # dt [us]
LONG = 0.5  # a flight that takes longer [s] is its own cost: calls from Python are nothing to it
GOOD_POSITION, GOOD_ANGLE = 1e-3, math.radians(0.1)  # what counts as exact [m], [rad]
POLICIES = {"hard_landing": "zero"}  # two thirds of the weight are carried: it falls
Reals = NDArray[np.float64]


@dataclass(frozen=True)
class Integrator:
    """One way of advancing the state: name for tables, and what the scenario is told."""

    name: str
    overrides: tuple[str, ...]


def solver(integrator: str, method: str) -> Integrator:
    return Integrator(
        f"{integrator} {method}",
        (f"stepping.integrator={integrator}", f"stepping.solver.method={method}"),
    )


INTEGRATORS = (
    Integrator("semi_implicit_euler", ("stepping.integrator=semi_implicit_euler",)),
    Integrator("rk4", ("stepping.integrator=rk4",)),
    solver("cvode", "adams"),
    solver("cvode", "bdf"),
    solver("arkode", "erk"),
    solver("arkode", "dirk"),
)
DEFAULTS = {"cvode": "cvode bdf", "arkode": "arkode erk"}  # `method: auto`
REFERENCE = (
    "stepping.integrator=cvode",
    "stepping.solver.method=bdf",
    "stepping.solver.relative_tolerance=1e-10",
    "stepping.solver.absolute_tolerance=1e-12",
    "stepping.solver.max_steps=1000000",
)


@dataclass(frozen=True)
class Flight:
    """A baseline flight: rotor commands, each held for `interval` [s]."""

    scenario: str
    own: str  # name of the scenario's integrator
    own_dt: float
    interval: float
    commands: Reals  # (intervals, rotors) [rad/s]
    start: Reals  # (bodies, 13) as the flight log has it


@dataclass(frozen=True)
class Result:
    """One scenario, one integrator, one step; errors against the reference after 1 s."""

    scenario: str
    integrator: str
    dt: float
    fault: bool
    position: float  # largest of any body's origin [m]
    angle: float  # largest of any body [rad]
    energy: float  # mechanical energy less the reference's [J]
    cost: float  # time for a simulated second of one environment alone [s]

    @property
    def is_good(self) -> bool:
        return not self.fault and self.position < GOOD_POSITION and self.angle < GOOD_ANGLE


def shipped() -> list[str]:
    return sorted(path.stem for path in (ROOT / "scenarios").glob("*.yaml"))


def stepping_of(scenario: str) -> tuple[float, int, str]:
    """Its dt [s], action_repeat and integrator, by the name that tables have."""
    log = fly_and_log(scenario, 1, [])
    text = log["text"]
    values = dict(line.split(": ", 1) for line in map(str.strip, text.splitlines()) if ": " in line)
    own = values.get("integrator", "semi_implicit_euler")
    return log["dt"], log["action_repeat"], DEFAULTS.get(own, own)


def fly_and_log(scenario: str, steps: int, overrides: list[str]) -> dict[str, Any]:
    """One episode of `skybody run`; what its log says."""
    with tempfile.TemporaryDirectory() as folder:
        command = [str(PROGRAM), "run", scenario, "--policy", POLICIES.get(scenario, "hold")]
        command += ["--seed", str(SEED), "--steps", str(steps), "--no-picture", "--out", folder]
        command += [part for override in overrides for part in ("--set", override)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}\n{done.stderr}")
        with h5py.File(Path(folder) / "flight.h5") as log:
            episode = log["episodes/0001"]
            return {
                "dt": float(log.attrs["dt"]),
                "action_repeat": int(log.attrs["action_repeat"]),
                "text": str(log.attrs["scenario_text"]),
                "commands": episode["rotor_command"][1:],
                "bodies": episode["bodies"][:],
            }


def baseline(scenario: str) -> Flight:
    dt, repeat, own = stepping_of(scenario)
    interval_us = math.lcm(round(1e6 * dt * repeat), max(STEPS_US))
    held = round(interval_us / (1e6 * dt))
    count = math.ceil(1e6 * FLIGHT / interval_us)
    log = fly_and_log(scenario, count, [f"stepping.action_repeat={held}", "stepping.horizon=0"])
    if len(log["commands"]) < count:
        sys.exit(f"{scenario}: the baseline flight ends before {FLIGHT:g} s")
    return Flight(scenario, own, dt, 1e-6 * interval_us, log["commands"], log["bodies"][0])


class Replay:
    """Flies the commands of a flight again, open loop."""

    def __init__(self, flight: Flight, dt: float, overrides: tuple[str, ...]) -> None:
        changes = [f"stepping.dt={dt:g}", "stepping.action_repeat=1", *overrides]
        self.flight = flight
        self.repeats = round(flight.interval / dt)
        self.world = skybody.Simulation(
            flight.scenario, control="rotor_speed", seed=SEED, overrides=changes
        )
        robots = self.world.environment.robots
        ends = np.cumsum([self.world.command_size(robot) for robot in robots])
        self.robots = list(zip(robots, np.split(np.arange(ends[-1]), ends[:-1]), strict=True))

    def fly(self) -> float:
        """Time that it took [s]."""
        self.begin()
        began = time.perf_counter()
        for row in self.flight.commands:
            self.command(row)
            if not self.world.advance(self.repeats):
                break
        return time.perf_counter() - began

    def cost(self) -> float:
        """Time of a second under the first commands [s], all of it spent in physics steps."""
        self.begin()
        self.command(self.flight.commands[0])
        began = time.perf_counter()
        self.world.advance(round(FLIGHT / self.flight.interval) * self.repeats)
        return time.perf_counter() - began

    def begin(self) -> None:
        self.world.reset(seed=SEED)
        if not np.array_equal(motion(self.world)[:, :7], self.flight.start[:, :7]):
            sys.exit(f"{self.flight.scenario}: a replay does not begin as the flight did")

    def command(self, row: Reals) -> None:
        for robot, rotors in self.robots:
            self.world.command(row[rotors], robot)


def motion(world: skybody.Simulation) -> Reals:
    """(bodies, 13): position, quaternion, velocity, angular velocity."""
    return np.array(
        [
            np.concatenate([b.position, b.rotation, b.velocity, b.angular_velocity])
            for b in world.bodies
        ]
    )


def energy(world: skybody.Simulation) -> float:
    """Kinetic and gravitational, of all bodies [J]; springs are left out."""
    total = 0.0
    for name, body in zip(world.body_names, world.bodies, strict=True):
        robot, link = name.split(".", 1)
        mass = world.mass_properties(link, robot)
        turn = rotation_matrix(body.rotation)
        center = body.position + turn @ mass.com
        spin = body.angular_velocity
        velocity = body.velocity + turn @ np.cross(spin, mass.com)
        total += 0.5 * mass.mass * velocity @ velocity + 0.5 * spin @ mass.inertia @ spin
        total += mass.mass * 9.81 * center[2]
    return float(total)


def rotation_matrix(q: Reals) -> Reals:
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def turned(a: Reals, b: Reals) -> Reals:
    """Angles between rows of unit quaternions [rad]; exact for small ones."""
    nearest = np.where(np.sum(a * b, axis=1, keepdims=True) < 0.0, -b, b)
    return 4.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(a - nearest, axis=1), 1.0))


def audit(flight: Flight, steps_us: tuple[int, ...], trials: int) -> list[Result]:
    reference = Replay(flight, 1e-6 * max(steps_us), REFERENCE)
    reference.fly()
    if reference.world.fault:
        sys.exit(f"{flight.scenario}: the reference gives up")
    exact, exact_energy = motion(reference.world), energy(reference.world)
    results = []
    for integrator in INTEGRATORS:
        for us in steps_us:
            replay = Replay(flight, 1e-6 * us, integrator.overrides)
            flown = replay.fly()
            here, fault = motion(replay.world), bool(replay.world.fault)
            here_energy = energy(replay.world)
            cost = flown if flown > LONG else min(replay.cost() for _ in range(trials))
            results.append(
                Result(
                    flight.scenario,
                    integrator.name,
                    1e-6 * us,
                    fault,
                    float(np.linalg.norm(here[:, :3] - exact[:, :3], axis=1).max()),
                    float(turned(here[:, 3:7], exact[:, 3:7]).max()),
                    here_energy - exact_energy,
                    cost / FLIGHT,
                )
            )
    return results


def words(result: Result) -> str:
    if result.fault:
        return "fault"
    return f"{1e3 * result.position:.3g} mm {math.degrees(result.angle):.2g} deg"


def print_scenario(flight: Flight, results: list[Result]) -> None:
    print(f"{flight.scenario} (own: {flight.own}, {1e3 * flight.own_dt:g} ms)")
    for integrator in INTEGRATORS:
        mine = [r for r in results if r.integrator == integrator.name]
        print(f"  {integrator.name:20}" + "".join(f"{words(r):>26}" for r in mine), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=shipped(), metavar="NAME")
    parser.add_argument("--quick", action="store_true", help="a look: nothing is written")
    parser.add_argument("--out", type=Path, default=ROOT / "docs", help="folder to write to")
    options = parser.parse_args()
    names = options.only or (["hover", "payload", "boom"] if options.quick else shipped())
    steps_us = (1000, 4000) if options.quick else STEPS_US
    flights, results = [], []
    for name in names:
        flight = baseline(name)
        found = audit(flight, steps_us, 2 if options.quick else 4)
        print_scenario(flight, found)
        flights.append(flight)
        results += found
    if options.quick or options.only:
        return
    facts = facts_of_machine() | {
        "good": {"position": GOOD_POSITION, "angle": GOOD_ANGLE},
        "flights": [
            {"scenario": f.scenario, "own": f.own, "own_dt": f.own_dt, "interval": f.interval}
            for f in flights
        ],
        "results": [asdict(r) | {"is_good": r.is_good} for r in results],
    }
    (options.out / "data").mkdir(parents=True, exist_ok=True)
    (options.out / "images").mkdir(exist_ok=True)
    (options.out / "data/integrator_audit.json").write_text(json.dumps(facts, indent=1) + "\n")
    write_page(facts, options.out / "integrators.md")
    write_picture(facts, options.out / "images/integrator_audit.png")


if __name__ == "__main__":
    main()
