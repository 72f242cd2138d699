"""One environment under direct control from Python."""

from __future__ import annotations

import numpy as np
import pytest
import skybody
from skybody._native import CompiledScenario, Simulation

ACTION = np.full(4, 0.2, np.float32)
MASS = "robots.quad.links.base_link.mass"


@pytest.fixture
def simulation(hover: CompiledScenario) -> Simulation:
    simulation = Simulation(hover, seed=3)
    simulation.reset()
    return simulation


def test_time_and_steps_count(simulation: Simulation) -> None:
    for _ in range(5):
        simulation.step(ACTION)
    assert simulation.episode == 1
    assert simulation.steps == 5
    assert simulation.time == pytest.approx(0.005, rel=1e-12)  # five sums of 1 ms round slightly
    assert not (simulation.terminated or simulation.truncated or simulation.fault)


def test_the_scenario_may_be_named() -> None:
    simulation = Simulation("hover", seed=3)
    simulation.reset()
    assert simulation.compiled.name == "hover"


def test_equal_keys_give_equal_flights(hover: CompiledScenario) -> None:
    hashes = []
    for seed in (3, 3, 4):
        simulation = Simulation(hover, seed=seed)
        simulation.reset()
        simulation.step(ACTION)
        hashes.append(simulation.hash())
    assert hashes[0] == hashes[1] != hashes[2]


def test_bodies_have_unit_quaternions_and_the_position_of_the_link(simulation: Simulation) -> None:
    simulation.step(ACTION)
    body = simulation.body("base_link")
    assert np.linalg.norm(body.rotation) == pytest.approx(
        1.0, abs=1e-12
    )  # rounding of a sum of squares
    np.testing.assert_array_equal(body.position, simulation.bodies[0].position)
    assert body.velocity.shape == body.angular_velocity.shape == (3,)
    with pytest.raises(ValueError, match="base_link"):
        simulation.body("tail")


def test_observations_are_copies(simulation: Simulation) -> None:
    before = simulation.observation
    kept = before.copy()
    for _ in range(10):
        simulation.step(ACTION)
    np.testing.assert_array_equal(before, kept)
    assert (simulation.observation != kept).any()


def test_saved_and_forked_have_the_same_future(simulation: Simulation) -> None:
    simulation.step(ACTION)
    saved = simulation.save()
    fork = simulation.fork()
    futures = []
    for each in (simulation, fork):
        for _ in range(5):
            each.step(ACTION)
        futures.append(each.observation)
    simulation.restore(saved)
    for _ in range(5):
        simulation.step(ACTION)
    np.testing.assert_array_equal(futures[0], futures[1])
    np.testing.assert_array_equal(futures[0], simulation.observation)


def test_a_snapshot_of_another_scenario_is_refused(simulation: Simulation) -> None:
    other = Simulation(CompiledScenario("hover", ["stepping.horizon=9"]))
    other.reset()
    with pytest.raises(ValueError, match="another scenario"):
        simulation.restore(other.save())


def test_parameters_are_held_to_their_bounds(simulation: Simulation) -> None:
    simulation.set_param(MASS, 2.0)
    assert simulation.param(MASS) == 2.0
    with pytest.raises(ValueError, match="outside"):
        simulation.set_param(MASS, -1.0)
    with pytest.raises(ValueError, match="`wings`"):
        simulation.param("wings")


def test_wrong_actions_are_refused(simulation: Simulation) -> None:
    with pytest.raises(TypeError, match="action has dtype float64; expected float32"):
        simulation.step(np.zeros(4))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"action has shape \(3,\); expected \(4,\)"):
        simulation.step(np.zeros(3, np.float32))


def test_a_step_before_the_first_reset_is_refused(hover: CompiledScenario) -> None:
    with pytest.raises(skybody.Error, match="before reset"):
        Simulation(hover).step(ACTION)


def test_a_non_finite_action_ends_the_episode_as_a_fault(simulation: Simulation) -> None:
    simulation.step(np.array([np.nan, 0, 0, 0], np.float32))
    assert simulation.fault and simulation.truncated and not simulation.terminated
    assert np.isfinite(simulation.observation).all()
