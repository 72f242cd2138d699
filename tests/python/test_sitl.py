"""`skybody sitl`: motor orders, frames, and autopilots that fly through their protocols."""

from __future__ import annotations

import random
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from skybody import CompiledScenario
from skybody.exports.frames import quaternion_of
from skybody.look.flight import rotation_of
from skybody.sitl import frames
from skybody.sitl.__main__ import main
from skybody.sitl.frames import Home
from skybody.sitl.messages import Messages
from skybody.sitl.motors import CCW, CW, FRAMES, rotor_order, usual_frame
from skybody.sitl.vehicle import Setup, Vehicle

CRAZYFLIE_HOVER = 0.75  # share of the greatest thrust


def quiet() -> Messages:
    return Messages(open("/dev/null", "w"))


# --- frames -------------------------------------------------------------------------------------

NORTH, EAST, DOWN = np.eye(3)


def test_w_has_north_along_x_west_along_y_and_up_along_z() -> None:
    assert frames.to_ned(np.array([1.0, 0.0, 0.0])).tolist() == NORTH.tolist()
    assert frames.to_ned(np.array([0.0, -1.0, 0.0])).tolist() == EAST.tolist()
    assert frames.to_ned(np.array([0.0, 0.0, -1.0])).tolist() == DOWN.tolist()
    assert frames.to_enu(np.array([2.0, -1.0, 3.0])).tolist() == [1.0, 2.0, 3.0]


def test_frd_has_right_along_minus_y_and_down_along_minus_z() -> None:
    assert frames.to_frd(np.array([1.0, -2.0, -3.0])).tolist() == [1.0, 2.0, 3.0]


def test_quaternions_of_autopilots_turn_frd_vectors_into_ned() -> None:
    generator = np.random.default_rng(1)
    for _ in range(20):
        ours = generator.normal(size=4)
        ours /= np.linalg.norm(ours)
        body = generator.normal(size=3)
        by_ours = frames.to_ned(rotation_of(ours) @ body)
        by_theirs = rotation_of(frames.to_ned_from_frd(ours)) @ frames.to_frd(body)
        assert np.allclose(by_ours, by_theirs, atol=1e-14)  # rounding


def test_a_turn_to_the_right_is_positive_yaw_in_ned() -> None:
    right = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # forward is east
    w, _, _, z = frames.to_ned_from_frd(quaternion_of(right))
    assert 2.0 * np.arctan2(z, w) == pytest.approx(np.pi / 2)


def test_a_hundred_metres_north_and_east_are_where_the_ellipsoid_has_them() -> None:
    latitude, longitude, altitude = Home(45.0, 10.0, 100.0).place(np.array([100.0, -100.0, 7.0]))
    # lengths of a degree at 45 deg, of WGS 84's series: 111131.8 m and 78846.8 m
    assert (latitude - 45.0) * 111131.8 == pytest.approx(100.0, abs=0.01)
    assert (longitude - 10.0) * 78846.8 == pytest.approx(100.0, abs=0.01)
    assert altitude == 107.0


def test_course_is_clockwise_from_north() -> None:
    west, south_east = np.array([0.0, 1.0, 0.0]), np.array([-1.0, -1.0, 5.0])
    assert frames.course_over_ground(west) == pytest.approx(270.0)
    assert frames.course_over_ground(south_east) == pytest.approx(135.0)


# --- motors -------------------------------------------------------------------------------------


@dataclass
class Hub:
    position: list[float]
    direction: float
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)


FRONT_RIGHT, BACK_LEFT = [1.0, -1.0, 0.0], [-1.0, 1.0, 0.0]
FRONT_LEFT, BACK_RIGHT = [1.0, 1.0, 0.0], [-1.0, -1.0, 0.0]
RIGHT, LEFT, FRONT, BACK = [0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]
X = [(FRONT_RIGHT, CCW), (BACK_LEFT, CCW), (FRONT_LEFT, CW), (BACK_RIGHT, CW)]
PLUS = [(RIGHT, CCW), (LEFT, CCW), (FRONT, CW), (BACK, CW)]
S, C = 3.0**0.5 / 2.0, 0.5
HEXA_X = [
    (RIGHT, CW),
    (LEFT, CCW),
    ([S, C, 0.0], CW),
    ([-S, -C, 0.0], CCW),
    ([S, -C, 0.0], CCW),
    ([-S, C, 0.0], CW),
]
X_REVERSED = [(place, -spin) for place, spin in X]
BETAFLIGHT_ORDER_REVERSED = [X_REVERSED[k] for k in (3, 0, 1, 2)]
ROWS = [
    *((autopilot, "x", X) for autopilot in FRAMES),
    *((autopilot, "plus", PLUS) for autopilot in FRAMES),
    ("ardupilot", "hexa-x", HEXA_X),
    ("px4", "hexa-x", HEXA_X),
    ("ardupilot", "x-reversed", BETAFLIGHT_ORDER_REVERSED),
    ("px4", "x-reversed", X_REVERSED),
    ("betaflight", "x-reversed", X_REVERSED),
    *((autopilot, "plus-reversed", [(p, -s) for p, s in PLUS]) for autopilot in FRAMES),
    ("px4", "hexa-x-reversed", [(p, -s) for p, s in HEXA_X]),
]


def test_every_frame_has_a_row_below() -> None:
    assert {(a, f) for a, f, _ in ROWS} == {(a, f) for a in FRAMES for f in FRAMES[a]}


@pytest.mark.parametrize(("autopilot", "frame", "motors"), ROWS)
def test_motors_are_matched_to_rotors_by_place_and_spin(
    autopilot: str, frame: str, motors: list[tuple[list[float], int]]
) -> None:
    places = list(range(len(motors)))
    random.Random(3).shuffle(places)
    rotors: list[Any] = [Hub(motors[k][0], motors[k][1]) for k in places]
    order = rotor_order(autopilot, frame, rotors)
    assert [places[index] for index in order] == list(range(len(motors)))


def rotors_of(scenario: str) -> list[Any]:
    return list(CompiledScenario(scenario).rotors)


def test_the_usual_frame_follows_from_the_places_of_the_rotors() -> None:
    assert usual_frame("px4", rotors_of("hover")) == "x"
    assert usual_frame("px4", rotors_of("hover_hummingbird")) == "plus"
    assert usual_frame("ardupilot", rotors_of("hover_firefly")) == "hexa-x"


@pytest.mark.parametrize("autopilot", FRAMES)
def test_mirrored_spins_are_refused_with_the_frame_that_has_them(
    autopilot: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([autopilot, "hover"]) == 2
    error = capsys.readouterr().err
    assert "all rotors spin the other way than the motors of frame `x`" in error
    assert (
        f"--frame x-reversed, and in the autopilot {FRAMES[autopilot]['x-reversed'].settings}"
        in error
    )
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["px4", "tricopter"], "px4 has no frame for a robot with 3 rotors"),
        (["px4", "hover", "--frame", "plus"], "the robot has rotors at"),
        (["betaflight", "hover_firefly"], "betaflight has no frame for a robot with 6 rotors"),
        (["ardupilot", "racing_duel"], "2 robots; allowed: --robot"),
        (["ardupilot", "hover", "--robot", "x"], "no robot `x`; allowed: --robot quad"),
        (["ardupilot", "no_such"], "no_such"),
    ],
)
def test_robots_that_do_not_fit_are_refused(
    arguments: list[str], problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    assert problem in capsys.readouterr().err


def test_an_unknown_frame_is_refused_with_the_known_ones(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["betaflight", "hover", "--frame", "hexa-x"])
    assert "allowed: x, plus, x-reversed, plus-reversed" in capsys.readouterr().err


# --- the vehicle --------------------------------------------------------------------------------


def test_a_vehicle_begins_at_rest_on_the_ground_and_stays_there() -> None:
    vehicle = Vehicle("px4", Setup("hover_crazyflie"))
    before = vehicle.read()
    vehicle.advance(np.zeros(4), 500)
    after = vehicle.read()
    # the legs sink into the ground by 1 mm: half of the weight on its springs
    assert np.abs(after.position - before.position).max() < 2e-3
    assert np.abs(after.rotation - before.rotation).max() < 1e-6
    assert after.specific_force == pytest.approx([0.0, 0.0, 9.81], abs=1e-3)


def test_sensors_of_the_scenario_are_taken_and_missing_ones_are_added() -> None:
    assert Vehicle("px4", Setup("hover_crazyflie")).added == [
        "imu",
        "barometer",
        "gnss",
        "magnetometer",
    ]
    whole = (
        "sensors=[{plugin: imu, parameters: {accelerometer_noise: 0.1}}, {plugin: barometer}]",
    )
    vehicle = Vehicle("px4", Setup("hover_crazyflie", overrides=whole))
    assert vehicle.added == ["gnss", "magnetometer"]
    assert vehicle.compiled.sensor_parameters("imu")["accelerometer_noise"] == [0.1]
    own = Vehicle("px4", Setup("hover_sensors", frame="x-reversed"))
    assert own.added == [] and len(own.compiled.sensors) == 12


@pytest.mark.parametrize(
    "values", [[np.nan] * 4, [-1.0] * 4, [-np.inf] * 4], ids=["nan", "minus_one", "minus_inf"]
)
def test_values_that_are_no_throttle_stop_the_rotors(values: list[float]) -> None:
    vehicle = Vehicle("px4", Setup("hover_crazyflie"))
    vehicle.advance(values, 100)
    assert not vehicle.simulation.rotor_speeds.any()


# --- the page -----------------------------------------------------------------------------------

PAGE = Path(__file__).resolve().parents[2] / "docs/sitl.md"
WORDS = {
    **{45: "front right", 30: "front right", 135: "back right", 150: "back right"},
    **{-45: "front left", -30: "front left", -135: "back left", -150: "back left"},
    **{0: "front", 180: "back", 90: "right", -90: "left"},
}


def test_the_page_has_the_table_of_motors() -> None:
    rows = [
        f"| {autopilot} | `{name}` | "
        + ", ".join(f"{WORDS[int(b)]} {'ccw' if s == CCW else 'cw'}" for b, s in frame.motors)
        + f" | {frame.settings} |"
        for autopilot, frames_of_it in FRAMES.items()
        for name, frame in frames_of_it.items()
    ]
    assert "\n".join(rows) in PAGE.read_text(encoding="utf-8")


def test_the_page_has_every_option(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--help"])
    options = set(re.findall(r"--[a-z-]+", capsys.readouterr().out)) - {"--help", "--model"}
    page = PAGE.read_text(encoding="utf-8")
    assert [option for option in sorted(options) if f"`{option}" not in page] == []
