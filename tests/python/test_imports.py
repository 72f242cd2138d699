"""`skybody import`: a flight log of a real flight, by a map of its columns."""

from __future__ import annotations

import csv
import gzip
import struct
import subprocess
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from skybody import InputError
from skybody.exports.__main__ import main as export_main
from skybody.imports import motion, sources
from skybody.imports.__main__ import main
from skybody.imports.channels import Samples
from skybody.imports.laws import Law
from skybody.imports.map_file import read_map, shipped_maps
from skybody.look.film import Film, Panel, Size
from skybody.look.flight import Flight, rotation_of
from skybody.look.scene import Scene, Style

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
REAL = ROOT.parent / "shared/data/flights"
MODEL = "models/crazyflie/crazyflie.urdf"
ROTORS = ("front_left", "front_right", "back_left", "back_right")
FLIP = np.array([1.0, -1.0, -1.0])
START = 1_700_000_000.25  # of the recorded time [s]

Array = NDArray[np.float64]


# --- a flight that is known ---------------------------------------------------------------------

TIME = np.arange(0.0, 4.0, 0.01)


def body_of(time: Array) -> Array:
    """A body on a rising circle, which turns about a tilted axis: the 13 values, (rows, 13)."""
    rate, spin = 1.3, 0.8  # [rad/s]
    axis = np.array([0.48, -0.36, 0.8])
    c, s = np.cos(rate * time), np.sin(rate * time)
    place = np.stack([2.0 * c, 2.0 * s, 1.0 + 0.1 * time], axis=1)
    velocity = np.stack([-2.6 * s, 2.6 * c, np.full_like(time, 0.1)], axis=1)
    half = 0.5 * spin * time
    turn = np.concatenate([np.cos(half)[:, None], np.sin(half)[:, None] * axis], axis=1)
    return np.concatenate([place, turn, velocity, np.tile(spin * axis, (len(time), 1))], axis=1)


def angles_of(quaternions: Array) -> Array:
    """Roll, pitch and yaw (z-y'-x'') [rad]."""
    m = rotation_of(quaternions)
    return np.stack(
        [
            np.arctan2(m[:, 2, 1], m[:, 2, 2]),
            -np.arcsin(m[:, 2, 0]),
            np.arctan2(m[:, 1, 0], m[:, 0, 0]),
        ],
        axis=1,
    )


BODY = body_of(TIME)
PLACE = {"position": {"columns": ["x", "y", "z"]}}
TURN = {"quaternion": {"columns": ["qx", "qy", "qz", "qw"], "order": "xyzw"}}


def columns() -> dict[str, Array]:
    """Columns of the known flight."""
    q = BODY[:, 3:7]
    names = ("x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz")
    found = dict(zip(names, np.concatenate([BODY[:, :3], q, BODY[:, 7:]], axis=1).T, strict=True))
    return {"t": START + TIME} | found


def write_csv(path: Path, data: Mapping[str, Sequence[Any] | Array]) -> Path:
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(data)
        for row in zip(*data.values(), strict=True):
            rows.writerow([f"{v!r}" if isinstance(v, float) else v for v in map(plain, row)])
    return path


def plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def write_map(path: Path, robot: Mapping[str, Any], **more: Any) -> Path:
    """A map of one robot `cf`."""
    content = {"time": {"column": "t"}, "robots": {"cf": {"model": MODEL, **robot}}, **more}
    content = {key: value for key, value in content.items() if value is not None}
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    return path


def load(
    tmp_path: Path, data: Mapping[str, Any], robot: Mapping[str, Any], **more: Any
) -> tuple[Flight, Array]:
    """Imports columns; gives the flight and the states of its only body."""
    log = write_csv(tmp_path / "flight.csv", data)
    used = write_map(tmp_path / "map.yaml", robot, **more)
    out = tmp_path / "flight.h5"
    assert main([str(log), "--map", str(used), "-o", str(out)]) == 0
    flight = Flight(out)
    return flight, flight.bodies[:, 0]


def same_turns(found: Array, expected: Array, tolerance: float) -> None:
    np.testing.assert_allclose(rotation_of(found), rotation_of(expected), atol=tolerance)


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
    expected = "flight   3.990 s, 400 rows, 1 bodies\nlog      flights/my_flight/flight.h5\n"
    assert done.stdout == expected
    assert Flight(tmp_path / "flights/my_flight").scenario == "my_flight"


# --- ULog ---------------------------------------------------------------------------------------


def test_a_ulog_with_topics_of_px4(tmp_path: Path) -> None:
    flight, body = load(tmp_path, columns(), PLACE | TURN)
    log = tmp_path / "log.ulg"
    assert export_main([str(flight.path), "--to", "ulog", "-o", str(log)]) == 0
    out = tmp_path / "back.h5"
    assert main([str(log), "-o", str(out)]) == 0
    back = Flight(out)
    np.testing.assert_allclose(back.time, flight.time, rtol=0, atol=1e-6)
    found = back.bodies[:, 0]
    np.testing.assert_allclose(found[:, :3], body[:, :3], rtol=1e-6)  # of float32
    np.testing.assert_allclose(found[:, 7:], body[:, 7:], atol=1e-6)
    same_turns(found[:, 3:7], body[:, 3:7], 1e-6)
    assert back.body_names == ["vehicle.base_link"]


def test_series_with_other_times_meet_at_those_of_the_pose() -> None:
    slow = Samples(np.array([0.0, 1.0]), np.array([[0.0], [10.0]]))
    times = np.array([-1.0, 0.25, 0.5, 2.0])
    np.testing.assert_allclose(motion.at(slow, times)[:, 0], [0.0, 2.5, 5.0, 10.0])
    np.testing.assert_array_equal(motion.held(slow, times)[:, 0], [0.0, 0.0, 0.0, 10.0])
    turn = np.array([[1.0, 0.0, 0.0, 0.0], [-np.sqrt(0.5), 0.0, 0.0, -np.sqrt(0.5)]])
    middle = motion.quaternions_at(Samples(slow.time, turn), np.array([0.5]))[0]
    np.testing.assert_allclose(middle, [np.cos(np.pi / 8), 0.0, 0.0, np.sin(np.pi / 8)], atol=1e-15)


# --- the Crazyflie's log ------------------------------------------------------------------------


def usd_bytes(rows: int = 50, version: int = 2) -> bytes:
    """A log of accelerometer, gyroscope and one motor."""
    words = ["acc.x(f)", "acc.y(f)", "acc.z(f)", "gyro.x(f)", "gyro.y(f)", "gyro.z(f)"]
    words += [f"motor.m{k}(I)" for k in (1, 2, 3, 4)]
    data = struct.pack("<BHH", 0xBC, version, 1) + struct.pack("<H", 65535)
    data += b"fixedFrequency\0" + struct.pack("<H", len(words))
    data += b"".join(word.encode() + b"\0" for word in words)
    for k in range(rows):
        values = (0.5, 0.0, 1.0, 0.0, 180.0, 0.0, 65535, 0, 1000 * k, 0)
        data += struct.pack("<HQ6f4I", 65535, 5_000_000 + 1000 * k, *values)
    return data + struct.pack("<I", zlib.crc32(data))


def test_a_log_without_poses_has_sensors_and_rotor_speeds_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, out = tmp_path / "log10.usd", tmp_path / "a.h5"
    log.write_bytes(usd_bytes())
    assert main([str(log), "-o", str(out)]) == 0
    captured = capsys.readouterr()
    assert captured.err == (
        f"note: {log}: has no poses; the log has sensors and rotor speeds alone\n"
    )
    assert captured.out.startswith("flight   0.049 s, 50 rows, 0 bodies\n")
    flight = Flight(out, has_bodies=False)
    np.testing.assert_allclose(flight.time, 0.001 * np.arange(50), atol=1e-12)
    assert flight.series("imu.specific_force[0]")[0][0] == 0.5 * 9.80665
    np.testing.assert_allclose(flight.series("imu.angular_rate[1]")[0], np.pi)
    speeds = dict(zip(flight.rotor_names, flight.rotor_speed.T, strict=True))
    np.testing.assert_allclose(speeds["crazyflie.front_right"], 426.24 + 0.028117 * 65535)
    assert not speeds["crazyflie.back_right"].any()  # its command is 0: it stands
    table = tmp_path / "a.csv"
    assert export_main([str(out), "--to", "csv", "-o", str(table)]) == 0
    for words in (["render", out, "-o", tmp_path / "a.png"], ["plot", out]):
        done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)
        assert done.returncode == 2
        assert "has no bodies to draw" in done.stderr


def test_a_log_that_is_cut_short_is_used_as_far_as_it_goes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log.usd"
    log.write_bytes(usd_bytes()[:-70])  # the CRC, a record and a part of one
    assert main([str(log), "-o", str(tmp_path / "a.h5")]) == 0
    note = capsys.readouterr().err.splitlines()[0]
    assert note == f"note: {log}: is cut short: its CRC is missing or wrong; 48 events are used"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"no log", "is no log of the Crazyflie's micro-SD deck"),
        (usd_bytes(version=9), "is of version 9; allowed: 1 and 2"),
        (usd_bytes()[:40], "is cut short or damaged in its head"),
        (usd_bytes()[:800] + b"\1\2" * 200, "is damaged at byte"),
    ],
)
def test_damaged_logs_of_the_crazyflie_are_errors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], content: bytes, message: str
) -> None:
    log = tmp_path / "log.usd"
    log.write_bytes(content)
    assert message in refused(capsys, log)
    assert list(tmp_path.iterdir()) == [log]


# --- MCAP ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log of a simulation with gates and drawn values."""
    folder = tmp_path_factory.mktemp("racing")
    command = [PROGRAM, "run", "racing", "--steps", "20", "--no-picture", "--out", folder]
    subprocess.run(command, check=True, capture_output=True, timeout=100)
    return folder / "flight.h5"


def test_an_exported_mcap_becomes_the_flight_log_again(simulated: Path, tmp_path: Path) -> None:
    log, out = tmp_path / "a.mcap", tmp_path / "back.h5"
    assert export_main([str(simulated), "--to", "mcap", "-o", str(log)]) == 0
    assert main([str(log), "-o", str(out)]) == 0
    with h5py.File(simulated) as there, h5py.File(out) as here:
        expected, found = there["episodes/0001"], here["episodes/0001"]
        assert set(found) == set(expected)
        for name in found:
            assert found[name].dtype == expected[name].dtype
            if name not in ("events", "params"):
                # Velocities are turned to B and back, times are in ns.
                np.testing.assert_allclose(found[name][:], expected[name][:], atol=1e-9)
        assert list(found["bodies"].attrs["items"]) == list(expected["bodies"].attrs["items"])
        assert here.attrs["scenario_hash"] == there.attrs["scenario_hash"]
    assert Flight(out).drawn == Flight(simulated).drawn
    assert Flight(out).events == Flight(simulated).events
    gates = [Scene(Flight(path)).obstacles for path in (simulated, out)]
    for a, b in zip(*gates, strict=True):
        np.testing.assert_array_equal(a.position, b.position)  # as drawn in that episode


@pytest.mark.parametrize("topic", ["odometry", "pose"])
def test_foxglove_messages_by_their_topic(simulated: Path, tmp_path: Path, topic: str) -> None:
    flight = Flight(simulated)
    robot = flight.body_names[0].split(".")[0]
    log, out = tmp_path / "a.mcap", tmp_path / "back.h5"
    assert export_main([str(simulated), "--to", "mcap", "-o", str(log)]) == 0
    used = write_map(tmp_path / "map.yaml", {"topic": f"/{robot}/{topic}"}, time=None)
    assert main([str(log), "--map", str(used), "-o", str(out)]) == 0
    back, body = Flight(out).bodies[:, 0], flight.bodies[:, 0]
    np.testing.assert_array_equal(back[:, :3], body[:, :3])
    same_turns(back[:, 3:7], body[:, 3:7], 1e-12)
    if topic == "odometry":
        np.testing.assert_allclose(back[:, 7:], body[:, 7:], atol=1e-12)


def test_odometry_of_ros_2_and_transforms_by_their_frame(simulated: Path, tmp_path: Path) -> None:
    flight = Flight(simulated)
    robot, link = flight.body_names[0].split(".")
    bag = tmp_path / "bag"
    options = ["--to", "rosbag2", "--storage", "mcap", "-o", str(bag)]
    assert export_main([str(simulated), *options]) == 0
    (log,) = bag.glob("*.mcap")
    out, body = tmp_path / "back.h5", flight.bodies[:, 0]
    used = write_map(tmp_path / "map.yaml", {"topic": f"/{robot}/odometry"}, time=None)
    assert main([str(log), "--map", str(used), "-o", str(out)]) == 0
    found = Flight(out)
    np.testing.assert_allclose(found.bodies[:, 0, [0, 1, 2]], body[:, :3], atol=0)
    np.testing.assert_allclose(found.bodies[:, 0, 7:], body[:, 7:], atol=1e-12)
    np.testing.assert_allclose(found.time, flight.time, atol=1e-9)
    head = f"/tf.transforms[{robot}/{link}].transform.translation"
    place = {"position": {"columns": [f"{head}.{axis}" for axis in "xyz"]}}
    used = write_map(tmp_path / "map.yaml", place, time=None)
    assert main([str(log), "--map", str(used), "-o", str(out)]) == 0
    np.testing.assert_array_equal(Flight(out).bodies[:, 0, :3], body[:, :3])


def test_unusable_mcap_files_are_errors(
    simulated: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "a.mcap"
    assert export_main([str(simulated), "--to", "mcap", "-o", str(log)]) == 0
    used = write_map(tmp_path / "map.yaml", {"topic": "/quad/odom"}, time=None)
    assert "no topic `/quad/odom` for " in refused(capsys, log, "--map", used)
    write_map(used, {"topic": "/log/info"}, time=None)
    message = refused(capsys, log, "--map", used)
    assert "messages of `/log/info` are of type skybody.info; allowed: foxglove.Odom" in message
    log.write_bytes(log.read_bytes()[:3000])
    assert f"error: {log}: cannot be read as MCAP" in refused(capsys, log)


# --- bad input ----------------------------------------------------------------------------------


def refused(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """The one line about an error; nothing is written."""
    capsys.readouterr()
    out = Path(str(arguments[0])).parent / "none.h5"
    try:
        status = main([*map(str, arguments), "-o", str(out)])
    except SystemExit as error:
        status = error.code  # type: ignore[assignment]
    message = capsys.readouterr().err
    assert status == 2
    assert message.count("\n") == 1, message
    assert message.startswith("error: ")
    assert not out.exists()
    return message


@pytest.mark.parametrize(
    ("robot", "more", "message"),
    [
        ({"position": {"columns": ["x", "y", "h"]}}, {},
         "no column `h` for robots.cf.position. There are: qw, qx, qy, qz, t, vx, vy, vz, wx"),
        ({"position": {"columns": ["x", "y", "vxx"]}}, {}, "; did you mean `vx`? There are: qw"),
        ({"position": {"columns": ["x", "y"]}}, {}, "robots.cf.position.columns: is `['x', 'y']`"),
        ({"position": {"columns": ["x", "y", "z"], "unit": "V"}}, {},
         "robots.cf.position.unit: is `V`. Allowed: m, cm, mm"),
        ({"positoin": 1}, {}, "robots.cf.positoin: unknown key; did you mean `position`?"),
        (PLACE | {"quaternion": {"columns": ["qx", "qy", "qz", "qw"]}}, {},
         "robots.cf.quaternion.order: is missing"),
        (PLACE | {"quaternion": {"columns": ["x", "y", "z", "qw"], "order": "wxyz"}}, {},
         "robots.cf.quaternion: quaternion 1 has norm "),
        (PLACE | TURN | {"euler": {"columns": ["x", "y", "z"]}}, {},
         "robots.cf.euler: is given besides `quaternion`"),
        (PLACE | {"rotor_speed": {"columns": {"left": "x"}}}, {},
         "no rotor `left` in the model; there are: front_left, front_right"),
        (PLACE | {"rotor_speed": {"columns": {"front_left": "x"}, "law": "thrust_share"}}, {},
         "robots.cf.rotor_speed.range: is missing"),
        (PLACE, {"frame": "xyz"}, "frame: is `xyz`. Allowed: enu, ned"),
        (PLACE, {"time": {"column": "T"}}, "no column `T` for time"),
        (PLACE, {"time": None}, "time: is missing: a CSV has no times but in a column"),
        (PLACE, {"window": 0}, "window: is `0`; allowed: 0.001 to 10"),
        (PLACE | {"model": "gone.urdf"}, {}, "robots.cf.model: no file `gone.urdf`; give a URDF"),
        (PLACE | {"model": "models/firefly_arm/firefly_arm.urdf"}, {},
         "robots.cf.model: models/firefly_arm/firefly_arm.urdf has 3 bodies; allowed: one"),
    ],
)  # fmt: skip
def test_mistakes_in_maps_are_named_with_their_key(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    robot: Mapping[str, Any],
    more: Mapping[str, Any],
    message: str,
) -> None:
    log = write_csv(tmp_path / "flight.csv", columns())
    used = write_map(tmp_path / "map.yaml", robot, **more)
    assert message in refused(capsys, log, "--map", used)


def test_times_that_go_back_and_numbers_that_are_none_are_errors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    used = write_map(tmp_path / "map.yaml", PLACE | TURN)
    back = {name: values.copy() for name, values in columns().items()}
    back["t"][7] = back["t"][5]
    log = write_csv(tmp_path / "flight.csv", back)
    message = refused(capsys, log, "--map", used)
    assert f"{log}: line 9: the time of x goes back from " in message
    gap = {name: values.copy() for name, values in columns().items()}
    gap["y"][3:5] = np.nan
    write_csv(log, gap)
    message = refused(capsys, log, "--map", used)
    assert f"{log}: line 5: `y` is nan, and 2 of 400 samples are not finite" in message
    write_map(used, PLACE | TURN, gaps="interpolate")
    out = tmp_path / "a.h5"
    assert main([str(log), "--map", str(used), "-o", str(out)]) == 0
    flight = Flight(out)
    assert len(flight.time) == 400  # attitude has all rows
    np.testing.assert_allclose(flight.bodies[:, 0, :3], BODY[:, :3], atol=2e-3)  # a chord of 0.03 s


def test_equal_times_count_once(tmp_path: Path) -> None:
    twice = {name: np.repeat(values, 2) for name, values in columns().items()}
    _, body = load(tmp_path, twice, PLACE | TURN)
    np.testing.assert_array_equal(body[:, :3], BODY[:, :3])


def test_rows_that_are_cut_short(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    used = write_map(tmp_path / "map.yaml", PLACE | TURN)
    log = write_csv(tmp_path / "flight.csv", columns())
    lines = log.read_text().splitlines()
    log.write_text("\n".join([*lines[:-1], lines[-1][:30]]))
    out = tmp_path / "a.h5"
    assert main([str(log), "--map", str(used), "-o", str(out)]) == 0
    assert capsys.readouterr().err == f"note: {log}: line 401 is cut short and left out\n"
    assert len(Flight(out).time) == 399
    log.write_text("\n".join([*lines[:5], lines[5][:30], *lines[6:]]))
    message = refused(capsys, log, "--map", used)
    assert f"{log}: line 6: has another number of cells than the names" in message
    log.write_text(lines[0] + "\n")
    assert "has no rows of numbers below its names" in refused(capsys, log, "--map", used)


def test_wrong_files_and_options_are_errors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = write_csv(tmp_path / "flight.csv", columns())
    used = write_map(tmp_path / "map.yaml", PLACE | TURN)
    shipped = ", ".join(shipped_maps())
    assert f"--map is missing: a file, or a shipped one: {shipped}" in refused(capsys, log)
    assert f"no map `px5`; give a file, or a shipped one: {shipped}" in refused(
        capsys, log, "--map", "px5"
    )
    assert "unknown ending `.txt`; allowed: .csv, " in refused(capsys, tmp_path / "a.txt")
    assert "no rows" not in refused(capsys, tmp_path / "gone.csv", "--map", used)
    assert "has 0 rows from 9 to inf s of 3.99 s" in refused(
        capsys, log, "--map", used, "--from", "9"
    )
    used.write_text("robots: [")
    assert f"{used}: is no YAML: " in refused(capsys, log, "--map", used)
    used.write_text("[1, 2]")
    assert f"{used}: is `[1, 2]`; allowed: keys with values" in refused(capsys, log, "--map", used)
    ulog = tmp_path / "a.ulg"
    ulog.write_bytes(b"no log at all")
    assert f"{ulog}: cannot be read as a ULog" in refused(capsys, ulog)


def test_a_missing_package_is_named_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError(name="pyulog")

    monkeypatch.setattr(sources.importlib, "import_module", missing)
    message = "a.ulg: needs the package `pyulog`: `pip install pyulog`"
    with pytest.raises(InputError, match=message):
        sources.source_of(Path("a.ulg")).read(Path("a.ulg"), None)  # type: ignore[arg-type]


def test_an_output_that_cannot_be_written_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = write_csv(tmp_path / "flight.csv", columns())
    used = write_map(tmp_path / "map.yaml", PLACE | TURN)
    assert main([str(log), "--map", str(used), "-o", "/proc/none/a.h5"]) == 2
    assert capsys.readouterr().err.startswith("error: /proc/none/a.h5: cannot be written")


@pytest.mark.parametrize("name", shipped_maps())
def test_shipped_maps_are_valid(name: str) -> None:
    used = read_map(ROOT / f"python/skybody/imports/maps/{name}.yaml")
    assert used.robots[0].rotors is not None


def test_the_map_on_the_page_is_valid(tmp_path: Path) -> None:
    page = (ROOT / "docs/imports.md").read_text()
    block = page.partition("## Maps\n\n")[2].partition("\n\n")[0]
    path = tmp_path / "map.yaml"
    path.write_text("\n".join(line.removeprefix("    ") for line in block.splitlines()))
    used = read_map(path)
    assert used.robots[0].rotors is not None
    assert set(used.sensors) == {"imu.specific_force", "battery.voltage"}


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
