#!/usr/bin/env python3
"""How exact every shipped scenario is by integrator and time step, and what that costs.

    .venv/bin/python experiments/integrator_audit.py [--only NAME...] [--quick] [--out FOLDER]

A scenario's baseline flight (`skybody run`, 1 s, commands held for the least common multiple of its
action interval and the largest step) gives commands: of rotors, and of other actuators where a
robot has no rotors. Hard dashes are made of them: each is multiplied by factors that are drawn anew
every 0.1 s, equal for every robot, without a ground. Two flights are flown as they are:
hard_landing, onto the ground, and collision, which begins LEAD before the robots are near to each
other in the scenario's own flight. All are flown open loop, with every integrator and step, and
compared with CVODE at a tight tolerance, or with very small steps where things touch: so the
integrator is audited, not the controller's rate. Writes integrators.md, data/integrator_audit.json
and images/integrator_audit.png. --quick: five scenarios, two steps. --only: nothing but the table.
"""

from __future__ import annotations

import math
import re
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
from integrator_report import write_page, write_picture
from numpy.typing import NDArray
from skybody.program import run_program
from skybody.simulation import CONTROL_MODES
from throughput import ROOT, arguments, facts, output_folder, write_json

PROGRAM = ROOT / "build/release/bin/skybody"
GRAVITY = 9.81  # of every shipped scenario [m/s^2]
SEED = 0  # as `skybody run` has it
FLIGHT = 1.0  # [s]
STEPS_US = (250, 500, 1000, 2000, 4000)  # dt [us]
QUICK_STEPS_US = (1000, 4000)
TRIALS = 4
LONG = 0.5  # a flight that takes longer [s] is timed once: noise is small beside it
GOOD_POSITION, GOOD_ANGLE = 1e-3, math.radians(0.1)  # what counts as exact [m], [rad]
POLICIES = {"hard_landing": "zero"}  # two thirds of the weight are carried: it falls
DASH = 0.2  # a rotor's command is multiplied by 1 - DASH to 1 + DASH
DASH_TIME = 0.1  # for so long [s]
MOST_COMMANDS = 16  # of a robot
GROUNDED = ("hard_landing",)  # flown onto the ground; others in free air
TOUCHING = ("hard_landing", "collision")  # flown as they are, without dashes: things touch
CLOSING = ("collision",)  # begun LEAD before anything is near, in the midst of the baseline flight
LEAD = 0.3  # [s]
APPROACH = 2.0  # so long may it take until then [s]
QUICK = ("hover", "payload", "boom", "collision", "four_bar")
Reals = NDArray[np.float64]


@dataclass(frozen=True)
class Integrator:
    """One way of advancing the state: name for tables, and what the scenario is told."""

    name: str
    overrides: tuple[str, ...]


def fixed(integrator: str) -> Integrator:
    return Integrator(integrator, (f"stepping.integrator={integrator}", "stepping.solver=null"))


def solver(integrator: str, method: str) -> Integrator:
    return Integrator(
        f"{integrator} {method}",
        (
            f"stepping.integrator={integrator}",
            f"stepping.solver.method={method}",
            "stepping.solver.relative_tolerance=1e-8",  # the defaults, whatever the scenario has
            "stepping.solver.absolute_tolerance=1e-11",
        ),
    )


INTEGRATORS = (
    fixed("semi_implicit_euler"),
    fixed("midpoint"),
    fixed("rk4"),
    solver("cvode", "adams"),
    solver("cvode", "bdf"),
    solver("arkode", "erk"),
    solver("arkode", "dirk"),
)
DEFAULTS = {"cvode": "cvode adams", "arkode": "arkode erk"}  # `method: auto`


def reference(method: str, tolerance: float) -> tuple[str, ...]:
    """What makes CVODE exact."""
    return (
        "stepping.integrator=cvode",
        f"stepping.solver.method={method}",
        f"stepping.solver.relative_tolerance={tolerance:g}",
        f"stepping.solver.absolute_tolerance={1e-2 * tolerance:g}",
        "stepping.solver.max_steps=1000000",
    )


@dataclass(frozen=True)
class Reference:
    """What a flight is compared with."""

    dt: float  # [s]
    overrides: tuple[str, ...]


COARSE = 1e-6 * max(STEPS_US)
# How far apart the two are says how exact they are. Contact is a correction of each step, whatever
# integrates the rest (docs/contact.md): where things touch, only small steps are exact.
FREE = (Reference(COARSE, reference("bdf", 1e-10)), Reference(COARSE, reference("adams", 1e-11)))
IN_CONTACT = (
    Reference(2.5e-5, fixed("rk4").overrides),
    Reference(5e-5, fixed("rk4").overrides),
)


def references(scenario: str) -> tuple[Reference, Reference]:
    return IN_CONTACT if scenario in TOUCHING else FREE


@dataclass(frozen=True)
class Flight:
    """A baseline flight: commands of robots, each held for `interval` [s]."""

    scenario: str
    own: str  # name of the scenario's integrator
    own_dt: float
    interval: float
    commands: dict[str, Reals]  # of each robot that takes any: (intervals, size); rotors in rad/s
    start: Reals  # (bodies, 13) as the flight log has it

    @property
    def count(self) -> int:
        return len(next(iter(self.commands.values())))


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
    block = re.search(r"^stepping:\n((?: .*\n)+)", log["text"], re.MULTILINE)
    values = dict(re.findall(r"^ +(\w+): (\S+)$", block[1] if block else "", re.MULTILINE))
    own = values.get("integrator", "midpoint")
    method = values.get("method", "auto")
    name = DEFAULTS.get(own, own) if method == "auto" else f"{own} {method}"
    return log["dt"], log["action_repeat"], name


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
                "commands": of_robots(episode, "command") | of_robots(episode, "rotor_command"),
                "bodies": episode["bodies"][:],
                "near": episode["near"][:],
            }


def of_robots(episode: h5py.Group, name: str) -> dict[str, Reals]:
    """A dataset of the log by robot, from the first action on. Columns are called ROBOT.WHAT."""
    if name not in episode:  # of width 0
        return {}
    dataset = episode[name]
    owners = [str(column).split(".", 1)[0] for column in dataset.attrs["columns"]]
    return {
        robot: dataset[1:][:, [i for i, owner in enumerate(owners) if owner == robot]]
        for robot in dict.fromkeys(owners)
    }


def baseline(scenario: str) -> Flight:
    dt, repeat, own = stepping_of(scenario)
    interval_us = math.lcm(round(1e6 * dt * repeat), max(STEPS_US))
    held = round(interval_us / (1e6 * dt))
    count = math.ceil(1e6 * FLIGHT / interval_us)
    changes = [f"stepping.action_repeat={held}", "stepping.horizon=0"]
    extra = math.ceil(1e6 * APPROACH / interval_us) if scenario in CLOSING else 0
    log = fly_and_log(scenario, count + extra, changes)
    begin = 0
    if scenario in CLOSING:
        begin = max(int(np.flatnonzero(log["near"])[0]) - math.ceil(1e6 * LEAD / interval_us), 0)
    commands = {robot: rows[begin : begin + count] for robot, rows in log["commands"].items()}
    if any(len(rows) < count for rows in commands.values()):
        sys.exit(f"{scenario}: the baseline flight ends before {FLIGHT:g} s")
    if scenario not in TOUCHING:
        factors = dashes(count, 1e-6 * interval_us)
        commands = {r: rows * factors[:, : rows.shape[1]] for r, rows in commands.items()}
    return Flight(scenario, own, dt, 1e-6 * interval_us, commands, log["bodies"][begin])


def dashes(count: int, interval: float) -> Reals:
    """Factors of commands, (intervals, MOST_COMMANDS): every robot takes the first ones, so that a
    formation keeps its shape."""
    random = np.random.default_rng(SEED)
    held = max(1, round(DASH_TIME / interval))
    shape = (math.ceil(count / held), MOST_COMMANDS)
    return np.repeat(random.uniform(1.0 - DASH, 1.0 + DASH, shape), held, axis=0)[:count]


class Replay:
    """Flies the commands of a flight again, open loop."""

    def __init__(self, flight: Flight, dt: float, overrides: tuple[str, ...]) -> None:
        changes = [f"stepping.dt={dt:g}", "stepping.action_repeat=1", *overrides]
        if flight.scenario not in GROUNDED:
            changes.append("contact.ground=false")
        self.flight = flight
        self.repeats = round(flight.interval / dt)
        probe = skybody.Simulation(flight.scenario)
        have_rotors = {path.split(".")[1] for path in probe.state_paths() if ".rotors." in path}
        motors = CONTROL_MODES["rotor_speed"]
        changes += [f"robots.{robot}.controllers={motors}" for robot in have_rotors]
        self.world = skybody.Simulation(flight.scenario, seed=SEED, overrides=changes)

    def reset(self) -> None:
        self.world.reset(seed=SEED)
        if self.flight.scenario in CLOSING:  # robots of one free body each
            for robot, state in zip(self.flight.commands, self.flight.start, strict=True):
                self.world.teleport(state[:3], state[3:7], state[7:10], state[10:], robot=robot)
        if not np.array_equal(motion(self.world)[:, :7], self.flight.start[:, :7]):
            sys.exit(f"{self.flight.scenario}: a replay does not begin as the flight did")

    def fly(self) -> float:
        """Time that it took [s]."""
        return self.time_of(self.repeats)

    def cost(self, flown: float, trials: int) -> float:
        """Time of the flight's physics steps [s], without the calls from Python."""
        if flown < LONG:
            flown = min([flown, *(self.fly() for _ in range(trials - 1))])
        return max(flown - min(self.time_of(0) for _ in range(trials)), 0.0)

    def time_of(self, physics_steps: int) -> float:
        """Time of all commands from the start, each with so many physics steps behind it [s]."""
        self.reset()
        began = time.perf_counter()
        for row in range(self.flight.count):
            self.command(row)
            if not self.world.advance(physics_steps):
                break
        return time.perf_counter() - began

    def command(self, row: int) -> None:
        for robot, rows in self.flight.commands.items():
            self.world.command(rows[row], robot)

    def first_touch(self) -> float | None:
        """When anything touches, to a physics step [s]."""
        self.reset()
        for row in range(self.flight.count):
            self.command(row)
            for _ in range(self.repeats):
                if not self.world.advance(1):
                    return None
                if self.world.contacts():
                    return float(self.world.time)
        return None


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
        total += mass.mass * GRAVITY * center[2]
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


def end_of(flight: Flight, reference: Reference) -> tuple[Reals, float]:
    """Motion and energy after the flight by a reference."""
    replay = Replay(flight, reference.dt, reference.overrides)
    replay.fly()
    if replay.world.fault:
        sys.exit(f"{flight.scenario}: a reference gives up")
    return motion(replay.world), energy(replay.world)


def reference_error(flight: Flight) -> float:
    """Largest distance between two references [m]."""
    first, second = (end_of(flight, exact)[0] for exact in references(flight.scenario))
    return float(np.linalg.norm(first[:, :3] - second[:, :3], axis=1).max())


def audit(flight: Flight, steps_us: tuple[int, ...], trials: int) -> list[Result]:
    exact, exact_energy = end_of(flight, references(flight.scenario)[0])
    results = []
    for integrator in INTEGRATORS:
        for us in steps_us:
            replay = Replay(flight, 1e-6 * us, integrator.overrides)
            flown = replay.fly()
            here, fault = motion(replay.world), bool(replay.world.fault)
            here_energy = energy(replay.world)
            cost = replay.cost(flown, trials) / (flight.count * flight.interval)
            results.append(
                Result(
                    flight.scenario,
                    integrator.name,
                    1e-6 * us,
                    fault,
                    float(np.linalg.norm(here[:, :3] - exact[:, :3], axis=1).max()),
                    float(turned(here[:, 3:7], exact[:, 3:7]).max()),
                    here_energy - exact_energy,
                    cost,
                )
            )
    return results


def first_touch(flight: Flight) -> float | None:
    """When things touch in it [s], by midpoint at 1 ms."""
    return Replay(flight, 1e-3, fixed("midpoint").overrides).first_touch()


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
    parser = arguments(__doc__)
    parser.add_argument("--only", nargs="+", choices=shipped(), metavar="NAME")
    options = parser.parse_args()
    if options.only and options.out:
        parser.error("--only prints and writes nothing: leave --out away, or audit all")
    folder = None if options.only else output_folder(parser, options)
    names = options.only or (list(QUICK) if options.quick else shipped())
    flights, results = [], []
    for name in names:
        flight = baseline(name)
        found = audit(flight, QUICK_STEPS_US if options.quick else STEPS_US, TRIALS)
        print_scenario(flight, found)
        flights.append(flight)
        results += found
    if folder is None:
        return
    content = facts() | {
        "good": {"position": GOOD_POSITION, "angle": GOOD_ANGLE},
        "flights": [
            {
                "scenario": f.scenario,
                "own": f.own,
                "own_dt": f.own_dt,
                "interval": f.interval,
                "reference_error": reference_error(f),
                "first_touch": first_touch(f),
            }
            for f in flights
        ],
        "results": [asdict(r) | {"is_good": r.is_good} for r in results],
    }
    write_json(folder / "data/integrator_audit.json", content)
    write_page(content, folder / "integrators.md")
    write_picture(content, folder / "images/integrator_audit.png")


if __name__ == "__main__":
    run_program(main)
