"""Three vehicles that carry a plate on rods, and a pendulum, against SciPy."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import skybody
from rigid_body import Reals, angle_between, read_vehicle
from scipy.integrate import solve_ivp
from team import SIZE, Member, Rod, Team

ROOT = Path(__file__).resolve().parents[2]
HOLD = 0.02  # duration of a command [s]
NAMES = ("alpha", "bravo", "charlie", "load")
PLACES = ((0.55, 0.0, 2.5), (-0.275, 0.476, 2.5), (-0.275, -0.476, 2.5), (0.0, 0.0, 1.4))
EARS = ((0.38, 0.0, 0.05), (-0.19, 0.33, 0.05), (-0.19, -0.33, 0.05))
HOVER = 1400.0  # [rad/s], approximately


@pytest.fixture(scope="module")
def team() -> Team:
    vehicle = read_vehicle(ROOT / "scenarios/models/qdrone2")
    flyer = Member(vehicle.mass, vehicle.com, vehicle.inertia, vehicle)
    plate = Member(1.2, np.zeros(3), np.diag([0.065, 0.065, 0.128]))
    below = np.array([0.0, 0.0, -0.05])
    rods = [Rod((i, 3), (below, np.array(ear))) for i, ear in enumerate(EARS)]
    return Team([flyer, flyer, flyer, plate], rods)


def start() -> Reals:
    states = np.zeros((4, SIZE))
    states[:, :3] = PLACES
    states[:, 3] = 1.0
    return states.ravel()


def by_skybody(commands: Reals, dt: float, dynamics: str = "tree") -> list[skybody.BodyState]:
    overrides = [
        "contact.ground=false",
        "randomization=[]",
        f"stepping.dt={dt}",
        f"stepping.dynamics={dynamics}",
        *(f"robots.{name}.rotor_speed={HOVER}" for name in NAMES[:3]),
        *(f"robots.{name}.controllers.motors.parameters.max_speed=2246" for name in NAMES[:3]),
    ]
    sim = skybody.Simulation("cooperative_payload", overrides=overrides)
    sim.reset()
    for wanted in commands:
        for name, command in zip(NAMES, wanted, strict=False):
            sim.command(command, robot=name)
        assert sim.advance(round(HOLD / dt))
    return [sim.base(name) for name in NAMES]


def errors(flown: list[skybody.BodyState], end: Reals) -> tuple[float, float]:
    """The largest errors of all bodies' positions [m] and attitudes [rad]."""
    states = end.reshape(-1, SIZE)
    pairs = list(zip(flown, states, strict=True))
    position = max(float(np.linalg.norm(body.position - s[:3])) for body, s in pairs)
    return position, max(angle_between(np.array(body.rotation), s[3:7]) for body, s in pairs)


@pytest.mark.parametrize("seed", [0, 1])
def test_wild_commands_end_where_the_oracle_does(team: Team, seed: int) -> None:
    random = np.random.default_rng(seed)
    commands = HOVER * random.uniform(0.7, 1.3, (30, 3, 4))  # 0.6 s
    end = team.fly(start(), [np.full(4, HOVER)] * 3 + [np.zeros(0)], commands, HOLD)
    position, angle = errors(by_skybody(commands, 1e-3), end)
    assert position < 1e-4 and angle < math.radians(0.05)
    # Second order: half the step gives a quarter of the error, within the oracle's accuracy.
    coarse, _ = errors(by_skybody(commands, 2e-3), end)
    assert 2.5 < coarse / position < 6.0


def test_simbodys_constraints_end_there_too(team: Team) -> None:
    random = np.random.default_rng(2)
    commands = HOVER * random.uniform(0.7, 1.3, (10, 3, 4))
    end = team.fly(start(), [np.full(4, HOVER)] * 3 + [np.zeros(0)], commands, HOLD)
    position, angle = errors(by_skybody(commands, 1e-3, "simbody"), end)
    assert position < 1e-4 and angle < math.radians(0.05)


def test_a_four_bar_linkage_turns_as_its_one_degree_of_freedom_says() -> None:
    """Lagrange's equation for the crank's angle only; reduced masses by finite differences."""
    masses, moments = (0.2, 0.5, 0.4), (7e-4, 0.0105, 0.0054)

    def places(crank: float) -> Reals:
        """x, z of the three centres of mass, and the bars' angles."""
        pin = 0.2 * np.array([math.cos(crank), math.sin(crank)])
        apart = np.array([0.5, 0.0]) - pin
        d = float(np.linalg.norm(apart))
        along = (0.25 - 0.16 + d * d) / (2.0 * d)
        aside = math.sqrt(0.25 - along * along)
        unit = apart / d
        top = pin + along * unit + aside * np.array([-unit[1], unit[0]])
        coupler = math.atan2(top[1] - pin[1], top[0] - pin[0])
        rocker = math.atan2(top[1], top[0] - 0.5)
        middles = (0.5 * pin, 0.5 * (pin + top), 0.5 * (np.array([0.5, 0.0]) + top))
        return np.concatenate([*middles, [crank, coupler, rocker]])

    def slopes(crank: float, order: int) -> Reals:
        h = 1e-4
        if order == 1:
            return (places(crank + h) - places(crank - h)) / (2.0 * h)
        return (places(crank + h) - 2.0 * places(crank) + places(crank - h)) / (h * h)

    weights = np.array([m for m in masses for _ in range(2)] + list(moments))
    heights = np.array([w * 9.81 if i % 2 else 0.0 for i, w in enumerate(weights[:6])] + [0.0] * 3)

    def rate(_: float, y: Reals) -> list[float]:
        first, second = slopes(y[0], 1), slopes(y[0], 2)
        inertia = float(weights @ (first * first))
        force = -float(heights @ first) - float(weights @ (first * second)) * y[1] ** 2
        return [y[1], force / inertia]

    end = solve_ivp(rate, (0.0, 2.0), [0.0, 0.0], method="DOP853", rtol=1e-9, atol=1e-10).y[:, -1]
    idle = ["robots.linkage.controllers.motor.parameters.damping=1e-12", "randomization=[]"]
    sim = skybody.Simulation("four_bar", overrides=idle)
    sim.reset()
    assert sim.advance(2000)
    angle = float(sim.state("robots.linkage.joints.crank_pin.position"))
    rate_of = float(sim.state("robots.linkage.joints.crank_pin.velocity"))
    assert abs(end[0]) > 1.0  # it has swung
    assert angle == pytest.approx(end[0], abs=1e-4)
    assert rate_of == pytest.approx(end[1], abs=1e-3)
