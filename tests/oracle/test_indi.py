"""Controller indi against its law as written in the papers, by NumPy and SciPy.

E. Smeur, Q. Chu, G. de Croon, JGCD 39(3), 2016, and E. Tal, S. Karaman, IEEE TCST 29(3), 2021,
filter the measurements and the rotors' contribution separately and command increments; the plugin
filters their difference. Here the rates and angular accelerations of the attitude setpoint are
differences, the allocation is NumPy's pseudo-inverse, and rotations and filters are SciPy's.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from rigid_body import Reals, Vehicle, read_vehicle
from scipy.signal import butter, lfilter
from scipy.spatial.transform import Rotation
from skybody import Simulation

MODEL = Path(__file__).resolve().parents[2] / "scenarios/models/qdrone2"
DT, PERIOD, CUTOFF = 0.001, 2, 30.0
INTERVAL = PERIOD * DT
RATE_GAIN, ATTITUDE_GAIN = np.array([24.0, 24.0, 10.0]), np.array([10.0, 10.0, 4.0])
KP, KD = np.array([8.0, 8.0, 12.0]), np.array([4.8, 4.8, 6.5])
SIZE, RATE, PHASE = np.array([1.2, 0.9, 0.3]), np.array([1.1, 1.7, 0.8]), np.array([0.0, 1.0, 2.0])
YAW_RATE = 0.4
AIR = (
    "effects=[{plugin: wind, parameters: {velocity: [3, -2, 0.5]}}, "
    "{plugin: body_drag, parameters: {linear: [0.1, 0.1, 0.1]}}]"
)


@dataclass(frozen=True)
class Flight:
    """States and commands at each evaluation. Rows: evaluations."""

    time: Reals
    position: Reals
    rotation: Reals  # quaternions w x y z
    velocity: Reals
    spin: Reals
    speed: Reals
    command: Reals


def reference(time: float) -> list[Reals]:
    """Position and its first four derivatives."""
    angle = RATE * time + PHASE
    rows = [SIZE * np.sin(angle), SIZE * RATE * np.cos(angle)]
    for n in range(3):
        rows.append(-(RATE**2) * rows[n])
    return [rows[0] + np.array([0.0, 0.0, 2.0]), *rows[1:]]


def fly(parameters: str, command, seconds: float) -> Flight:
    sim = Simulation(
        "hover",
        control=f"[{{plugin: indi, parameters: {{{parameters}}}}}]",
        overrides=["randomization=[]", AIR],
        seed=2,
    )
    sim.reset()
    start = reference(0.0)
    sim.teleport(position=list(start[0] + 0.05), rotation=[1, 0, 0, 0], velocity=list(start[1]))
    rows: list[list[Reals]] = []
    for n in range(round(seconds / INTERVAL)):
        time = n * INTERVAL
        sim.command(command(time))
        base = sim.base()
        values = (base.position, base.rotation, base.velocity, base.angular_velocity)
        row = [np.array([time]), *(np.array(v) for v in values), np.array(sim.rotor_speeds)]
        assert sim.advance(PERIOD)
        rows.append([*row, np.array(sim.state("robots.quad.rotors.command"))])
    return Flight(*(np.squeeze(np.array(column)) for column in zip(*rows, strict=True)))


def filtered(values: Reals) -> Reals:
    """Low-pass filtered values; zero before the first row."""
    numerator, denominator = butter(2, CUTOFF, fs=1.0 / INTERVAL)
    return lfilter(numerator, denominator, values, axis=0)


def turns(flight: Flight) -> Rotation:
    return Rotation.from_quat(np.roll(flight.rotation, -1, axis=1))


def effectiveness(vehicle: Vehicle) -> Reals:
    """Thrust and torque per thrust of each rotor; columns: rotors."""
    ratio = vehicle.constants["moment_constant"] / vehicle.constants["thrust_constant"]
    arm = vehicle.hubs - vehicle.com
    return np.array([np.ones(len(arm)), arm[:, 1], -arm[:, 0], -vehicle.directions * ratio])


def mean_square(flight: Flight) -> Reals:
    before = np.vstack([flight.speed[:1], flight.speed[:-1]])
    return (before**2 + before * flight.speed + flight.speed**2) / 3.0


def torques(vehicle: Vehicle, flight: Flight, wish: Reals) -> Reals:
    """Commanded torques: the rotors' torques plus the increment of inertia times acceleration."""
    before = np.vstack([flight.spin[:1], flight.spin[:-1]])
    growth = np.diff(flight.speed, axis=0, prepend=flight.speed[:1]) / INTERVAL
    inertia = vehicle.inertia
    gyroscopic = np.cross(flight.spin, flight.spin @ inertia)
    moved = (flight.spin - before) / INTERVAL @ inertia + gyroscopic
    given = (vehicle.constants["thrust_constant"] * mean_square(flight)) @ effectiveness(vehicle).T
    torque = given[:, 1:].copy()
    torque[:, 2] -= growth @ (vehicle.directions * vehicle.constants["inertia"])
    moved[0] = torque[0] = 0.0  # no measurement yet
    return filtered(torque) - filtered(moved) + wish @ inertia + gyroscopic


def speeds(vehicle: Vehicle, thrust: Reals, torque: Reals) -> Reals:
    """Rotor speeds for thrust and torque, with the reaction about z behind its own lag."""
    c = vehicle.constants
    hover = np.sqrt(vehicle.mass * 9.81 / len(vehicle.hubs) / c["thrust_constant"])
    lag = c["inertia"].sum() / (2.0 * c["moment_constant"] * hover).sum()
    share = INTERVAL / (lag + INTERVAL)
    torque = torque.copy()
    torque[:, 2] = lfilter([share], [1.0, share - 1.0], torque[:, 2])
    pushes = np.column_stack([thrust, torque]) @ np.linalg.pinv(effectiveness(vehicle)).T
    assert (pushes > 0.0).all(), "the flight is to stay clear of the rotors' limits"
    return np.sqrt(pushes / c["thrust_constant"])


def attitude(push: Reals, yaw: float) -> Rotation:
    """Heading first, then the shortest rotation of z onto the push."""
    up = push / np.linalg.norm(push)
    axis = np.cross([0.0, 0.0, 1.0], up)
    angle = np.arctan2(np.linalg.norm(axis), up[2])
    size = np.linalg.norm(axis)
    turn = axis * (angle / size if size > 0.0 else 0.0)
    return Rotation.from_rotvec(turn) * Rotation.from_rotvec([0.0, 0.0, yaw])


def error(left: Rotation) -> Reals:
    x, y, z, w = left.as_quat()
    return 2.0 * np.copysign(1.0, w) * np.array([x, y, z])


def test_a_trajectory_is_followed_by_the_papers_law() -> None:
    def command(time: float) -> Reals:
        return np.concatenate([*reference(time), [YAW_RATE * time, YAW_RATE]])

    vehicle = read_vehicle(MODEL)
    flight = fly("signal: trajectory", command, 1.5)
    turn = turns(flight)
    before = np.vstack([flight.velocity[:1], flight.velocity[:-1]])
    moved = (flight.velocity - before) / INTERVAL + np.array([0.0, 0.0, 9.81])
    push = (vehicle.constants["thrust_constant"] * mean_square(flight)).sum(axis=1) / vehicle.mass
    given = turn.apply(np.outer(push, [0.0, 0.0, 1.0]))
    moved[0] = given[0] = 0.0
    increment = filtered(given) - filtered(moved)

    step = 1e-4
    thrust, wish = np.zeros(len(flight.time)), np.zeros((len(flight.time), 3))
    for n, time in enumerate(flight.time):
        p, v, a, jerk, snap = reference(time)
        feedback = KP * (p - flight.position[n]) + KD * (v - flight.velocity[n])
        u = a + feedback + increment[n] + np.array([0.0, 0.0, 9.81])
        at = [
            attitude(u + jerk * t + snap * t * t / 2, YAW_RATE * (time + t))
            for t in (-step, 0.0, step)
        ]
        forth, back = (at[1].inv() * at[k] for k in (2, 0))
        rates = (forth.as_rotvec() - back.as_rotvec()) / (2 * step)
        growth = (forth.as_rotvec() + back.as_rotvec()) / step**2
        left = turn[n].inv() * at[1]
        wish[n] = left.apply(RATE_GAIN * rates + growth) + RATE_GAIN * (
            ATTITUDE_GAIN * error(left) - flight.spin[n]
        )
        thrust[n] = vehicle.mass * u @ turn[n].apply([0.0, 0.0, 1.0])
    expected = speeds(vehicle, thrust, torques(vehicle, flight, wish))
    # Second differences of step 1e-4 round to 1e-8 rad/s^2, or 1e-7 of a rotor's speed.
    np.testing.assert_allclose(flight.command, expected, rtol=1e-6)


@pytest.mark.parametrize("signal", ["attitude", "ctbr"])
def test_attitudes_and_rates_are_followed_by_the_papers_law(signal: str) -> None:
    wished = Rotation.from_rotvec([0.2, -0.1, 0.3])
    x, y, z, w = wished.as_quat()
    rates = np.array([0.3, -0.2, 0.4])
    values = np.array([15.0, w, x, y, z]) if signal == "attitude" else np.array([15.0, *rates])

    vehicle = read_vehicle(MODEL)
    flight = fly(f"signal: {signal}", lambda _: values, 1.0)
    rate = np.tile(rates, (len(flight.time), 1))
    if signal == "attitude":
        rate = np.array([ATTITUDE_GAIN * error(turn.inv() * wished) for turn in turns(flight)])
    torque = torques(vehicle, flight, RATE_GAIN * (rate - flight.spin))
    expected = speeds(vehicle, np.full(len(flight.time), 15.0), torque)
    np.testing.assert_allclose(flight.command, expected, rtol=1e-11)


def test_a_flight_goes_on_as_it_was_saved() -> None:
    def command(time: float) -> Reals:
        return np.concatenate([*reference(time), [0.0, 0.0]])

    sim = Simulation("hover", control="[{plugin: indi}]", overrides=[AIR], seed=4)
    sim.reset()
    for n in range(501):  # in the middle of an interval
        sim.command(command(n * DT))
        assert sim.advance(1)
    saved = sim.save()
    places = []
    for _ in range(2):
        sim.restore(saved)
        for n in range(501, 1000):
            sim.command(command(n * DT))
            assert sim.advance(1)
        places.append((*sim.base().position, *sim.rotor_speeds))
    assert places[0] == places[1]


def eight(time: float) -> list[Reals]:
    """Figure of eight of 16 m by 8 m at up to 10 m/s, from rest within 4 s, with derivatives."""
    peak, size, ramp = 10.0 / np.sqrt(2.0), np.array([8.0, 4.0, 0.0]), 4.0
    rate = peak / 8.0 * np.array([1.0, 2.0, 1.0])
    x = min(time / ramp, 1.0)
    # Phase s(t); its rate grows from 0 to 1 by 10 x^3 - 15 x^4 + 6 x^5.
    s = ramp * (2.5 * x**4 - 3 * x**5 + x**6) + max(time - ramp, 0.0)
    s1 = 10 * x**3 - 15 * x**4 + 6 * x**5
    s2 = (30 * x**2 - 60 * x**3 + 30 * x**4) / ramp
    s3 = (60 * x - 180 * x**2 + 120 * x**3) / ramp**2
    s4 = (60 - 360 * x + 360 * x**2) / ramp**3 if x < 1.0 else 0.0
    angle = rate * s
    p, p1 = size * np.sin(angle), size * rate * np.cos(angle)
    p2, p3, p4 = -(rate**2) * p, -(rate**2) * p1, rate**4 * p
    return [
        p + np.array([0.0, 0.0, 3.0]),
        p1 * s1,
        p2 * s1**2 + p1 * s2,
        p3 * s1**3 + 3 * p2 * s1 * s2 + p1 * s3,
        p4 * s1**4 + 6 * p3 * s1**2 * s2 + p2 * (3 * s2**2 + 4 * s1 * s3) + p1 * s4,
    ]


def stand(_: float) -> list[Reals]:
    return [np.array([0.0, 0.0, 3.0]), *(np.zeros(3) for _ in range(4))]


def error_of(path, parameters: str, overrides: list[str]) -> float:
    """RMS distance from the path from 4 s to 12 s [m]."""
    control = f"[{{plugin: indi, parameters: {{{parameters}}}}}]"
    sim = Simulation("hover", control=control, overrides=["randomization=[]", *overrides], seed=3)
    sim.reset()
    sim.teleport(position=list(path(0.0)[0]), rotation=[1, 0, 0, 0], velocity=[0] * 3)
    squares = []
    for n in range(round(12.0 / INTERVAL)):
        sim.command(np.concatenate([*path(n * INTERVAL), [0.0, 0.0]]))
        assert sim.advance(PERIOD)
        time = (n + 1) * INTERVAL
        if time > 4.0:
            squares.append(np.sum((np.array(sim.base().position) - path(time)[0]) ** 2))
    return float(np.sqrt(np.mean(squares)))


# Densities and biases of a consumer-grade sensor, such as the ICM-20948 or the BMI088.
IMU = (
    "sensors=[{plugin: imu, parameters: {robot: quad, accelerometer_noise: 0.0025, "
    "gyroscope_noise: 2.6e-4, accelerometer_walk: 1e-4, gyroscope_walk: 1e-5, "
    "accelerometer_bias: 0.05, gyroscope_bias: 0.005}}]"
)
GUSTS = (
    "effects=[{plugin: wind, parameters: {velocity: [5, 0, 0], gust_speed: 3, gust_duration: 1, "
    "gust_interval: 3, period: 10}}, {plugin: body_drag, parameters: "
    "{linear: [0.05, 0.05, 0.08], quadratic: [0.02, 0.02, 0.04]}}]"
)


@pytest.mark.parametrize("overrides", [[GUSTS], [GUSTS, IMU]])
def test_gusts_move_it_by_centimetres_with_a_noisy_imu_too(overrides: list[str]) -> None:
    measured = "measured: imu" if IMU in overrides else "measured: state"
    assert error_of(stand, measured, overrides) < 0.02


@pytest.mark.parametrize("overrides", [[], [IMU]])
def test_ten_metres_a_second_are_followed_to_centimetres(overrides: list[str]) -> None:
    measured = "measured: imu" if overrides else "measured: state"
    assert error_of(eight, measured, overrides) < 0.03
