"""`skybody import`: ULog, the Crazyflie's log, and MCAP."""

from __future__ import annotations

import struct
import subprocess
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
from imported import (
    PLACE,
    PROGRAM,
    TURN,
    columns,
    load,
    refused,
    same_turns,
    write_map,
)
from skybody.exports.__main__ import main as export_main
from skybody.imports import motion
from skybody.imports.__main__ import main
from skybody.imports.channels import Samples
from skybody.look.flight import Flight
from skybody.look.scene import Scene

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
    content = log.read_bytes()
    log.write_bytes(content[:3000])
    assert f"error: {log}: cannot be read as MCAP" in refused(capsys, log)
    for place in range(100, len(content), len(content) // 20):
        log.write_bytes(content[:place] + bytes(8) + content[place + 8 :])
        if main([str(log), "-o", str(tmp_path / "a.h5")]) != 0:
            message = capsys.readouterr().err
            assert message.count("\n") == 1
            assert message.startswith(f"error: {log}: ")
