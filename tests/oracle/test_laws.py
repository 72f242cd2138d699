"""Flight control laws against second implementations (laws.py), in random states and references.

A chain receives one point of a trajectory and is evaluated once; its rotor commands give thrust and
torque.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import skybody
from laws import (
    ERRORS,
    UP,
    G,
    Motion,
    Point,
    drag_forward,
    drag_moment,
    lee_error,
    moment,
    pointing,
    regulator,
    thrust_along,
    turn_error,
    wished,
)
from rigid_body import Reals, Vehicle, read_vehicle
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parents[2]
KP, KD = np.array([6.0, 6.0, 9.0]), np.array([4.0, 4.0, 5.4])
ATTITUDE, RATE = np.array([9.0, 9.0, 3.0]), np.array([22.0, 22.0, 9.0])
RATES = "{plugin: ctbr, parameters: {kd: [0, 0, 0]}}"
RATE_LOOP = np.array([20.0, 20.0, 8.0])  # kp of ctbr
# Error of differences in time: 1e-12 of STEP^4, and round-off divided by STEP^2 in values that are
# differentiated twice, times an inertia of 0.03.
TOLERANCE = 1e-7


@pytest.fixture(scope="module")
def qdrone2() -> Vehicle:
    return read_vehicle(ROOT / "scenarios/models/qdrone2")


def draw(random: np.random.Generator) -> tuple[Motion, Point]:
    """A state and a reference that require no more than the rotors can give."""
    position = random.uniform(-1.0, 1.0, 3) + 3.0 * UP
    velocity = random.uniform(-1.0, 1.0, 3)
    yaw = random.uniform(-3.0, 3.0)
    tilt = Rotation.from_rotvec([*random.uniform(-0.1, 0.1, 2), 0.0])
    motion = Motion(
        position,
        tilt * Rotation.from_euler("z", yaw + random.uniform(-0.05, 0.05)),
        velocity,
        random.uniform(-0.15, 0.15, 3),
    )
    point = Point(
        position + random.uniform(-0.1, 0.1, 3),
        velocity + random.uniform(-0.1, 0.1, 3),
        random.uniform(-1.0, 1.0, 3),
        random.uniform(-1.0, 1.0, 3),
        random.uniform(-2.0, 2.0, 3),
        yaw,
        random.uniform(-0.1, 0.1),
    )
    return motion, point


class Rig:
    """A chain of controllers, and its rotor commands in one state."""

    def __init__(self, vehicle: Vehicle, chain: str) -> None:
        self.vehicle = vehicle
        overrides = ["contact.ground=false", "randomization=[]"]
        self.sim = skybody.Simulation("hover", control=chain, overrides=overrides)

    def thrust_and_torque(self, motion: Motion, point: Point) -> Reals:
        self.sim.reset()
        self.sim.teleport(
            position=motion.position,
            rotation=motion.rotation.as_quat(scalar_first=True),
            velocity=motion.velocity,
            angular_velocity=motion.rates,
        )
        self.sim.command(point.values())
        assert self.sim.advance(1)
        constants = self.vehicle.constants
        rotors = [f"robots.quad.rotors[{i}].command" for i in range(4)]
        commands = np.array([np.ravel(self.sim.state(path))[0] for path in rotors])
        assert (commands > 1.0).all() and (commands < constants["max_speed"] - 1.0).all()
        pushes = constants["thrust_constant"] * commands**2
        arms = np.cross(self.vehicle.hubs - self.vehicle.com, UP)
        twist = self.vehicle.directions * constants["moment_constant"]
        torque = pushes @ arms - UP * float(twist @ commands**2)
        return np.array([pushes.sum(), *torque])

    def rates(self, motion: Motion, point: Point) -> Reals:
        """Thrust, and the rates commanded to `ctbr`."""
        thrust, *torque = self.thrust_and_torque(motion, point)
        j, w = self.vehicle.inertia, motion.rates
        change = np.linalg.solve(j, np.array(torque) - np.cross(w, j @ w))
        return np.array([thrust, *(w + change / RATE_LOOP)])


def feedback(motion: Motion, point: Point, kp: Reals, kd: Reals) -> Reals:
    return kp * (point.position - motion.position) + kd * (point.velocity - motion.velocity)


@pytest.mark.parametrize("error", ERRORS)
def test_geometric_gives_the_force_and_moment_of_lee(qdrone2: Vehicle, error: str) -> None:
    rig = Rig(qdrone2, f"[{{plugin: geometric, parameters: {{error: {error}}}}}, {{plugin: ctbt}}]")
    random = np.random.default_rng(3)
    for _ in range(30):
        motion, point = draw(random)
        u = feedback(motion, point, KP, KD) + point.acceleration + G * UP
        u = u + drag_forward(qdrone2, motion, point)
        wish = wished(u, point)
        e_r = ERRORS[error](motion.rotation, wish.rotation)
        m = moment(qdrone2, motion, wish, RATE * ATTITUDE, RATE, e_r)
        m = m + drag_moment(qdrone2, motion, point)
        want = [thrust_along(qdrone2, motion, u), *m]
        np.testing.assert_allclose(rig.thrust_and_torque(motion, point), want, atol=TOLERANCE)


def test_geometric_gives_the_rates_that_its_moments_would_settle_at(qdrone2: Vehicle) -> None:
    rig = Rig(qdrone2, f"[{{plugin: geometric, parameters: {{output: ctbr}}}}, {RATES}]")
    random = np.random.default_rng(4)
    for _ in range(30):
        motion, point = draw(random)
        u = feedback(motion, point, KP, KD) + point.acceleration + G * UP
        u = u + drag_forward(qdrone2, motion, point)
        wish = wished(u, point)
        forward = (motion.rotation.inv() * wish.rotation).apply(wish.rates)
        rates = forward - ATTITUDE * lee_error(motion.rotation, wish.rotation)
        want = [thrust_along(qdrone2, motion, u), *rates]
        np.testing.assert_allclose(rig.rates(motion, point), want, atol=TOLERANCE)


def test_position_feeds_acceleration_and_rates_forward(qdrone2: Vehicle) -> None:
    rig = Rig(
        qdrone2,
        "[{plugin: position, parameters: {signal: trajectory}},"
        f" {{plugin: attitude, parameters: {{feed_forward: true}}}}, {RATES}]",
    )
    random = np.random.default_rng(5)
    kp, kd = np.array([4.0, 4.0, 9.0]), np.array([3.2, 3.2, 5.4])
    for _ in range(30):
        motion, point = draw(random)
        u = feedback(motion, point, kp, kd) + point.acceleration + G * UP
        wish = wished(u, point)
        forward = (motion.rotation.inv() * wish.rotation).apply(wish.rates)
        rates = forward - np.array([8.0, 8.0, 3.0]) * turn_error(motion.rotation, wish.rotation)
        want = [thrust_along(qdrone2, motion, u), *rates]
        np.testing.assert_allclose(rig.rates(motion, point), want, atol=TOLERANCE)


@pytest.mark.parametrize("level", ["force", "acceleration"])
def test_flatness_reaches_the_attitude_by_force_and_acceleration(
    qdrone2: Vehicle, level: str
) -> None:
    below = "{plugin: force}" if level == "force" else "{plugin: acceleration}, {plugin: force}"
    rig = Rig(
        qdrone2,
        f"[{{plugin: flatness, parameters: {{output: {level}, kp: [6, 6, 9], kd: [4, 4, 5.4]}}}},"
        f" {below}, {{plugin: attitude}}, {RATES}]",
    )
    random = np.random.default_rng(6)
    for _ in range(30):
        motion, point = draw(random)
        u = feedback(motion, point, KP, KD) + point.acceleration + G * UP
        u = u + drag_forward(qdrone2, motion, point)
        wish = pointing(u, point.yaw)
        rates = -np.array([8.0, 8.0, 3.0]) * turn_error(motion.rotation, wish)
        want = [thrust_along(qdrone2, motion, u), *rates]
        np.testing.assert_allclose(rig.rates(motion, point), want, atol=TOLERANCE)


def test_sliding_mode_drives_onto_its_surfaces(qdrone2: Vehicle) -> None:
    rig = Rig(qdrone2, "[{plugin: sliding_mode}, {plugin: ctbt}]")
    random = np.random.default_rng(7)
    j = qdrone2.inertia
    for _ in range(30):
        motion, point = draw(random)
        slope, gain = np.array([1.5, 1.5, 2.0]), np.array([4.0, 4.0, 5.0])
        e_v = motion.velocity - point.velocity
        s = e_v + slope * (motion.position - point.position)
        push = -slope * e_v - gain * np.clip(s / 1.4, -1.0, 1.0)
        u = point.acceleration + push + G * UP + drag_forward(qdrone2, motion, point)
        wish = wished(u, point)
        back = motion.rotation.inv() * wish.rotation
        e_w = motion.rates - back.apply(wish.rates)
        slope, gain = np.array([6.0, 6.0, 3.0]), np.array([48.0, 48.0, 12.0])
        s = e_w + slope * turn_error(motion.rotation, wish.rotation)
        turn = -slope * e_w - gain * np.clip(s / np.array([3.0, 3.0, 2.0]), -1.0, 1.0)
        ahead = back.apply(wish.acceleration) - np.cross(motion.rates, back.apply(wish.rates))
        m = j @ (turn + ahead) + np.cross(motion.rates, j @ motion.rates)
        m = m + drag_moment(qdrone2, motion, point)
        want = [thrust_along(qdrone2, motion, u), *m]
        np.testing.assert_allclose(rig.thrust_and_torque(motion, point), want, atol=TOLERANCE)


def test_lqr_has_the_gains_of_scipy(qdrone2: Vehicle) -> None:
    weights = (
        "position_weight: [30, 50, 70], velocity_weight: [9, 12, 8],"
        " attitude_weight: [60, 90, 12], rate_weight: [1.1, 0.9, 0.6], thrust_weight: 0.8,"
        " torque_weight: [0.006, 0.004, 0.012]"
    )
    rig = Rig(qdrone2, f"[{{plugin: lqr, parameters: {{{weights}}}}}, {{plugin: ctbt}}]")
    x = regulator([1.0, G, 1.0], [30.0, 9.0, 90.0, 0.9], 0.004)  # by pitch
    y = regulator([1.0, G, 1.0], [50.0, 12.0, 60.0, 1.1], 0.006)  # by roll
    z = regulator([1.0], [70.0, 8.0], 0.8)
    yaw = regulator([1.0], [12.0, 0.6], 0.012)
    kp = np.array([G * x[0] / x[2], G * y[0] / y[2], z[0]])
    kd = np.array([G * x[1] / x[2], G * y[1] / y[2], z[1]])
    k_r, k_w = np.array([y[2], x[2], yaw[0]]), np.array([y[3], x[3], yaw[1]])
    random = np.random.default_rng(8)
    for _ in range(30):
        motion, point = draw(random)
        u = feedback(motion, point, kp, kd) + point.acceleration + G * UP
        u = u + drag_forward(qdrone2, motion, point)
        wish = wished(u, point)
        e_r = turn_error(motion.rotation, wish.rotation)
        m = moment(qdrone2, motion, wish, k_r, k_w, e_r) + drag_moment(qdrone2, motion, point)
        want = [thrust_along(qdrone2, motion, u), *m]
        np.testing.assert_allclose(rig.thrust_and_torque(motion, point), want, atol=TOLERANCE)


def test_lqr_is_the_linear_law_to_first_order_about_hover(qdrone2: Vehicle) -> None:
    rig = Rig(qdrone2, "[{plugin: lqr, parameters: {drag: false}}, {plugin: ctbt}]")
    x = regulator([1.0, G, 1.0], [40.0, 10.0, 80.0, 1.0], 0.005)
    small = 1e-5
    zero = np.zeros(3)
    still = Point(3.0 * UP, zero, zero, zero, zero, 0.0, 0.0)
    # Errors of position, velocity, pitch and pitch rate, one after the other.
    at_goal = Motion(3.0 * UP, Rotation.identity(), np.zeros(3), np.zeros(3))
    front, pitch = np.array([small, 0.0, 0.0]), np.array([0.0, small, 0.0])
    errors = [
        Motion(3.0 * UP + front, at_goal.rotation, np.zeros(3), np.zeros(3)),
        Motion(3.0 * UP, at_goal.rotation, front, np.zeros(3)),
        Motion(3.0 * UP, Rotation.from_rotvec(pitch), np.zeros(3), np.zeros(3)),
        Motion(3.0 * UP, at_goal.rotation, np.zeros(3), pitch),
    ]
    for motion, gain in zip(errors, x, strict=True):
        torque = rig.thrust_and_torque(motion, still)[1:]
        change = np.linalg.solve(qdrone2.inertia, torque)
        # Rotor commands are squares of speeds: 1e-16 of 15 N over arms of 0.1 m and the inertia.
        assert change[1] / small == pytest.approx(-gain, rel=1e-5)
