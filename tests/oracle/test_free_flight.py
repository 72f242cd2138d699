"""Free flight against SciPy: wild commands, and a body spinning without torque."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
import skybody
from rigid_body import Reals, Vehicle, angle_between, fly, read_vehicle

ROOT = Path(__file__).resolve().parents[2]
HOLD = 0.02  # duration of a command [s]
DRAWS = 100  # commands: two seconds


@pytest.fixture(scope="module")
def qdrone2() -> Vehicle:
    return read_vehicle(ROOT / "scenarios/models/qdrone2")


class Wild:
    """A random start and random commands from a seed, and the oracle's end state."""

    def __init__(self, vehicle: Vehicle, seed: int) -> None:
        random = np.random.default_rng(seed)
        self.y = np.zeros(13)
        self.y[:3] = random.uniform(-1.0, 1.0, 3)
        attitude = random.normal(size=4)
        self.y[3:7] = attitude / np.linalg.norm(attitude)
        self.y[7:10] = random.normal(0.0, 2.0, 3)
        self.y[10:13] = random.normal(0.0, 3.0, 3)
        self.speed = float(random.uniform(800.0, 1800.0))
        self.commands = random.uniform(0.0, 2246.0, (DRAWS, 4))
        self.end = fly(vehicle, self.y, np.full(4, self.speed), self.commands, HOLD)

    def error(self, integrator: str, dt: float) -> tuple[float, float]:
        """Errors of position [m] and attitude [rad] at the end."""
        end = self.by_skybody(integrator, dt)
        return float(np.linalg.norm(end[:3] - self.end[:3])), angle_between(end[3:7], self.end[3:7])

    def by_skybody(self, integrator: str, dt: float) -> Reals:
        overrides = [
            "contact.ground=false",
            "randomization=[]",
            f"stepping.dt={dt}",
            f"stepping.integrator={integrator}",
            f"robots.quad.rotor_speed={self.speed!r}",
        ]
        sim = skybody.Simulation("hover", control="rotor_speed", overrides=overrides)
        sim.reset()
        y = self.y
        sim.teleport(position=y[:3], rotation=y[3:7], velocity=y[7:10], angular_velocity=y[10:13])
        for command in self.commands:
            sim.command(command)
            assert sim.advance(round(HOLD / dt))
        base = sim.base()
        return np.concatenate([base.position, base.rotation, base.velocity, base.angular_velocity])


@pytest.fixture(scope="module", params=range(4))
def wild(qdrone2: Vehicle, request: pytest.FixtureRequest) -> Wild:
    return Wild(qdrone2, request.param)


def test_midpoint_is_exact_at_a_millisecond(wild: Wild) -> None:
    position, angle = wild.error("midpoint", 1e-3)
    # These four differ by at most 0.074 mm and 0.001 degrees; the limit leaves room for flights
    # that tumble more.
    assert position < 0.3e-3
    assert angle < math.radians(0.02)


def test_midpoint_is_of_second_order(wild: Wild) -> None:
    # At these steps hardly any flight spins fast (core/physics/step/integration_rules.h). Where the
    # rule applies torque-free motion instead, its error differs in size but is of the same order.
    errors = [wild.error("midpoint", dt) for dt in (1e-3, 5e-4, 2.5e-4)]
    for coarse, fine in itertools.pairwise(errors):
        # Half the step divides the error by 4, except for terms of higher order.
        assert coarse[0] / fine[0] == pytest.approx(4.0, rel=0.25)
        assert coarse[1] / fine[1] == pytest.approx(4.0, rel=0.25)


def test_rk4_agrees_with_the_oracle_to_a_micrometre(wild: Wild) -> None:
    position, angle = wild.error("rk4", 1e-3)
    assert position < 1e-6
    assert angle < 1e-6


def test_semi_implicit_euler_is_of_first_order(wild: Wild) -> None:
    coarse, fine = (wild.error("semi_implicit_euler", dt) for dt in (1e-3, 0.5e-3))
    assert coarse[0] / fine[0] == pytest.approx(2.0, rel=0.1)
    assert coarse[1] / fine[1] == pytest.approx(2.0, rel=0.1)


def test_a_free_spin_keeps_its_energy_for_a_minute(qdrone2: Vehicle) -> None:
    """Tumbling in free fall, rotors at rest."""
    given = ["contact.ground=false", "randomization=[]", "robots.quad.rotor_speed=0"]
    sim = skybody.Simulation("hover", control="rotor_speed", overrides=given)
    sim.reset()
    spin = np.array([4.0, 5.0, 3.0])
    sim.teleport(position=[0, 0, 2], velocity=[0, 0, 0], angular_velocity=spin)
    before = 0.5 * spin @ qdrone2.inertia @ spin
    for _ in range(60):
        assert sim.advance(1000)
        now = np.array(sim.base().angular_velocity)
        assert 0.5 * now @ qdrone2.inertia @ now == pytest.approx(before, rel=1e-5)
