"""`skybody ros1` and `skybody ros2` without middleware: the map, messages, steps."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from skybody import InputError, Simulation
from skybody.camera import Camera
from skybody.ros.bridge import Bridge
from skybody.ros.bridge_map import BridgeMap, Row, read_map
from skybody.ros.commands import COMMANDS, px4_motors, px4_rates, px4_trajectory
from skybody.ros.frames import yaw_of
from skybody.ros.messages import AnyMessage, message_class
from skybody.ros.states import set_stamp

NUMBERS = "std_msgs/msg/Float32MultiArray"


def bridge(scenario: str, *rows: Row, control: str | None = None, **more: Any) -> Bridge:
    """A bridge without middleware."""
    publish = [row for row in rows if row.part not in COMMANDS]
    command = [row for row in rows if row.part in COMMANDS]
    return Bridge(Simulation(scenario, control, **more), BridgeMap(publish, command, control))


# --- axes ---------------------------------------------------------------------------------------


def test_setpoints_of_px4_become_ours() -> None:
    rates = SimpleNamespace(roll=0.1, pitch=0.2, yaw=0.3, thrust_body=[0.0, 0.0, -0.5])
    np.testing.assert_allclose(px4_rates(rates), [0.5, 0.1, -0.2, -0.3])
    there = SimpleNamespace(position=[1.0, 2.0, -3.0], yaw=0.25)  # north, east, down; clockwise
    np.testing.assert_allclose(px4_trajectory(there), [1.0, -2.0, 3.0, -0.25])


def test_motors_of_px4_that_are_not_a_number_stand_still() -> None:
    motors = SimpleNamespace(control=[0.5, np.nan, 0.25, 1.0])
    np.testing.assert_array_equal(px4_motors(motors), [0.5, 0.0, 0.25, 1.0])


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5])
def test_a_heading_is_the_angle_about_the_vertical(yaw: float) -> None:
    assert yaw_of([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)]) == pytest.approx(yaw)


# --- messages -----------------------------------------------------------------------------------


def filled(made: Bridge, number: int = 0) -> Any:
    message = AnyMessage()
    made.fill(number, message)
    return message


def test_odometry_has_the_pose_in_the_world_and_the_twist_in_the_body() -> None:
    made = bridge("hover", Row("/o", "nav_msgs/msg/Odometry", "odometry"))
    simulation = made.simulation
    half = np.sqrt(0.5)
    simulation.teleport([1, 2, 3], [half, 0, 0, half], [0, 4, 0], [0.1, 0.2, 0.3])
    message = filled(made)
    pose, twist = message.pose.pose, message.twist.twist
    assert (pose.position.x, pose.position.y, pose.position.z) == pytest.approx((1, 2, 3))
    assert (pose.orientation.w, pose.orientation.z) == pytest.approx((half, half))
    # It looks along y of the world: 4 m/s along y are 4 m/s ahead.
    assert (twist.linear.x, twist.linear.y) == pytest.approx((4, 0), abs=1e-12)
    assert (twist.angular.x, twist.angular.z) == pytest.approx((0.1, 0.3))
    assert message.header.frame_id == "world"


def test_an_imu_shows_specific_force_and_rates_and_no_attitude() -> None:
    made = bridge("hover_sensors", Row("/imu", "sensor_msgs/msg/Imu", "imu"))
    message = filled(made)
    force = made.simulation.state("sensors.imu.specific_force")
    assert message.linear_acceleration.z == pytest.approx(force[2])
    assert message.orientation_covariance[0] == -1.0
    assert message.header.frame_id == "imu"


def test_an_image_has_its_encoding_and_its_bytes() -> None:
    made = bridge("hover_camera", Row("/depth", "sensor_msgs/msg/Image", "front.depth"))
    message = filled(made)
    assert (message.height, message.width, message.encoding) == (64, 64, "32FC1")
    pixels = np.frombuffer(message.data, np.float32).reshape(64, 64)
    np.testing.assert_array_equal(pixels, made.simulation.image("front.depth"))


def test_a_camera_tells_its_intrinsics() -> None:
    made = bridge("hover_camera", Row("/info", "sensor_msgs/msg/CameraInfo", "front"))
    message = filled(made)
    camera = Camera(made.simulation.compiled, "front")
    np.testing.assert_array_equal(np.reshape(message.k, (3, 3)), camera.intrinsics)
    assert (message.width, message.height) == (64, 64)
    assert message.distortion_model == "plumb_bob"


def test_transforms_and_point_clouds_have_the_fields_of_ros(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    field = type("PointField", (SimpleNamespace,), {"FLOAT32": 7})
    sensor_msgs = SimpleNamespace(PointField=field)
    monkeypatch.setitem(sys.modules, "sensor_msgs.msg", sensor_msgs)
    geometry_msgs = SimpleNamespace(TransformStamped=AnyMessage)
    monkeypatch.setitem(sys.modules, "geometry_msgs.msg", geometry_msgs)
    lidar = "{plugin: lidar, parameters: {outputs: [points]}}"
    made = bridge(
        "hover",
        Row("/points", "sensor_msgs/msg/PointCloud2", "lidar.points"),
        Row("/tf", "tf2_msgs/msg/TFMessage", "tf"),
        overrides=[f"sensors=[{lidar}]", "observe=[lidar.points]"],
    )
    cloud = filled(made)
    points = made.simulation.image("lidar.points")
    assert (cloud.height, cloud.width) == points.shape[:2]
    assert [f.name for f in cloud.fields] == ["x", "y", "z"]
    np.testing.assert_array_equal(np.frombuffer(cloud.data, np.float32), points.ravel())
    (transform,) = filled(made, 1).transforms
    assert transform.child_frame_id == "quad/base_link"
    assert transform.transform.translation.z == made.simulation.bodies[0].position[2]


def test_topics_with_robot_are_there_for_each_robot() -> None:
    made = bridge("formation", Row("/{robot}/pose", "geometry_msgs/msg/PoseStamped", "pose"))
    robots = made.simulation.compiled.robots
    assert [row.topic for row in made.publish] == [f"/{robot}/pose" for robot in robots]
    assert [row.robot for row in made.publish] == robots


def test_a_rate_thins_out_messages_by_simulated_time() -> None:
    made = bridge(
        "hover",
        Row("/fast", "geometry_msgs/msg/PoseStamped", "pose"),
        Row("/slow", "geometry_msgs/msg/PoseStamped", "pose", rate=100.0),
    )
    counts = [0, 0]
    for _ in range(101):  # of 1 ms
        for number in made.due():
            counts[number] += 1
        made.simulation.step(np.zeros(4, np.float32))
    assert counts == [101, 11]


def test_a_rate_between_those_of_steps_holds_on_average() -> None:
    made = bridge("hover", Row("/pose", "geometry_msgs/msg/PoseStamped", "pose", rate=300.0))
    count = 0
    for _ in range(100):  # of 1 ms
        count += len(made.due())
        made.simulation.step(np.zeros(4, np.float32))
    assert count == 30


def test_messages_are_due_when_a_restore_puts_the_time_back() -> None:
    made = bridge("hover", Row("/pose", "geometry_msgs/msg/PoseStamped", "pose", rate=10.0))
    saved = made.simulation.save()
    for _ in range(50):
        made.due()
        made.simulation.step(np.zeros(4, np.float32))
    made.simulation.restore(saved)
    assert made.due() == []
    made.make_due()
    assert made.due() == [0]


# --- commands -----------------------------------------------------------------------------------


def test_actions_step_as_in_one_process() -> None:
    made = bridge("hover", Row("/a", NUMBERS, "action"), seed=3)
    alone = Simulation("hover", seed=3)
    alone.reset()
    random = np.random.default_rng(1)
    for _ in range(50):
        action = random.uniform(-1, 1, 4).astype(np.float32)
        assert made.take(0, SimpleNamespace(data=action.tolist())) == ""
        assert made.is_ready
        made.advance()
        alone.step(action)
    assert made.simulation.hash() == alone.hash()


def test_a_step_waits_for_the_command_of_each_robot() -> None:
    made = bridge("racing_duel", Row("/{robot}/cmd", NUMBERS, "ctbr"), control="ctbr")
    message = SimpleNamespace(data=[10.0, 0.0, 0.0, 0.0])
    made.take(0, message)
    assert not made.is_ready
    made.take(1, message)
    assert made.is_ready
    made.advance()
    assert not made.is_ready
    assert made.simulation.time > 0.0


def test_a_share_of_thrust_is_that_of_the_robots_largest() -> None:
    made = bridge("hover", Row("/r", "px4_msgs/msg/VehicleRatesSetpoint", "ctbr"), control="ctbr")
    message = SimpleNamespace(roll=0.0, pitch=0.0, yaw=0.0, thrust_body=[0, 0, -1.0])
    made.take(0, message)
    made.advance()
    rotor = made.simulation.compiled.rotors[0]
    most = 4 * rotor.thrust_constant * made.simulation.param("robots.quad.rotors[0].max_speed") ** 2
    assert made.simulation.commands[0] == pytest.approx(most)


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        ([1.0, 2.0], "/c: 2 numbers; allowed: 4"),
        ([np.nan, 0.0, 0.0, 0.0], "/c: a number is not finite; the last command stays"),
    ],
)
def test_a_wrong_command_is_refused_and_nothing_moves(data: list[float], problem: str) -> None:
    made = bridge("hover", Row("/c", NUMBERS, "ctbr"), control="ctbr")
    assert made.take(0, SimpleNamespace(data=data)) == problem
    assert not made.is_ready


# --- maps ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("- a", "a map has the keys"),
        ("pubish: []", "unknown key ['pubish']; allowed: clock, command, control, publish"),
        ("publish: [{topic: /a}]", "is no row; a row has topic, type, from"),
        ("publish: [{topic: /a, type: std_msgs/msg/Bool, from: odometry}]",
         "`odometry` as std_msgs/msg/Bool; allowed: nav_msgs/msg/Odometry"),
        ("command: [{topic: /a, type: std_msgs/msg/Bool, to: fly}]", "no command `fly`; there are"),
        ("command: [{topic: /a, type: std_msgs/msg/Bool, to: action}]",
         f"std_msgs/msg/Bool; allowed: {NUMBERS}"),
        (f"command: [{{topic: /a, type: {NUMBERS}, to: ctbr}}, "
         f"{{topic: /a, type: {NUMBERS}, to: ctbr}}]", "topics are named twice: /a"),
        ("publish: [", "is no YAML"),
        ("publish: 3", "publish: is `3`; allowed: a list of rows"),
        ("publish: [{topic: 5, type: a, from: b}]", "`topic` is `5`; allowed: a text"),
        ("publish: [{topic: /a, type: nav_msgs/msg/Odometry, from: odometry, rate: x}]",
         "/a: `rate` is `x`; allowed: 0 to 1e+06"),
        (f"{{control: attitude, command: [{{topic: /a, type: {NUMBERS}, to: ctbr}}]}}",
         "/a: `to: ctbr` needs `control: ctbr`; the map has `control: attitude`"),
    ],
)  # fmt: skip
def test_a_wrong_map_is_one_error_with_its_remedy(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        read_map(path)
    assert str(error.value).startswith(f"{path}: ")
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        (Row("/i", "sensor_msgs/msg/Imu", "imu"), "sensors.imu.specific_force"),
        (Row("/i", "sensor_msgs/msg/Image", "front.rgb"), "no image `front.rgb`"),
        (Row("/i", "my_msgs/msg/Own", "pose"), "there is no such row"),
        (Row("/p", "geometry_msgs/msg/PoseStamped", "pose", robot="qaud"), "qaud"),
        (Row("/p", "geometry_msgs/msg/PoseStamped", "pose", body="quad.leg"), "no body `quad.leg`"),
    ],
)
def test_a_part_that_the_scenario_lacks_is_one_error(row: Row, message: str) -> None:
    with pytest.raises(InputError) as error:
        bridge("hover", row)
    assert message in str(error.value)


def test_a_message_that_is_not_installed_names_the_remedy() -> None:
    with pytest.raises(InputError) as error:
        message_class("no_msgs/msg/Own", "install it")
    assert "no message no_msgs/msg/Own here: install it" in str(error.value)


def test_types_as_ros_1_writes_them_are_those_of_ros_2(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text("publish: [{topic: /a, type: nav_msgs/Odometry, from: odometry}]")
    assert read_map(path).publish[0].type == "nav_msgs/msg/Odometry"


def test_a_restore_drops_the_commands_that_wait() -> None:
    made = bridge("hover", Row("/a", NUMBERS, "action"))
    saved = made.simulation.save()
    made.take(0, SimpleNamespace(data=[0.0] * 4))
    made.restore(saved)
    assert not made.is_ready


def test_stamps_and_intrinsics_have_the_names_of_ros_1() -> None:
    stamp = SimpleNamespace(secs=0, nsecs=0)
    set_stamp(stamp, 2.25)
    assert (stamp.secs, stamp.nsecs) == (2, 250_000_000)
    made = bridge("hover_camera", Row("/info", "sensor_msgs/msg/CameraInfo", "front"))
    message = SimpleNamespace(header=SimpleNamespace(), D=[], K=[], R=[], P=[])
    made.fill(0, message)
    camera = Camera(made.simulation.compiled, "front")
    np.testing.assert_array_equal(np.reshape(message.K, (3, 3)), camera.intrinsics)
    assert not hasattr(message, "k")
