"""Actuators in flight: batteries, motors, failures, thrust curves, delays."""

from __future__ import annotations

import numpy as np
import pytest
from skybody import Simulation
from skybody._native import CompiledScenario

PLAIN = ["randomization=[]", "robots[0].pose.position=[0, 0, 50]"]
HOVER = 1391.0  # rad/s: QDrone2's rotors carry its weight
MOTOR = "torque_constant: 0.0055, resistance: 0.1, max_current: 30, voltage: 16.8"


def flying(effect: str, *more: str) -> Simulation:
    """In equilibrium at (0, 0, 50) with an effect, after a reset."""
    effects = [f"effects=[{{{effect}}}]"] if effect else []
    simulation = Simulation("hover", "rotor_speed", overrides=[*PLAIN, *effects, *more])
    simulation.reset()
    return simulation


def report(simulation: Simulation, count: int) -> np.ndarray:
    """The last info values, which effects report."""
    simulation.evaluate()
    return np.asarray(simulation.info)[-count:]


def speeds(simulation: Simulation) -> np.ndarray:
    return np.asarray(simulation.rotor_speeds)


def test_an_empty_battery_lets_the_vehicle_fall():
    simulation = flying("plugin: battery, parameters: {capacity: 0.01}")
    names = [channel.name for channel in simulation.compiled.info_channels]
    assert names[-3:] == ["battery.charge", "battery.voltage", "battery.current"]
    simulation.command(np.full(4, HOVER))
    simulation.advance(500)
    charge, voltage, current = report(simulation, 3)
    assert 0.5 < charge < 0.8
    assert 14.0 < voltage < 16.8
    assert 20.0 < current < 40.0
    np.testing.assert_allclose(speeds(simulation), HOVER, rtol=1e-3)
    simulation.advance(1500)
    assert report(simulation, 3)[0] == 0.0
    assert speeds(simulation).max() < 1.0
    assert simulation.base().velocity[2] < -1.0


def test_a_battery_that_sags_bounds_the_speed():
    simulation = flying("plugin: battery, parameters: {initial_charge: 0.2, capacity: 100}")
    simulation.command(np.full(4, 2246.0))
    simulation.advance(1000)
    voltage = report(simulation, 3)[1]
    np.testing.assert_allclose(speeds(simulation), 2246.0 * voltage / 16.8, rtol=1e-4)
    assert speeds(simulation).max() < 0.9 * 2246.0


def test_a_motor_takes_the_rotors_to_their_commands():
    simulation = flying(f"plugin: motor, parameters: {{{MOTOR}}}")
    simulation.command([1200.0, 1500.0, 1300.0, 1400.0])
    simulation.advance(300)
    np.testing.assert_allclose(speeds(simulation), [1200.0, 1500.0, 1300.0, 1400.0], rtol=1e-6)


@pytest.mark.parametrize("first", ["battery", "motor"])
def test_a_motor_runs_down_by_the_lag_where_the_battery_is_empty(first: str):
    empty = "{plugin: battery, parameters: {initial_charge: 1.0e-9}}"  # of one step
    motor = f"{{plugin: motor, parameters: {{{MOTOR}}}}}"
    both = [empty, motor] if first == "battery" else [motor, empty]
    simulation = flying("", f"effects=[{', '.join(both)}]")
    simulation.command(np.full(4, HOVER))
    simulation.advance(1)
    assert report(simulation, 3)[0] == 0.0, "the charge"
    before = speeds(simulation)
    simulation.advance(10)
    np.testing.assert_allclose(speeds(simulation), before * np.exp(-0.01 / 0.025), rtol=1e-9)


def test_a_failed_rotor_runs_down_or_stays():
    for kind in ("off", "stuck"):
        where = f"kind: {kind}, rotors: [back_left], earliest: 0.1, latest: 0.1"
        simulation = flying(f"plugin: rotor_failure, parameters: {{{where}}}")
        simulation.command(np.full(4, HOVER))
        simulation.advance(100)
        at_failure = speeds(simulation)[2]
        assert simulation.compiled.info_channels[-1].name == "rotor_failure.failed"
        simulation.command(np.full(4, 1000.0))
        simulation.advance(50)
        got = speeds(simulation)[2]
        want = at_failure if kind == "stuck" else at_failure * np.exp(-0.05 / 0.025)
        assert got == pytest.approx(want, rel=1e-12)
        np.testing.assert_array_equal(report(simulation, 4), [0, 0, 1, 0])


def test_half_the_thrust_constant_by_a_curve_falls_as_half_the_constant_does():
    curve = flying("plugin: thrust_curve, parameters: {thrust: [0, 0, 0.976650e-6]}")
    plain = flying("")
    for rotor in range(4):
        plain.set_param(f"robots.quad.rotors[{rotor}].thrust_constant", 0.976650e-6)
    for simulation in (curve, plain):
        simulation.command(np.full(4, HOVER))
        simulation.advance(500)
    # One factor of 0.5 that is rounded at another place.
    np.testing.assert_allclose(curve.base().velocity, plain.base().velocity, rtol=0, atol=1e-12)


def test_a_delay_shifts_commands_and_keeps_what_actions_mean():
    chain = "[{plugin: delay, parameters: {signal: ctbr, latency: 0.02}}, {plugin: ctbr}]"
    late = Simulation("hover", chain, overrides=PLAIN)
    now = Simulation("hover", "ctbr", overrides=PLAIN)
    for of_late, of_now in zip(
        late.compiled.action_channels, now.compiled.action_channels, strict=True
    ):
        assert (of_late.low, of_late.high) == (of_now.low, of_now.high)
    heights = []
    for simulation, wait in ((late, 20), (now, 0)):
        simulation.reset()
        simulation.command([15.1, 0.0, 0.0, 0.0])
        simulation.advance(30)
        simulation.command([20.0, 0.3, 0.0, 0.0])
        simulation.advance(wait)
        np.testing.assert_allclose(speeds(simulation), speeds(simulation)[0], rtol=1e-12)
        simulation.advance(50)
        heights.append(speeds(simulation))
    np.testing.assert_allclose(heights[0], heights[1], rtol=1e-2)  # 20 ms of free flight apart


def test_a_delay_behind_a_controller_delays_what_the_rotors_are_told():
    chain = (
        "[{plugin: rotor_speed}, {plugin: delay, parameters: {signal: rotor_speed, latency: L}}]"
    )
    late = Simulation("hover", chain.replace("L", "0.005"), overrides=PLAIN)
    now = Simulation("hover", chain.replace("L", "0"), overrides=PLAIN)
    # Rotors start slightly below HOVER: both are commanded HOVER for 15 steps, and 1600 for 7.
    for simulation, told in ((late, 10), (now, 15)):
        simulation.reset()
        simulation.command(np.full(4, HOVER))
        simulation.advance(told)
        simulation.command(np.full(4, 1600.0))
        simulation.advance(22 - told)
    np.testing.assert_allclose(speeds(late), speeds(now), rtol=1e-12)


@pytest.mark.parametrize(
    "effect",
    [
        "plugin: battery, parameters: {capacity: 0.003}",
        f"plugin: motor, parameters: {{{MOTOR}}}",
        "plugin: rotor_failure, parameters: {kind: stuck, earliest: 0.05, latest: 0.3}",
        "plugin: thrust_curve, parameters: {thrust_by_advance: [-0.3, -1], diameter: 0.25}",
    ],
)
def test_a_restored_flight_has_the_same_future(effect: str):
    jitter = "signal: ctbr, latency: 0.01, jitter: 0.01, draw: action"
    chain = f"[{{plugin: delay, parameters: {{{jitter}}}}}, {{plugin: ctbr}}]"
    simulation = Simulation("hover", chain, overrides=[*PLAIN, f"effects=[{{{effect}}}]"])
    simulation.reset()
    generator = np.random.default_rng(3)
    actions = generator.uniform(-0.3, 0.5, (300, 4)).astype(np.float32)
    for action in actions[:100]:
        simulation.step(action)
    saved = simulation.save()
    ends = []
    for _ in range(2):
        for action in actions[100:]:
            simulation.step(action)
        ends.append(np.concatenate([simulation.observation, speeds(simulation), simulation.info]))
        simulation.restore(saved)
    np.testing.assert_array_equal(ends[0], ends[1])


def test_effects_load_on_every_vehicle():
    for scenario in ("hover_crazyflie", "hover_firefly", "hover_hummingbird"):
        CompiledScenario(
            scenario, overrides=["effects=[{plugin: battery}, {plugin: rotor_failure}]"]
        )
