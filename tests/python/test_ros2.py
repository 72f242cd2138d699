"""`skybody ros2`: the map, the messages, and (where there is rclpy: ./dev ros) real nodes."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from skybody import InputError, Simulation
from skybody.camera import Camera
from skybody.ros2.bridge import Bridge, _Anything
from skybody.ros2.bridge_map import BridgeMap, Row, read_map
from skybody.ros2.commands import COMMANDS, px4_motors, px4_rates, px4_trajectory
from skybody.ros2.frames import yaw_of
from skybody.ros2.node import message_class

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
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
    message = _Anything()
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
    geometry_msgs = SimpleNamespace(TransformStamped=_Anything)
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
        message_class("no_msgs/msg/Own")
    assert "source the setup of a ROS 2 workspace" in str(error.value)


# --- real nodes ---------------------------------------------------------------------------------

needs_ros = pytest.mark.skipif(
    subprocess.run([sys.executable, "-c", "import rclpy"], capture_output=True, check=False)
    .returncode != 0,
    reason="there is no rclpy in this Python: ./dev ros runs these tests",
)  # fmt: skip
LOCAL = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": str(os.getpid() % 90 + 1)}


@pytest.fixture
def node(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """`skybody ros2` with the arguments and the map of the test."""
    arguments, text = request.param
    path = tmp_path / "map.yaml"
    path.write_text(text)
    command = [sys.executable, "-m", "skybody.ros2", *arguments, "--map", str(path)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, env=os.environ | LOCAL
    ) as process:
        assert process.stdout is not None
        assert "in lockstep" in process.stdout.readline()
        yield process
        process.terminate()


POLICY_MAP = (ROOT / "examples/ros2_policy.yaml").read_text()


@needs_ros
@pytest.mark.parametrize("node", [(["trajectory_ctbr", "--seed", "5"], POLICY_MAP)], indirect=True)
def test_a_policy_in_a_process_of_its_own_flies_the_same_bits(
    node: subprocess.Popen[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in LOCAL.items():
        monkeypatch.setenv(name, value)
    import rclpy
    from skybody.train.policy_file import read_policy, shipped_policy
    from std_msgs.msg import Float32MultiArray
    from std_srvs.srv import Trigger

    steps, seen = 300, []
    policy = read_policy(shipped_policy("trajectory_ctbr"))
    rclpy.init()
    client = rclpy.create_node("policy")
    actions = client.create_publisher(Float32MultiArray, "/quad/action", 10)

    def act(message: Any) -> None:
        row = np.array(message.data, np.float32)
        seen.append(row)
        action = policy(row[None])[0].astype(np.float32)
        actions.publish(Float32MultiArray(data=action.tolist()))

    client.create_subscription(Float32MultiArray, "/quad/observation", act, 10)
    ask = client.create_client(Trigger, "/skybody/states")
    assert ask.wait_for_service(20.0)
    while client.count_subscribers("/quad/action") == 0:
        time.sleep(0.05)
    ask.call_async(Trigger.Request())
    until = time.monotonic() + 60.0
    while len(seen) <= steps and time.monotonic() < until:
        rclpy.spin_once(client, timeout_sec=1.0)
    client.destroy_node()
    rclpy.try_shutdown()

    alone = Simulation("trajectory_ctbr", seed=5)
    alone.reset()
    for row in seen[: steps + 1]:
        np.testing.assert_array_equal(alone.observation, row)
        alone.step(policy(row[None])[0].astype(np.float32))
    assert len(seen) > steps


@needs_ros
@pytest.mark.parametrize("node", [(["trajectory_ctbr"], POLICY_MAP)], indirect=True)
def test_the_example_flies_by_a_policy_node(node: subprocess.Popen[str]) -> None:
    command = [sys.executable, str(ROOT / "examples/ros2_policy.py"), "--steps", "50"]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=60, check=False, env=os.environ | LOCAL
    )
    assert done.returncode == 0, done.stderr
    assert "50 steps, " in done.stdout


@needs_ros
@pytest.mark.parametrize(
    "node",
    [
        (
            ["hover_camera"],
            "publish:\n"
            "  - {topic: /depth, type: sensor_msgs/msg/Image, from: front.depth}\n"
            f"command: [{{topic: /action, type: {NUMBERS}, to: action}}]\n",
        )
    ],
    indirect=True,
)
def test_images_are_seen_by_a_subscriber_and_services_answer(
    node: subprocess.Popen[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in LOCAL.items():
        monkeypatch.setenv(name, value)
    import rclpy
    from rcl_interfaces.msg import Parameter, ParameterValue
    from rcl_interfaces.srv import SetParameters
    from sensor_msgs.msg import Image
    from std_srvs.srv import Trigger

    seen: list[Any] = []
    rclpy.init()
    client = rclpy.create_node("watcher")
    client.create_subscription(Image, "/depth", seen.append, 10)

    def call(kind: Any, name: str, request: Any) -> Any:
        service = client.create_client(kind, name)
        assert service.wait_for_service(20.0)
        answer = service.call_async(request)
        rclpy.spin_until_future_complete(client, answer, timeout_sec=20.0)
        return answer.result()

    while client.count_publishers("/depth") == 0:
        time.sleep(0.05)
    assert not call(Trigger, "/skybody/restore", Trigger.Request()).success  # nothing was saved
    assert call(Trigger, "/skybody/reset", Trigger.Request()).message == "episode 2"
    until = time.monotonic() + 20.0
    while not seen and time.monotonic() < until:
        rclpy.spin_once(client, timeout_sec=0.5)
    mass = Parameter(name="robots.quad.links.base_link.mass")
    mass.value = ParameterValue(type=3, double_value=-1.0)  # a double
    answer = call(
        SetParameters, "/skybody/set_parameters", SetParameters.Request(parameters=[mass])
    )
    assert not answer.results[0].successful
    client.destroy_node()
    rclpy.try_shutdown()
    alone = Simulation("hover_camera")
    alone.reset()
    alone.reset()
    pixels = np.frombuffer(bytes(seen[0].data), np.float32).reshape(64, 64)
    np.testing.assert_array_equal(pixels, alone.image("front.depth"))
