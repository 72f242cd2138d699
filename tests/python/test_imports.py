"""`skybody import`: a flight log of a real flight, by a map of its columns."""

from __future__ import annotations

import gzip
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from imported import (
    BODY,
    FLIP,
    MODEL,
    PLACE,
    PROGRAM,
    REAL,
    ROTORS,
    START,
    TIME,
    TURN,
    columns,
    load,
    same_turns,
    write_csv,
    write_map,
)
from skybody.imports import motion
from skybody.imports.__main__ import main
from skybody.imports.laws import Law
from skybody.look.film import Film, Panel, Size
from skybody.look.flight import Flight, rotation_of
from skybody.look.scene import Scene, Style

# --- CSV ----------------------------------------------------------------------------------------


def test_recorded_values_are_in_the_log_as_they_were(tmp_path: Path) -> None:
    robot = PLACE | TURN
    robot |= {"velocity": {"columns": ["vx", "vy", "vz"]}}
    robot |= {"angular_velocity": {"columns": ["wx", "wy", "wz"]}}
    flight, body = load(tmp_path, columns(), robot)
    np.testing.assert_allclose(flight.time, TIME, rtol=0, atol=1e-6)  # of a time of 1.7e9 s
    assert flight.attributes["time_origin"] == START
    np.testing.assert_array_equal(
        body[:, [0, 1, 2, 7, 8, 9, 10, 11, 12]], BODY[:, [0, 1, 2, *range(7, 13)]]
    )
    np.testing.assert_allclose(body[:, 3:7], BODY[:, 3:7], atol=1e-15)  # normalized again
    assert flight.body_names == ["cf.base_link"]
    assert flight.attributes["policy"] == "a real flight"
    assert flight.events == [(0.0, "imported from flight.csv")]
    speed, unit = flight.series("speed")
    np.testing.assert_allclose(speed, np.hypot(2.6, 0.1), rtol=1e-6)  # of float32
    assert unit == "m/s"


def test_velocities_that_are_not_recorded_follow_from_the_poses(tmp_path: Path) -> None:
    _, body = load(tmp_path, columns(), PLACE | TURN)
    inner = slice(10, -10)
    # A parabola through 0.11 s of a motion with 1.3 rad/s: 1e-3 of the greatest derivative.
    np.testing.assert_allclose(body[inner, 7:10], BODY[inner, 7:10], atol=4e-3)
    np.testing.assert_allclose(body[inner, 10:], BODY[inner, 10:], atol=1e-3)
    np.testing.assert_allclose(body[:, 7:10], BODY[:, 7:10], atol=0.02)  # one-sided at the ends


def test_derivatives_are_right_at_uneven_times() -> None:
    rng = np.random.default_rng(3)
    time = np.cumsum(rng.uniform(0.002, 0.02, 300))
    values = np.stack([3.0 * time - 2.0, time**2], axis=1)  # parabolas: exact up to round-off
    found = motion.derivative(time, values, 0.1)
    np.testing.assert_allclose(
        found, np.stack([np.full_like(time, 3.0), 2.0 * time], axis=1), atol=1e-9
    )


def test_a_derivative_averages_noise() -> None:
    rng = np.random.default_rng(4)
    noise = rng.normal(size=(len(TIME), 1))
    found = motion.derivative(TIME, noise, 0.3)
    neighbours = np.diff(noise, axis=0) / 0.01
    assert found.std() < 0.05 * neighbours.std()


def test_angles_in_degrees_and_ned_give_the_same_flight(tmp_path: Path) -> None:
    ned = columns()
    for k, name in enumerate(("x", "y", "z")):
        ned[name] = FLIP[k] * BODY[:, k]
    flip = np.diag(FLIP)
    turned = flip @ rotation_of(BODY[:, 3:7]) @ flip
    angles = np.stack(
        [
            np.arctan2(turned[:, 2, 1], turned[:, 2, 2]),
            -np.arcsin(turned[:, 2, 0]),
            np.arctan2(turned[:, 1, 0], turned[:, 0, 0]),
        ]
    )
    ned |= dict(zip(("roll", "pitch", "yaw"), np.degrees(angles), strict=True))
    robot = PLACE | {"euler": {"columns": ["roll", "pitch", "yaw"], "unit": "deg"}}
    _, body = load(tmp_path, ned, robot, frame="ned")
    np.testing.assert_array_equal(body[:, :3], BODY[:, :3])
    same_turns(body[:, 3:7], BODY[:, 3:7], 1e-14)  # angles in degrees and back
    signs = np.sum(body[1:, 3:7] * body[:-1, 3:7], axis=1)
    assert signs.min() > 0.9  # no jumps between q and -q


def test_vectors_in_other_axes_are_turned(tmp_path: Path) -> None:
    data = columns()
    axes = rotation_of(BODY[:, 3:7])
    data |= dict(zip("abc", np.einsum("nji,nj->ni", axes, BODY[:, 7:10]).T, strict=True))
    data |= dict(zip("def", np.einsum("nij,nj->ni", axes, BODY[:, 10:]).T, strict=True))
    robot = PLACE | TURN
    robot |= {"velocity": {"columns": list("abc"), "axes": "body"}}
    robot |= {"angular_velocity": {"columns": list("def"), "axes": "world"}}
    _, body = load(tmp_path, data, robot)
    np.testing.assert_allclose(body[:, 7:], BODY[:, 7:], atol=1e-14)


def test_units_and_compressed_files(tmp_path: Path) -> None:
    data = {name: values for name, values in columns().items() if name in ("t", "x", "y", "z")}
    data = {"t": np.round(TIME * 1e6), **{n: 1e3 * data[n] for n in ("x", "y", "z")}}
    path = write_csv(tmp_path / "flight.csv", data)
    packed = tmp_path / "flight.csv.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    robot = {"position": {"columns": ["x", "y", "z"], "unit": "mm"}}
    used = write_map(tmp_path / "map.yaml", robot, time={"column": "t", "unit": "us"})
    assert main([str(packed), "--map", str(used), "-o", str(tmp_path / "a.h5")]) == 0
    flight = Flight(tmp_path / "a.h5")
    np.testing.assert_allclose(flight.time, TIME, rtol=0, atol=1e-12)
    np.testing.assert_allclose(flight.bodies[:, 0, :3], BODY[:, :3], rtol=1e-14)
    np.testing.assert_array_equal(flight.bodies[:, 0, 3:7], np.tile([1.0, 0, 0, 0], (400, 1)))


def test_rotors_goals_and_sensors_of_a_map(tmp_path: Path) -> None:
    data = columns()
    data |= {f"m{k}": np.linspace(0.0, 100.0 * (k + 1), len(TIME)) for k in range(4)}
    data |= {"gx": np.ones_like(TIME), "gy": 0 * TIME, "gz": 2 * np.ones_like(TIME)}
    data |= {"gyaw": 90 * np.ones_like(TIME), "ax": 0 * TIME, "ay": 0 * TIME, "az": 0 * TIME + 1}
    motors = {name: f"m{k}" for k, name in enumerate(("back_right", "front_left"))}
    robot = PLACE | TURN | {"goal": {"columns": ["gx", "gy", "gz"]}}
    robot |= {"goal_yaw": {"columns": ["gyaw"], "unit": "deg"}}
    robot |= {"rotor_speed": {"columns": motors, "law": "polynomial", "coefficients": [5, 2]}}
    sensors = {"imu.specific_force": {"columns": ["ax", "ay", "az"], "unit": "g"}}
    flight, body = load(tmp_path, data, robot, sensors=sensors)
    assert flight.rotor_names == [f"cf.{name}" for name in ROTORS]
    np.testing.assert_allclose(flight.rotor_speed[:, 3], 5 + 2 * data["m0"], rtol=1e-15)
    np.testing.assert_allclose(flight.rotor_speed[:, 0], 5 + 2 * data["m1"], rtol=1e-15)
    assert not flight.rotor_speed[:, 1:3].any()  # not in the map
    goal = flight.goals["cf.base_link"]
    np.testing.assert_allclose(goal, np.tile([1, 0, 2, np.pi / 2], (400, 1)), rtol=1e-15)
    error, unit = flight.series("position_error")
    np.testing.assert_allclose(error, np.linalg.norm(body[:, :3] - [1, 0, 2], axis=1), rtol=1e-6)
    force, unit = flight.series("imu.specific_force[2]")
    assert (force[0], unit) == (9.80665, "m/s^2")


def test_laws_of_motors() -> None:
    values = np.array([[-1.0, 0.0], [50.0, 25.0], [100.0, 200.0]])
    most = np.array([1000.0, 2000.0])
    span = (0.0, 100.0)
    share = Law("speed_share", span).speeds(values, 1.0, most)
    np.testing.assert_array_equal(share, [[0.0, 0.0], [500.0, 500.0], [1000.0, 2000.0]])
    thrust = Law("thrust_share", span).speeds(values, 1.0, most)
    np.testing.assert_allclose(thrust[1], [1000.0 * np.sqrt(0.5), 1000.0])
    polynomial = Law("polynomial", span, (10.0, 1.0, 0.5)).speeds(values, 1.0, most)
    np.testing.assert_array_equal(polynomial[:, 0], [0.0, 1310.0, 5110.0])  # stands at 0
    np.testing.assert_array_equal(Law("speed", None).speeds(values, 2.0, most), 2.0 * values)


def test_several_bodies_of_one_log(tmp_path: Path) -> None:
    data = columns() | {"lx": BODY[:, 0], "ly": BODY[:, 1], "lz": BODY[:, 2] - 0.5}
    log = write_csv(tmp_path / "flight.csv", data)
    load_map = {"model": "models/load/load.urdf", "position": {"columns": ["lx", "ly", "lz"]}}
    robots = {"load": load_map, "cf": {"model": MODEL, **PLACE, **TURN}}
    used = tmp_path / "map.yaml"
    used.write_text(yaml.safe_dump({"time": {"column": "t"}, "robots": robots}, sort_keys=False))
    assert main([str(log), "--map", str(used), "-o", str(tmp_path / "a.h5")]) == 0
    flight = Flight(tmp_path / "a.h5")
    assert [name.split(".")[0] for name in flight.body_names] == ["load", "cf"]
    np.testing.assert_array_equal(flight.bodies[:, 0, 2], BODY[:, 2] - 0.5)
    np.testing.assert_array_equal(flight.bodies[:, 1, :3], BODY[:, :3])
    assert flight.series("load.speed")[1] == flight.series("cf.speed")[1] == "m/s"


def test_obstacles_of_the_real_world_are_drawn(tmp_path: Path) -> None:
    tree = {"name": "tree", "cylinder": [0.2, 3], "position": [1, 2, 1.5]}
    flight, _ = load(tmp_path, columns(), PLACE | TURN, obstacles=[tree])
    (shape,) = Scene(flight).obstacles
    np.testing.assert_array_equal(shape.position, [1.0, 2.0, 1.5])


def test_a_part_of_the_log_can_be_imported(tmp_path: Path) -> None:
    log = write_csv(tmp_path / "flight.csv", columns())
    used = write_map(tmp_path / "map.yaml", PLACE | TURN)
    out = tmp_path / "flight.h5"
    options = ["--from", "0.995", "--until", "2.005"]
    assert main([str(log), "--map", str(used), "-o", str(out), *options]) == 0
    flight = Flight(out)
    np.testing.assert_array_equal(flight.bodies[:, 0, :3], BODY[100:201, :3])
    assert flight.time[0] == 0.0


def test_the_log_is_rendered_plotted_and_shown_beside_a_simulation(tmp_path: Path) -> None:
    load(tmp_path, columns(), PLACE | TURN)
    real = tmp_path / "flight.h5"
    command = [PROGRAM, "run", "hover_crazyflie", "--steps", "30", "--no-picture"]
    subprocess.run([*command, "--out", tmp_path / "sim"], check=True, capture_output=True)
    both = tmp_path / "both.png"
    render = [PROGRAM, "render", real, tmp_path / "sim", "--ghost", "--size", "320x180", "--thrust"]
    subprocess.run([*render, "--at", "0.02", "-o", both], check=True, capture_output=True)
    assert both.stat().st_size > 1000
    subprocess.run([PROGRAM, "plot", real, "--out", tmp_path], check=True, capture_output=True)
    assert (tmp_path / "flight-0001.png").exists()
    scene, size = Scene(Flight(real), Style(trail=0.0)), Size(160, 96)
    film = Film([Panel((scene,), "orbit", 0, 0, 160, 96)], size)
    assert film.frame(1.0).std() > 5.0  # not of one colour


def test_the_program_writes_below_flights_by_default(tmp_path: Path) -> None:
    log = write_csv(tmp_path / "my_flight.csv", columns())
    used = write_map(tmp_path / "map.yaml", PLACE | TURN)
    command = [PROGRAM, "import", log.name, "--map", used.name]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    expected = "flight   3.990 s, 400 rows, 1 body\nlog      flights/my_flight/flight.h5\n"
    assert done.stdout == expected
    assert Flight(tmp_path / "flights/my_flight").scenario == "my_flight"


# --- flights of others --------------------------------------------------------------------------

real_flights = pytest.mark.skipif(not REAL.is_dir(), reason="no recorded flights here")


@real_flights
def test_a_recorded_flight_of_a_crazyflie(tmp_path: Path) -> None:
    log = REAL / "nanobench/B3_figure8_medium_rep1.csv.gz"
    out = tmp_path / "real.h5"
    assert main([str(log), "--map", "nanobench", "-o", str(out)]) == 0
    flight = Flight(out)
    assert (len(flight.time), flight.scenario) == (2476, "B3_figure8_medium_rep1")
    body = flight.bodies[:, 0]
    in_air = body[:, 2] > 0.5
    assert 1.0 < body[:, 2].max() < 1.2  # flown at 1 m
    velocity = motion.derivative(flight.time, body[:, :3], 0.1)
    np.testing.assert_allclose(velocity[in_air], body[in_air, 7:10], atol=0.1)  # theirs
    # The gyroscope agrees with the attitude by Vicon, about x, y and z of the body.
    rate = motion.angular_velocities(flight.time, body[:, 3:7], 0.1)
    for k in range(2):  # about z it hardly turns
        assert np.corrcoef(rate[in_air, k], body[in_air, 10 + k])[0, 1] > 0.7
    assert 1500.0 < flight.rotor_speed[in_air].mean() < 2300.0
    assert flight.series("battery.voltage")[1] == "V"
    picture = tmp_path / "real.png"
    words = [PROGRAM, "render", out, "-o", picture, "--at", "12", "--size", "320x180"]
    subprocess.run(words, check=True, capture_output=True)
    assert picture.stat().st_size > 1000


@real_flights
def test_a_recorded_log_of_the_micro_sd_deck(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = REAL / "arplab/log16.usd.gz"
    assert main([str(log), "-o", str(tmp_path / "a.h5"), "--until", "5"]) == 0
    assert "cut short" not in capsys.readouterr().err  # its CRC is right
    flight = Flight(tmp_path / "a.h5", has_bodies=False)
    force = np.stack([flight.series(f"imu.specific_force[{k}]")[0] for k in range(3)], axis=1)
    assert abs(np.linalg.norm(force.mean(axis=0)) - 9.81) < 0.3  # it stands
