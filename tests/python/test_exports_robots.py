"""`skybody export`: bags of ROS 2, ULog and Rerun are read again by their own readers."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
import pyulog
from exported import (
    FLIP,
    check_odometry,
    check_times,
    data_of,
    export,
    names_of,
    read_bag,
    read_rerun,
    rows,
    xyz,
)
from PIL import Image
from skybody.look.flight import rotation_of

pytestmark = pytest.mark.usefixtures("small_blocks")


# --- ROS 2 --------------------------------------------------------------------------------------


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
@pytest.mark.parametrize("name", ["hover_sensors", "chase"])
def test_bags_have_poses_velocities_and_transforms(
    logs: dict[str, Path], tmp_path: Path, name: str, storage: str
) -> None:
    log = logs[name]
    out = export(log, "rosbag2", tmp_path / "bag", "--storage", storage)
    assert len(list(out.glob("*.mcap" if storage == "mcap" else "*.db3"))) == 1
    found, data = read_bag(out), data_of(log)
    for k, body in enumerate(names_of(log, "bodies", "items")):
        robot, link = body.split(".")
        topic = f"/{robot}" if link == "base_link" else f"/{robot}/{link}"
        odometry = found[f"{topic}/odometry"]
        check_times([time for time, _ in odometry], log)
        stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for _, m in odometry]
        check_times(stamps, log)
        check_odometry(
            [(m.pose.pose, m.twist.twist.linear, m.twist.twist.angular) for _, m in odometry],
            data["bodies"][:, k],
        )
        assert odometry[0][1].child_frame_id == f"{robot}/{link}"
        place = [xyz(m.transforms[k].transform.translation) for _, m in found["/tf"]]
        np.testing.assert_array_equal(place, data["bodies"][:, k, :3])


def test_bags_have_the_imu_goals_rotors_and_shapes(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["hover_sensors"]
    found, data = read_bag(export(log, "rosbag2", tmp_path / "bag")), data_of(log)
    first = names_of(log, "sensors").index("imu.specific_force[0]")
    force = [xyz(m.linear_acceleration) for _, m in found["/imu"]]
    rate = [xyz(m.angular_velocity) for _, m in found["/imu"]]
    np.testing.assert_array_equal(np.hstack([force, rate]), data["sensors"][:, first : first + 6])
    assert found["/imu"][0][1].orientation_covariance[0] == -1.0  # no orientation
    goals = [xyz(m.pose.position) for _, m in found["/goal/quad/base_link"]]
    np.testing.assert_array_equal(goals, data["goal"][:, 0, :3])
    rotors = found["/quad/rotors"]
    np.testing.assert_array_equal([m.velocity for _, m in rotors], data["rotor_speed"])
    assert [f"quad.{n}" for n in rotors[0][1].name] == names_of(log, "rotor_speed")
    ((_, shapes),) = found["/markers"]
    assert {m.header.frame_id for m in shapes.markers} >= {"quad/base_link", "quad/bob"}
    values = found["/log/info"]
    np.testing.assert_array_equal([m.data for _, m in values], data["info"])
    assert values[0][1].layout.dim[0].label.split(",") == names_of(log, "info")


def test_bags_have_images(logs: dict[str, Path], tmp_path: Path) -> None:
    found = read_bag(export(logs["chase"], "rosbag2", tmp_path / "bag", "--images", "orbit"))
    image = found["/camera/image/compressed"][0][1]
    assert Image.open(io.BytesIO(image.data.tobytes())).size == (640, 360)
    assert found["/camera/camera_info"][0][1].header.frame_id == image.header.frame_id


# --- ULog ---------------------------------------------------------------------------------------


def test_ulog_has_the_state_of_each_robot_in_ned_and_frd(
    logs: dict[str, Path], tmp_path: Path
) -> None:
    log = logs["chase"]
    found, data = pyulog.ULog(str(export(log, "ulog", tmp_path / "a.ulg"))), data_of(log)
    assert not found.file_corruption
    for k in range(4):
        body = data["bodies"][:, k]
        place = found.get_dataset("vehicle_local_position", k).data
        stamps = place["timestamp"] * 1000
        check_times(stamps.tolist(), log)
        expected = np.hstack([body[:, :3] * FLIP, body[:, 7:10] * FLIP]).astype(np.float32)
        np.testing.assert_array_equal(
            np.stack([place[c] for c in ("x", "y", "z", "vx", "vy", "vz")], axis=1), expected
        )
        turn = found.get_dataset("vehicle_attitude", k).data
        q = np.stack([turn[f"q[{j}]"] for j in range(4)], axis=1).astype(np.float64)
        flip = np.diag(FLIP)
        turned = flip @ rotation_of(body[:, 3:7]) @ flip  # NED from W from B from FRD
        np.testing.assert_allclose(rotation_of(q), turned, atol=1e-6)  # of float32
        heading = np.arctan2(turned[:, 1, 0], turned[:, 0, 0])
        np.testing.assert_allclose(place["heading"], heading, atol=1e-6)
        rate = found.get_dataset("vehicle_angular_velocity", k).data
        rates = np.stack([rate[f"xyz[{j}]"] for j in range(3)], axis=1)
        np.testing.assert_array_equal(rates, (body[:, 10:] * FLIP).astype(np.float32))
        outputs = found.get_dataset("actuator_outputs", k).data
        speeds = np.stack([outputs[f"output[{j}]"] for j in range(4)], axis=1)
        mine = data["rotor_speed"][:, 4 * k : 4 * k + 4]
        np.testing.assert_array_equal(speeds, mine.astype(np.float32))
        assert set(outputs["noutputs"]) == {4}


def test_ulog_has_sensors_goals_and_events(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["hover_sensors"]
    found, data = pyulog.ULog(str(export(log, "ulog", tmp_path / "a.ulg"))), data_of(log)
    sensors = names_of(log, "sensors")
    imu = found.get_dataset("sensor_combined").data
    first = sensors.index("imu.specific_force[0]")
    force = np.stack([imu[f"accelerometer_m_s2[{j}]"] for j in range(3)], axis=1)
    expected = (data["sensors"][:, first : first + 3] * FLIP).astype(np.float32)
    np.testing.assert_array_equal(force, expected)
    volts = found.get_dataset("battery_status", 1).data["voltage_v"]  # instance 0: the pack's
    place = sensors.index("battery.voltage")
    np.testing.assert_array_equal(volts, data["sensors"][:, place].astype(np.float32))
    goal = found.get_dataset("vehicle_local_position_setpoint").data
    np.testing.assert_array_equal(goal["z"], -data["goal"][:, 0, 2].astype(np.float32))
    assert found.logged_messages[0].message == "reset"
    assert found.msg_info_dict["scenario"] == "hover_sensors"


# --- Rerun --------------------------------------------------------------------------------------


def test_rrd_has_transforms_shapes_and_all_values(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["cooperative_payload_ropes"]
    found, data = read_rerun(export(log, "rrd", tmp_path / "a.rrd")), data_of(log)
    for k, body in enumerate(names_of(log, "bodies", "items")):
        entity = body.replace(".", "/")
        moved = found[f"/world/{entity}"]
        stamps = [int(np.timedelta64(t, "ns").astype(np.int64)) for t in moved["time"]]
        check_times(stamps, log)
        place = np.array(moved["Transform3D:translation"]).reshape(-1, 3)
        np.testing.assert_array_equal(place, data["bodies"][:, k, :3].astype(np.float32))
        turn = np.array(moved["Transform3D:quaternion"]).reshape(-1, 4)[:, [3, 0, 1, 2]]
        np.testing.assert_array_equal(turn, data["bodies"][:, k, 3:7].astype(np.float32))
        values = np.array(found[f"/log/bodies/{entity}"]["Scalars:scalars"][: len(data["time"])])
        np.testing.assert_array_equal(values, data["bodies"][:, k])
    for name, values in rows(data).items():
        if name not in ("bodies", "goal"):
            scalars = [v for v in found[f"/log/{name}"]["Scalars:scalars"] if v]
            np.testing.assert_array_equal(np.array(scalars), values)
    assert found["/log/info"]["SeriesLines:names"][0] == names_of(log, "info")
    assert "Boxes3D:half_sizes" in found["/world/load/plate/shapes/boxes"]
    assert found["/events"]["TextLog:text"][0] == ["reset"]
    assert len(found["/world/couplings"]["LineStrips3D:strips"][0]) == 3
