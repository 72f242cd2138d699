"""One world under direct control from Python."""

from __future__ import annotations

import gc
import threading

import numpy as np
import pytest
import skybody
from skybody._native import CompiledScenario
from skybody.simulation import CONTROL_MODES, Simulation

PLAIN = ["randomization=[]", "robots[0].pose.position=[0, 0, 2]"]


def flying(control: str | None = "ctbr", *more: str) -> Simulation:
    """Hover at (0, 0, 2), in equilibrium, after a reset."""
    simulation = Simulation("hover", control, overrides=[*PLAIN, *more])
    simulation.reset()
    return simulation


@pytest.mark.parametrize("mode", CONTROL_MODES)
def test_every_control_mode_takes_its_command(mode: str):
    simulation = flying(mode)
    size = {"wrench": 6, "velocity": 6, "attitude": 5, "trajectory": 17}.get(mode, 4)
    assert simulation.command_size() == size
    simulation.command(np.zeros(size))
    assert simulation.advance(20)
    assert np.isfinite(simulation.base().position).all()
    np.testing.assert_array_equal(simulation.commands, np.zeros(size))


def test_a_chain_in_yaml_is_a_mode_too_and_overrides_reach_it():
    chain = "[{plugin: ctbr, name: mine, parameters: {apply: body}}]"
    simulation = flying(chain, "robots.quad.controllers.mine.parameters.max_thrust=1")
    simulation.command([100, 0, 0, 0])
    simulation.advance(500)
    assert simulation.base().velocity[2] < -3  # limited to 1 N: it falls
    with pytest.raises(ValueError, match="rotor_speed, srt, throttle"):
        Simulation("hover", "thrust")
    with pytest.raises(TypeError, match="control is 3; it must be a text: one of rotor_speed"):
        Simulation("hover", 3)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="too late"):
        Simulation(CompiledScenario("hover"), "ctbr")
    with pytest.raises(skybody.InputError, match="nothing_of_that_name"):
        Simulation("hover", "[{plugin: nothing_of_that_name}]")


def test_a_command_does_what_its_action_does_bit_for_bit():
    by_action, by_command = flying("rotor_speed"), flying("rotor_speed")
    full = by_action.rotor_parameter(0, "max_speed")
    action = np.array([0.25, 0.5, 0.25, 0.5], np.float32)
    for _ in range(10):
        by_action.step(action)
        by_command.command(0.5 * (action.astype(float) + 1) * full)
        assert by_command.advance(by_command.compiled.action_repeat)
        by_command.evaluate()
    np.testing.assert_array_equal(by_command.base().position, by_action.base().position)
    np.testing.assert_array_equal(by_command.observation[:14], by_action.observation[:14])
    assert by_command.steps == by_action.steps == 10


def test_bad_commands_are_refused_and_change_nothing():
    simulation = flying()
    before = simulation.save()
    with pytest.raises(ValueError, match=r"shape \(3,\); expected \(4,\)"):
        simulation.command([1, 2, 3])
    with pytest.raises(ValueError, match="value 1 is nan"):
        simulation.command([1, np.nan, 0, 0])
    with pytest.raises(ValueError, match="there are quad"):
        simulation.command([1, 2, 3, 4], "nobody")
    with pytest.raises(ValueError, match="-1"):
        simulation.advance(-1)
    idle = Simulation("hover", "ctbr")
    with pytest.raises(ValueError, match=r"before reset\(\)"):
        idle.command([0, 0, 0, 0])
    with pytest.raises(skybody.Error, match=r"before reset\(\)"):
        idle.advance()
    twin = Simulation("hover", "ctbr", overrides=PLAIN)
    twin.restore(before)
    assert simulation.time == twin.time == 0.0


def test_a_long_advance_is_the_same_as_many_short_ones():
    whole, parts = flying("position"), flying("position")
    for simulation in (whole, parts):
        simulation.command([1, 0, 2, 0])
    assert whole.advance(5000)  # longer than the interval between checks for KeyboardInterrupt
    for _ in range(50):
        assert parts.advance(100)
    np.testing.assert_array_equal(whole.base().position, parts.base().position)
    np.testing.assert_array_equal(whole.rotor_speeds, parts.rotor_speeds)
    assert whole.time == parts.time == pytest.approx(5.0)


def test_teleport_changes_what_is_given_and_nothing_else():
    simulation = flying()
    simulation.command([5, 0, 0, 0])
    simulation.advance(100)
    before, rotors = simulation.base(), simulation.rotor_speeds
    simulation.teleport(position=[1, 2, 3], rotation=[0, 0, 0, 2])
    now = simulation.base()
    np.testing.assert_array_equal(now.position, [1, 2, 3])
    np.testing.assert_array_equal(now.rotation, [0, 0, 0, 1])
    np.testing.assert_array_equal(now.velocity, before.velocity)
    np.testing.assert_array_equal(simulation.rotor_speeds, rotors)
    for bad in ({"position": [1, 2]}, {"velocity": [0, 0, np.inf]}, {"rotation": [0, 0, 0, 0]}):
        with pytest.raises(ValueError):
            simulation.teleport(**bad)
    np.testing.assert_array_equal(simulation.base().position, [1, 2, 3])


def test_a_fault_of_the_physics_is_told_and_a_reset_mends_it():
    simulation = flying()
    simulation.teleport(angular_velocity=[1e200, 1e200, 0])  # w x J w overflows
    assert not simulation.advance(5)
    assert simulation.fault
    assert simulation.truncated
    reason = simulation.fault_reason
    assert reason is not None
    assert reason.startswith(
        "the physics gave up or left the finite numbers: rotor `front_left` of robot `quad` was "
        "commanded "
    )
    simulation.reset()
    assert simulation.advance(5)
    assert not simulation.fault
    assert simulation.fault_reason is None


def test_accelerations_in_balance_are_none_and_twice_the_mass_falls():
    simulation = flying()
    # Rounding of forces of some 10 N: 1e-14 m/s^2.
    np.testing.assert_allclose(simulation.accelerations().linear, 0, atol=1e-9)
    mass = simulation.mass_properties("base_link")
    simulation.set_mass_properties("base_link", mass=2 * mass.mass)
    half = simulation.compiled.gravity[2] / 2
    accelerations = simulation.accelerations()
    assert accelerations.linear[0, 2] == pytest.approx(half, abs=1e-9)
    assert accelerations.udot.shape == (6,)
    assert accelerations.angular.shape == (1, 3)


def test_mass_properties_and_rotor_constants_are_read_set_and_checked():
    simulation = flying()
    inertia = simulation.mass_properties("base_link").inertia
    simulation.set_mass_properties("base_link", inertia=1.2 * inertia, com=[0, 0, 0.01])
    now = simulation.mass_properties("base_link")
    np.testing.assert_array_equal(now.inertia, 1.2 * inertia)
    np.testing.assert_array_equal(now.com, [0, 0, 0.01])
    with pytest.raises(ValueError, match="inertia"):
        simulation.set_mass_properties("base_link", inertia=np.diag([1e3, 1.0, 1.0]))
    with pytest.raises(ValueError, match="symmetric"):
        simulation.set_mass_properties("base_link", inertia=np.triu(np.ones((3, 3))))
    with pytest.raises(ValueError, match="base_link"):
        simulation.mass_properties("wing")
    simulation.set_rotor_parameter(3, "tau_up", 0.5)
    assert simulation.rotor_parameter(3, "tau_up") == 0.5
    assert simulation.param("robots.quad.rotors[3].tau_up") == 0.5
    with pytest.raises(ValueError):
        simulation.set_rotor_parameter(3, "tau_up", -1.0)


def test_contacts_on_the_ground_carry_the_weight():
    simulation = flying("rotor_speed")
    assert simulation.contacts() == []
    simulation.teleport(position=[0, 0, 0.1], velocity=[0, 0, 0])
    simulation.command(np.zeros(4))
    assert simulation.advance(5000)
    contacts = simulation.contacts()
    assert {(c.body, c.other) for c in contacts} == {("quad.base_link", "ground")}
    assert all(c.depth > 0 and c.point[2] == -c.depth for c in contacts)
    mass = simulation.mass_properties("base_link").mass
    weight = -simulation.compiled.gravity[2] * mass
    # At rest: the remaining motion is far below a thousandth of g.
    assert sum(c.force[2] for c in contacts) == pytest.approx(weight, rel=1e-3)


def test_a_fork_is_a_simulation_with_the_same_future_and_a_rekeyed_one_with_its_own():
    simulation = Simulation("payload", seed=4)
    simulation.reset()
    same, own = simulation.fork(), simulation.fork(rekey=True)
    assert isinstance(same, Simulation)
    for each in (simulation, same, own):
        each.reset()
    np.testing.assert_array_equal(same.observation, simulation.observation)
    assert not np.array_equal(own.observation, simulation.observation)


def test_restored_and_forked_simulations_have_every_row_of_the_transition():
    simulation = Simulation("formation_2", seed=4)
    simulation.reset()
    simulation.step(np.zeros(simulation.compiled.action_size, np.float32))
    rows = (simulation.observation, simulation.agent_rewards, simulation.info)
    assert all(row.any() for row in rows)
    saved, copy = simulation.save(), simulation.fork()
    simulation.reset()
    simulation.restore(saved)
    for each in (simulation, copy):
        for was, now in zip(rows, (each.observation, each.agent_rewards, each.info), strict=True):
            np.testing.assert_array_equal(now, was)


def test_two_threads_in_one_simulation_are_refused_and_others_go_on():
    simulation, refused = flying(), []

    def advance() -> None:
        for _ in range(20):
            try:
                simulation.advance(2000)
            except skybody.Error as error:
                refused.append(str(error))

    threads = [threading.Thread(target=advance) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive()
    assert all("another thread" in text for text in refused)
    assert simulation.advance(1)


def test_states_outlive_their_simulation():
    simulation = flying()
    accelerations, base = simulation.accelerations(), simulation.base()
    del simulation
    gc.collect()
    assert np.isfinite(accelerations.linear).all()
    assert base.position[2] == 2.0


def test_an_image_under_direct_control_is_that_of_a_vector_environment() -> None:
    simulation = Simulation("hover_camera", seed=4)
    simulation.reset()
    envs = skybody.make_vec("hover_camera", 1, seed=4)
    seen, _ = envs.reset()
    key = next(name for name in seen if "depth" in name)
    np.testing.assert_array_equal(simulation.image("front.depth"), seen[key][0])
    with pytest.raises(ValueError, match=r"no image `front.rgb`; there are: front.depth"):
        simulation.image("front.rgb")
