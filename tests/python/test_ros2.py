"""`skybody ros2` as real nodes, where there is rclpy: ./dev ros."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from skybody import Simulation

ROOT = Path(__file__).resolve().parents[2]
NUMBERS = "std_msgs/msg/Float32MultiArray"
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
@pytest.mark.parametrize(
    ("topic", "name", "message"),
    [
        ("/a b", "skybody", "error: Invalid topic name: "),
        ("/a", "a b", "error: Invalid node name: "),
    ],
)
def test_a_name_that_ros_would_refuse_is_one_error(
    topic: str, name: str, message: str, tmp_path: Path
) -> None:
    path = tmp_path / "map.yaml"
    kind = "geometry_msgs/msg/PoseStamped"
    path.write_text(f"publish: [{{topic: {topic}, type: {kind}, from: pose}}]")
    command = [sys.executable, "-m", "skybody.ros2", "hover", "--map", str(path), "--name", name]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=60, check=False, env=os.environ | LOCAL
    )
    assert done.returncode == 2
    last = done.stderr.splitlines()[-1]  # rclpy may warn before it
    assert last.startswith(message)
    assert last.endswith(f"'{name if ' ' in name else topic}'")
    assert "Traceback" not in done.stderr


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


# A second after the node is ready its context ends, as rclpy's handler of SIGTERM ends it after it
# has woken `spin`.
ENDS_CONTEXT = """
import sys, threading
import rclpy
from skybody.ros2 import __main__ as program

def end():
    rclpy.utilities.get_default_context().handle.shutdown()

def say_ready(*_):
    threading.Timer(1.0, end).start()

program.say_ready = say_ready
sys.exit(program.main(sys.argv[1:]))
"""


@needs_ros
def test_a_node_ends_when_nothing_wakes_it_after_the_end_of_its_context(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(POLICY_MAP)
    command = [sys.executable, "-c", ENDS_CONTEXT, "trajectory_ctbr", "--map", str(path)]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=60, check=False, env=os.environ | LOCAL
    )
    assert "Traceback" not in done.stderr  # rclpy may warn
    assert done.returncode == 0
