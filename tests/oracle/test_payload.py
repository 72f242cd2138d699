"""A vehicle with a bob on a rod against SciPy: wild commands."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import skybody
from chain import SIZE, Chain, fly, read_chain, start
from rigid_body import Reals, angle_between

ROOT = Path(__file__).resolve().parents[2]
HOLD = 0.02  # duration of a command [s]
DRAWS = 100  # commands: two seconds
LINKS = {"rod": "rod_joint_x", "bob": "bob_joint_x"}


@pytest.fixture(scope="module")
def payload() -> Chain:
    return read_chain(ROOT / "scenarios/models/qdrone2_payload", LINKS)


class Wild:
    """A random start and random commands from a seed, and the oracle's end state."""

    def __init__(self, chain: Chain, seed: int) -> None:
        random = np.random.default_rng(seed)
        self.y = np.zeros(SIZE)
        self.y[:3] = random.uniform(-1.0, 1.0, 3)
        attitude = np.array([1.0, 0.0, 0.0, 0.0]) + random.normal(0.0, 0.3, 4)
        self.y[3:7] = attitude / np.linalg.norm(attitude)
        self.y[7:10] = random.normal(0.0, 2.0, 3)
        self.y[10:] = random.normal(0.0, 1.5, 3)
        self.speed = float(random.uniform(800.0, 1800.0))
        self.commands = random.uniform(0.0, 2246.0, (DRAWS, 4))
        begun = start(chain, self.y)
        end = fly(chain, begun, np.full(4, self.speed), self.commands, HOLD)
        self.end = end.reshape(-1, SIZE)

    def error(self, integrator: str, dt: float) -> tuple[float, float]:
        """The largest errors of the vehicle's and the bob's position [m] and attitude [rad]."""
        flown = self.by_skybody(integrator, dt)
        position = max(
            float(np.linalg.norm(flown[k][:3] - self.end[body][:3])) for k, body in ((0, 0), (1, 2))
        )
        angle = max(
            angle_between(flown[k][3:], self.end[body][3:7]) for k, body in ((0, 0), (1, 2))
        )
        return position, angle

    def by_skybody(self, integrator: str, dt: float) -> list[Reals]:
        overrides = [
            "contact.ground=false",
            "randomization=[]",
            f"stepping.dt={dt}",
            f"stepping.integrator={integrator}",
            f"robots.quad.rotor_speed={self.speed!r}",
        ]
        sim = skybody.Simulation("payload", control="rotor_speed", overrides=overrides)
        sim.reset()
        y = self.y
        sim.teleport(position=y[:3], rotation=y[3:7], velocity=y[7:10], angular_velocity=y[10:])
        for command in self.commands:
            sim.command(command)
            assert sim.advance(round(HOLD / dt))
        return [
            np.concatenate([body.position, body.rotation])
            for body in (sim.base(), sim.body(link="bob"))
        ]


@pytest.fixture(scope="module", params=range(3))
def wild(payload: Chain, request: pytest.FixtureRequest) -> Wild:
    return Wild(payload, request.param)


def test_midpoint_is_exact_at_a_millisecond(wild: Wild) -> None:
    position, angle = wild.error("midpoint", 1e-3)
    # These three differ by at most 0.14 mm and 0.044 degrees; the limit is the project's.
    assert position < 1e-3
    assert angle < math.radians(0.1)


def test_rk4_agrees_with_the_oracle_to_a_micrometre(wild: Wild) -> None:
    position, angle = wild.error("rk4", 1e-3)
    assert position < 1e-6
    assert angle < 1e-6


def test_midpoint_is_of_second_order(wild: Wild) -> None:
    # At these steps no bob spins fast (test_free_flight.py).
    coarse, fine = (wild.error("midpoint", dt) for dt in (5e-4, 2.5e-4))
    # Half the step divides the error by 4, except for terms of higher order.
    assert coarse[0] / fine[0] == pytest.approx(4.0, rel=0.3)
