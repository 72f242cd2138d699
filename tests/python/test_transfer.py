"""Rows, networks, estimates and adapters of research/transfer, beside the engine's own."""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from skybody import CompiledScenario, Simulation
from skybody._native import PolicyNetwork

from research.transfer import (
    conditions,
    flight,
    inner_loop,
    network,
    quadrotor,
    race,
    references,
    rotation,
)
from research.transfer import transfer as measurement
from research.transfer.estimator import Estimator
from research.transfer.observation import Motion, Rows

QUAD = quadrotor.read()
PACKAGES = {name: package for name, (package, _) in measurement.ENGINES.items()}
ROUND_OFF = 2e-6  # of float32 rows with entries near 1


def motion_of(simulation: Simulation) -> Motion:
    body = simulation.base()
    attitude = rotation.matrix(np.array(body.rotation)[None])
    vectors = (body.position, body.velocity, body.angular_velocity)
    position, velocity, rates = (np.array(vector)[None] for vector in vectors)
    return Motion(position, velocity, attitude, rates)


def trajectory(scenario: str, figures: references.Figures) -> Simulation:
    """A simulation on the first of the figures."""
    path = {name: getattr(figures, name)[0].tolist() for name in ("centre", "amplitude", "phase")}
    path |= {"cycles": figures.cycles[0].astype(int).tolist(), "peak_speed": figures.peak[0]}
    path |= {"along": 0.0}
    overrides = [f"task.parameters.{name}={value}" for name, value in path.items()]
    return Simulation(scenario, overrides=["randomization=[]", *overrides], seed=1)


@pytest.mark.parametrize(("scenario", "actions"), [("trajectory", 4), ("trajectory_modular", 3)])
def test_rows_of_trajectory_are_those_of_the_engine(scenario: str, actions: int) -> None:
    figures = references.draw(1)
    simulation = trajectory(scenario, figures)
    simulation.reset()
    rows = Rows(figures, actions)
    random = np.random.default_rng(1)
    for step in range(230):  # beyond the ramp, and longer than the history
        row = rows.row(0.01 * step, motion_of(simulation))
        assert np.allclose(row[0], simulation.observation, rtol=0, atol=10 * ROUND_OFF)
        # Near hover, so that the vehicle stays in the box.
        action = np.float32(0.25 if actions == 4 else 0.0) + 0.05 * random.standard_normal(actions)
        rows.action = action[None].astype(np.float32).astype(float)
        simulation.step(action.astype(np.float32))
    assert not simulation.terminated


def test_rows_of_the_race_are_those_of_the_engine() -> None:
    course = race.draw(1, 1)[0]
    nominal = np.array([[float(x) for x in row[1].split(",")] for row in gates()])
    course = race.Course(nominal[None], course.yaws, course.size)
    simulation = Simulation("racing", overrides=["randomization=[]"], seed=1)
    simulation.reset()
    action = np.full((1, 4), -1.0)
    for _ in range(20):
        row = race.row(course, np.zeros(1, int), motion_of(simulation), action)
        assert np.allclose(row[0], simulation.observation, rtol=0, atol=10 * ROUND_OFF)
        action = np.array([[-0.2, 0.1, 0.05, 0.2]], np.float32).astype(float)
        simulation.step(action[0].astype(np.float32))


def gates() -> list[tuple[str, ...]]:
    return race.GATE.findall(race.SCENARIO.read_text(encoding="utf-8"))


def test_a_race_has_the_gates_of_the_scenario() -> None:
    assert len(gates()) == len(CompiledScenario("racing").obstacles)


@pytest.mark.parametrize("file", [*measurement.POLICIES.values(), measurement.RACE_POLICY])
def test_actions_are_those_of_the_engine(file: Path) -> None:
    arrays = network.arrays_of(file)
    rows = np.random.default_rng(1).standard_normal((5, len(arrays["mean"]))).astype(np.float32)
    rows = (rows / arrays["scale"] + arrays["mean"]).astype(np.float32)
    native = PolicyNetwork(str(file)).act(rows)
    # The engine's are in float.
    assert np.allclose(network.Network(arrays)(rows), native, rtol=0, atol=1e-5)


def test_references_are_those_of_the_task() -> None:
    figures = references.draw(1)
    simulation = trajectory("trajectory", figures)
    simulation.reset()
    begin = np.array(simulation.base().position) + simulation.observation[400:403]
    assert np.allclose(begin, figures.begin()[0], atol=ROUND_OFF)


def test_references_are_smooth() -> None:
    figures = references.draw()
    time = np.linspace(0.0, 6.0, 60001)
    position, velocity, acceleration = figures.at(time)
    step = time[1]
    for part, rate in ((position, velocity), (velocity, acceleration)):
        slope = (part[:, 2:] - part[:, :-2]) / (2.0 * step)
        assert np.allclose(slope, rate[:, 1:-1], atol=1e-6)  # central differences: step^2
    assert np.all(np.linalg.norm(velocity, axis=2).max(axis=1) <= figures.peak * 1.002)


def test_quaternions_and_matrices_are_inverse_even_at_half_turns() -> None:
    turns = np.random.default_rng(1).standard_normal((50, 4))
    turns = np.vstack([turns, np.eye(4)])
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    back = rotation.of_matrix(rotation.matrix(turns))
    assert np.allclose(np.abs((back * turns).sum(axis=1)), 1.0, atol=1e-12)


def test_allocated_speeds_make_the_wrench() -> None:
    thrust, torque = np.array([15.0]), np.array([[0.2, -0.3, 0.05]])
    made = QUAD.mixer @ inner_loop.allocated(QUAD, thrust, torque)[0] ** 2
    assert np.allclose(made, [15.0, 0.2, -0.3, 0.05])


def test_at_full_thrust_roll_and_pitch_remain_and_yaw_gives_way() -> None:
    thrust, torque = np.array([100.0]), np.array([[0.4, -0.3, 0.5]])
    speeds = inner_loop.allocated(QUAD, thrust, torque)[0]
    made = QUAD.mixer @ speeds**2
    assert speeds.max() <= QUAD.max_speed * (1.0 + 1e-12)
    assert np.allclose(made[1:3], [0.4, -0.3])
    assert 0.0 <= made[3] < 0.5


def truth_of(condition: conditions.Condition, flights: int = 40) -> conditions.Truth:
    return conditions.draw(condition, [1], flights)


def test_hidden_errors_are_within_ten_percent_of_a_rigid_body() -> None:
    truth = truth_of(conditions.HIDDEN)
    for factor in (truth.mass, truth.inertia, truth.lag):
        assert np.all(np.abs(factor - 1.0) <= 0.1)
        assert np.ptp(factor) > 0.1
    assert np.all(np.abs(truth.thrust - 1.0) <= 1.1 * 1.02 - 1.0)
    moments = truth.inertia * QUAD.inertia
    assert np.all(2.0 * moments.max(axis=1) < moments.sum(axis=1))


def test_plain_flights_have_nothing_to_draw() -> None:
    truth = truth_of(conditions.PLAIN)
    assert np.all(truth.thrust == 1.0)
    assert np.all(truth.air(3.0) == 0.0)


def circling(time: float) -> Motion:
    """On a circle of 1 m at 1 rad/s, leaning as a vehicle that flies it."""
    c, s = np.cos(time), np.sin(time)
    push = np.array([-c, -s, quadrotor.GRAVITY])
    attitude = rotation.matrix(rotation.tilted(push[None] / np.linalg.norm(push), np.zeros(1)))
    return Motion(np.array([[c, s, 1.0]]), np.array([[-s, c, 0.0]]), attitude, np.zeros((1, 3)))


def estimated(condition: conditions.Condition) -> tuple[Motion, Motion]:
    """Estimate and truth after a second."""
    dt = 0.002
    estimator = Estimator(condition, circling(0.0), dt, 1)
    for k in range(501):
        before, now = (circling(max(k - j, 0) * dt).attitude[0] for j in (1, 0))
        twist = (before.T @ now - now.T @ before) / (2.0 * dt)
        truth = circling(k * dt)
        truth.rates = np.array([[twist[2, 1], twist[0, 2], twist[1, 0]]])
        estimator.update(k * dt, truth)
    return estimator.estimate(500 * dt, np.full(1, np.hypot(quadrotor.GRAVITY, 1.0))), truth


def test_an_estimate_from_delayed_poses_is_of_now() -> None:
    estimate, truth = estimated(conditions.Condition(delay=0.015))
    # The line's age is 44 ms: the third order is 44 ms^3/6, and the mean of a bent line.
    assert np.allclose(estimate.position, truth.position, atol=1e-3)
    assert np.allclose(estimate.velocity, truth.velocity, atol=5e-3)
    assert np.allclose(estimate.attitude, truth.attitude, atol=1e-3)


def test_noise_of_poses_is_that_of_the_condition_in_estimates() -> None:
    noisy = dataclasses.replace(conditions.HIDDEN, rate_bias=0.0)
    estimate, truth = estimated(noisy)
    distance = np.abs(estimate.position - truth.position).max()
    assert 1e-6 < distance < 6 * noisy.position_noise


@pytest.mark.parametrize("name", list(measurement.ENGINES))
def test_engines_fly_alike(name: str) -> None:
    if importlib.util.find_spec(PACKAGES[name]) is None:
        pytest.skip(f"no package {PACKAGES[name]}")
    path = flown(name)
    assert np.allclose(path, flown("skybody"), atol=2e-3)  # steps of 2 ms; lags of two kinds
    assert np.linalg.norm(path[:, -1] - path[:, 0]) > 0.1


def flown(name: str) -> NDArray[np.float64]:
    """Half a second with three vehicles of other constants, towards the reference."""
    engine = importlib.import_module(f"research.transfer.engine_{name}")
    truth = truth_of(conditions.Condition(errors=0.1), 3)
    figures = references.draw(3)
    world = engine.Engine(QUAD, truth, flight.DT)
    policy = network.Network(network.arrays_of(measurement.POLICIES["modular", "shipped"]))
    given = (figures, truth, conditions.PLAIN, 0.5)
    result = flight.fly(world, QUAD, policy, flight.FORMS["modular"], *given)
    world.close()
    assert not result.failed.any()
    return result.flown


def test_a_gate_counts_only_in_its_opening_and_its_direction() -> None:
    course, _, _ = race.draw(3, 1)
    normal, side = course.across(np.zeros(3, int))
    centre = course.centres[:, 0]
    aside = side * np.array([[0.0], [1.0], [0.0]])
    before, after = centre - 0.1 * normal + aside, centre + 0.1 * normal + aside
    before[2], after[2] = after[2].copy(), before[2].copy()  # backwards
    passes, misses = race.advance(course, np.zeros(3, int), before, after)
    assert passes.tolist() == [True, False, False]
    assert misses.tolist() == [False, True, False]
