"""research/transfer/raptor.py by parts: axes, signs, observations, vehicles, errors.

research/peers/raptor_server.py needs packages of its own and is not run here; the numbers that it
gets are compared with the motion of the engine.
"""

from __future__ import annotations

import numpy as np
import pytest

from research.transfer import raptor_cases as cases
from research.transfer.raptor_flights import FAR, HOVER, fly, summary, wilson
from research.transfer.raptor_policies import (
    CLIP,
    Target,
    hover_observation,
    raptor_observation,
    relative,
)
from research.transfer.raptor_vehicles import RAPTOR, VEHICLE, Motion, Reals, axes_for
from research.transfer.raptor_worlds import (
    Ours,
    quaternions,
    start_of_l2f,
    vehicle_of_l2f,
)

ORIGIN = Target(np.array([0.0, 0.0, 3.0]), np.zeros(3))


def world(vehicles: cases.Vehicles, n: int = 2) -> Ours:
    return Ours(cases.SCENARIO, vehicles.overrides(), n, seed=1)


def yawed(angle: float) -> Motion:
    """A vehicle at (1, 2, 3) that has turned left and still turns left."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]])
    return Motion(
        np.array([[1.0, 2.0, 3.0]]), turn, np.array([[4.0, 5.0, 6.0]]), np.array([[0.1, 0.2, 0.3]])
    )


def test_an_x_of_raptors_directions_is_seen_as_it_is() -> None:
    fleet = world(cases.DRAWN).fleet
    axes = axes_for(fleet.hubs[0], fleet.directions, RAPTOR)
    assert axes.matrix == pytest.approx(np.eye(3))
    assert axes.order == (1, 3, 2, 0)  # front right, back right, back left, front left
    assert axes_for(fleet.hubs[0], fleet.directions, VEHICLE).order == (0, 1, 2, 3)


@pytest.mark.parametrize("vehicles", [cases.CRAZYFLIE, cases.HUMMINGBIRD, cases.QDRONE2])
def test_every_vehicle_is_seen_with_raptors_layout(vehicles: cases.Vehicles) -> None:
    fleet = world(vehicles).fleet
    axes = axes_for(fleet.hubs[0], fleet.directions, RAPTOR)
    hubs = (fleet.hubs[0] @ axes.matrix.T)[list(axes.order)]
    assert np.sign(hubs[:, :2]).tolist() == [[x, y] for x, y, _ in RAPTOR]
    turns = fleet.directions[list(axes.order)]
    assert turns.tolist() == [turn for _, _, turn in RAPTOR]


def test_rotors_that_no_turn_orders_are_refused() -> None:
    fleet = world(cases.DRAWN).fleet
    with pytest.raises(ValueError, match="no turn"):
        axes_for(fleet.hubs[0], np.array([1, 1, -1, -1]), RAPTOR)


def test_a_turned_vehicle_keeps_its_heading_and_its_spin() -> None:
    fleet = world(cases.QDRONE2).fleet
    seen = axes_for(fleet.hubs[0], fleet.directions, RAPTOR).seen(yawed(0.3))
    assert seen.position == pytest.approx(np.array([[-2.0, 1.0, 3.0]]))
    assert seen.velocity == pytest.approx(np.array([[-5.0, 4.0, 6.0]]))
    assert seen.rotation == pytest.approx(yawed(0.3).rotation)
    assert seen.rates == pytest.approx(np.array([[-0.2, 0.1, 0.3]]))


def test_throttles_return_to_the_rotors_they_were_meant_for() -> None:
    fleet = world(cases.DRAWN).fleet
    axes = axes_for(fleet.hubs[0], fleet.directions, RAPTOR)
    own = axes.to_vehicle(np.array([[1.0, 2.0, 3.0, 4.0]]))
    assert own.tolist() == [[4.0, 1.0, 3.0, 2.0]]  # front left, front right, back left, back right


def test_raptor_observes_clipped_errors_and_rows_of_the_rotation_matrix() -> None:
    last = np.array([[0.1, 0.2, 0.3, 0.4]])
    row = raptor_observation(relative(yawed(0.5), ORIGIN), last, CLIP)[0]
    assert row[:3] == pytest.approx([1.0, 1.0, 0.0])
    assert row[3:6] == pytest.approx([np.cos(0.5), -np.sin(0.5), 0.0])
    assert row[12:15] == pytest.approx([2.0, 2.0, 2.0])
    assert row[15:] == pytest.approx([0.1, 0.2, 0.3, *last[0]])


def test_our_policy_observes_what_the_task_shows_it() -> None:
    ours = world(cases.DRAWN, n=4)
    rng = np.random.default_rng(0)
    past = np.full((4, 8), -1.0)
    for _ in range(20):
        throttles = rng.uniform(0.3, 0.8, (4, 4))
        past = np.column_stack([2.0 * throttles - 1.0, past[:, :4]])
        ours.step(throttles)
    made = hover_observation(relative(ours.motion(), ORIGIN), past)
    seen = ours.pool.observations()
    assert made == pytest.approx(seen, abs=1e-5)  # the task's are single precision


def test_quaternions_of_matrices_are_those_of_the_engine() -> None:
    ours = world(cases.CRAZYFLIE, n=8)
    for _ in range(30):
        ours.step(np.array([[0.9, 0.8, 0.85, 0.8]] * 8))
    found = ours.pool.state("robots.quad.base.rotation")
    wanted = np.where(found[:, :1] < 0.0, -found, found)
    assert quaternions(ours.motion().rotation) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("vehicles", [cases.DRAWN, cases.HUMMINGBIRD, cases.QDRONE2])
def test_hover_throttles_carry_the_weight(vehicles: cases.Vehicles) -> None:
    ours = world(vehicles)
    for _ in range(10):
        ours.step(np.repeat(ours.fleet.hover[:, None], 4, axis=1))
    # 0.1 s of free fall would give 1 m/s; actions are single precision.
    assert ours.motion().velocity == pytest.approx(np.zeros((2, 3)), abs=1e-5)


def test_drawn_vehicles_turn_as_fast_as_their_preset_says() -> None:
    turns = world(cases.DRAWN, n=50).fleet.turn
    assert turns.min() >= 40.0 - 1e-9  # rad/s^2, randomization/vehicle/README.md
    assert turns.max() <= 1200.0 + 1e-9
    assert turns.max() > 10.0 * turns.min()


def test_changes_scale_every_rotor() -> None:
    plain = world(cases.CRAZYFLIE)
    strong = Ours(cases.SCENARIO, cases.CRAZYFLIE.overrides(), 2, 1, {"rotors[*].max_speed": 2.0})
    assert strong.fleet.full_thrust == pytest.approx(4.0 * plain.fleet.full_thrust)


def by_l2f(
    vehicle: dict[str, list[float]], speeds: Reals, commands: Reals, seconds: float
) -> Reals:
    """Rates of a resting vehicle after a short time, by L2F's equations, as its numbers say."""
    rates, steps = np.zeros(3), 2000
    hubs = np.array(vehicle["rotor_positions"])
    turns = np.array(vehicle["rotor_torque_directions"])
    full = np.array(vehicle["rotor_thrust_coefficients"])[:, 2:]
    arms = np.array(vehicle["rotor_torque_constants"])[:, None]
    inertia = np.array(vehicle["J"])
    for _ in range(steps):
        rising = commands > speeds
        lag = np.where(
            rising, vehicle["rotor_time_constants_rising"], vehicle["rotor_time_constants_falling"]
        )
        thrust = full * speeds[:, None] ** 2
        moment = np.sum(np.cross(hubs, thrust * [0.0, 0.0, 1.0]) + arms * thrust * turns, axis=0)
        moment -= np.cross(rates, inertia @ rates)
        rates = rates + seconds / steps * np.array(vehicle["J_inv"]) @ moment
        speeds = speeds + seconds / steps * (commands - speeds) / lag
    return rates


def test_l2f_gets_numbers_that_turn_a_vehicle_as_the_engine_does() -> None:
    ours = world(cases.DRAWN, n=6)
    start, speeds = ours.motion(), ours.rotor_speeds()
    commands = np.array([0.9, 0.7, 0.4, 0.5])
    ours.step(np.array([commands] * 6))
    for k in range(6):
        vehicle = vehicle_of_l2f(ours.fleet, k)
        found = by_l2f(vehicle, speeds[k], commands, ours.period)
        assert ours.motion().rates[k] == pytest.approx(found, rel=2e-3, abs=1e-4)  # Euler's rule
    state = start_of_l2f(start, speeds, 0)
    assert state["position"] == pytest.approx(start.position[0])
    assert state["rpm"] == pytest.approx([ours.fleet.hover[0]] * 4)


class Standing:
    """A world of two vehicles, of which one is 0.1 m off and the other lies on its side."""

    period = 0.01

    def motion(self) -> Motion:
        position = np.array([[0.1, 0.0, 3.0], [0.0, 0.0, 3.0]])
        upright, fallen = np.eye(3), np.diag([1.0, -1.0, -1.0])
        return Motion(position, np.array([upright, fallen]), 0.0 * position, 0.0 * position)

    def step(self, throttles: Reals) -> None:
        pass


def test_a_fallen_vehicle_has_failed_and_the_other_has_its_distance() -> None:
    flown = fly(Standing(), lambda motion, target: np.zeros((2, 4)), HOVER, 0.1)
    assert flown.failed.tolist() == [False, True]
    assert flown.error == pytest.approx([0.1, FAR])
    found = summary(flown)
    assert (found["near"], found["failed"], found["flights"]) == (0.5, 1, 2)


def test_intervals_of_shares_hold_the_share_and_stay_between_0_and_1() -> None:
    assert wilson(10, 10)[1] == 1.0
    low, high = wilson(50, 100)
    assert (low, high) == pytest.approx((0.4038, 0.5962), abs=1e-4)  # published values
