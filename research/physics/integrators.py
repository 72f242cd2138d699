"""Accuracy and cost of integrators and time steps.

    python -m research run integrators [--only NAME...] [--quick] [--out FOLDER]

A scenario's baseline flight (`skybody run`, 1 s, commands held for the least common multiple of its
action interval and the largest step) provides the commands: of rotors, and of other actuators if a
robot has no rotors. They are made aggressive: each is multiplied by factors drawn every 0.1 s,
equal for every robot, without a ground. Two flights are flown unchanged: hard_landing, onto the
ground, and collision, which begins LEAD before the robots touch in the scenario's own flight.
All are flown open loop, with every integrator and step. The reference is CVODE at a tight
tolerance, or very small steps in contact. So the integrator is audited, not the controller's rate.
Writes integrators.md, its JSON and picture.
--quick: five scenarios, two steps. --only: prints only the table.
"""

from __future__ import annotations

import math
import sys
import time
from dataclasses import asdict, dataclass

import numpy as np
import skybody
from skybody.simulation import CONTROL_MODES

from research.common.machine import facts
from research.common.options import Options
from research.common.pages import write_page
from research.physics.integrator_flights import (
    CLOSING,
    SEED,
    STEPS_US,
    Flight,
    Reals,
    baseline,
    shipped,
)
from research.physics.integrator_report import page, write_picture

PAGE = "integrators"

GRAVITY = 9.81  # of every shipped scenario [m/s^2]
QUICK_STEPS_US = (1000, 4000)
TRIALS = 4
LONG = 0.5  # a longer flight [s] is timed once, since noise is then small
GOOD_POSITION, GOOD_ANGLE = 1e-3, math.radians(0.1)  # limits of exactness [m], [rad]
GROUNDED = ("hard_landing",)  # flown onto the ground; others in free air
QUICK = ("hover", "payload", "boom", "collision", "four_bar")


@dataclass(frozen=True)
class Integrator:
    """One way of advancing the state: its name in tables, and its overrides of the scenario."""

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
            "stepping.solver.relative_tolerance=1e-8",  # the defaults, whatever the scenario sets
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


def reference(method: str, tolerance: float) -> tuple[str, ...]:
    """Overrides for accurate CVODE."""
    return (
        "stepping.integrator=cvode",
        f"stepping.solver.method={method}",
        f"stepping.solver.relative_tolerance={tolerance:g}",
        f"stepping.solver.absolute_tolerance={1e-2 * tolerance:g}",
        "stepping.solver.max_steps=1000000",
    )


@dataclass(frozen=True)
class Reference:
    """The reference of a flight."""

    dt: float  # [s]
    overrides: tuple[str, ...]


COARSE = 1e-6 * max(STEPS_US)
# The distance between two references is a measure of their accuracy. Contact is a correction of
# each step, independent of the integrator (docs/contact.md): in contact only small steps are
# accurate.
FREE = (Reference(COARSE, reference("bdf", 1e-10)), Reference(COARSE, reference("adams", 1e-11)))
IN_CONTACT = (
    Reference(2.5e-5, fixed("rk4").overrides),
    Reference(5e-5, fixed("rk4").overrides),
)


def references(flight: Flight) -> tuple[Reference, Reference]:
    return FREE if first_touch(flight) is None else IN_CONTACT


@dataclass(frozen=True)
class Result:
    """One scenario, one integrator, one step; errors against the reference after 1 s."""

    scenario: str
    integrator: str
    dt: float
    fault: bool
    position: float  # largest of all bodies' origins [m]
    angle: float  # largest of all bodies [rad]
    energy: float  # mechanical energy minus the reference's [J]
    cost: float  # time per simulated second of one environment [s]

    @property
    def is_good(self) -> bool:
        return not self.fault and self.position < GOOD_POSITION and self.angle < GOOD_ANGLE


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
        if self.flight.scenario in CLOSING:  # robots with one free body each
            for robot, state in zip(self.flight.commands, self.flight.start, strict=True):
                self.world.teleport(state[:3], state[3:7], state[7:10], state[10:], robot=robot)
        if not np.array_equal(motion(self.world)[:, :7], self.flight.start[:, :7]):
            sys.exit(f"{self.flight.scenario}: a replay does not begin as the flight did")

    def fly(self) -> float:
        """Flies it; returns the time [s]."""
        return self.time_of(self.repeats)

    def cost(self, flown: float, trials: int) -> float:
        """Time of the flight's physics steps [s], without the calls from Python."""
        if flown < LONG:
            flown = min([flown, *(self.fly() for _ in range(trials - 1))])
        return max(flown - min(self.time_of(0) for _ in range(trials)), 0.0)

    def time_of(self, physics_steps: int) -> float:
        """Time of all commands from the start, each followed by so many physics steps [s]."""
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
        """Time of the first contact, to a physics step [s]."""
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
    """Kinetic and gravitational energy of all bodies [J], without springs."""
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
    """Motion and energy after the flight with a reference."""
    replay = Replay(flight, reference.dt, reference.overrides)
    replay.fly()
    if replay.world.fault:
        sys.exit(f"{flight.scenario}: a reference gives up")
    return motion(replay.world), energy(replay.world)


def reference_error(flight: Flight) -> float:
    """Largest distance between two references [m]."""
    first, second = (end_of(flight, exact)[0] for exact in references(flight))
    return float(np.linalg.norm(first[:, :3] - second[:, :3], axis=1).max())


def audit(flight: Flight, steps_us: tuple[int, ...], trials: int) -> list[Result]:
    exact, exact_energy = end_of(flight, references(flight)[0])
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
    """Time of the first contact in the flight [s], by midpoint at 1 ms."""
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
    options = (
        Options(__doc__, __name__, "five scenarios, two steps")
        .add("--only", nargs="+", choices=shipped(), metavar="NAME", help="print their errors")
        .given()
    )
    names = options.only or (list(QUICK) if options.quick else shipped())
    flights, results = [], []
    for name in names:
        flight = baseline(name)
        found = audit(flight, QUICK_STEPS_US if options.quick else STEPS_US, TRIALS)
        print_scenario(flight, found)
        flights.append(flight)
        results += found
    if options.only:
        return
    content = facts() | {
        "good": {"position": GOOD_POSITION, "angle": GOOD_ANGLE},
        "flights": [
            {name: getattr(f, name) for name in ("scenario", "own", "own_dt", "interval")}
            | {"reference_error": reference_error(f), "first_touch": first_touch(f)}
            for f in flights
        ],
        "results": [asdict(r) | {"is_good": r.is_good} for r in results],
    }
    write_page(options.out, PAGE, page(content), content)
    write_picture(content, options.out / "images/integrators.png")
