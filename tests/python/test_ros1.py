"""`skybody ros1` as real nodes under a master, where there is rospy: ./dev ros."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from skybody import Simulation

ROOT = Path(__file__).resolve().parents[2]
NUMBERS = "std_msgs/msg/Float32MultiArray"
POLICY_MAP = (ROOT / "examples/ros2_policy.yaml").read_text()
pytestmark = pytest.mark.skipif(
    subprocess.run([sys.executable, "-c", "import rospy"], capture_output=True, check=False)
    .returncode != 0,
    reason="there is no rospy in this Python: ./dev ros runs these tests",
)  # fmt: skip


def free_port() -> int:
    """A port on the loopback interface that nobody uses."""
    with socket.socket() as made:
        made.bind(("127.0.0.1", 0))
        return int(made.getsockname()[1])


def wait_until(holds: Callable[[], bool]) -> None:
    """Waits for a condition, for at most 20 s."""
    until = time.monotonic() + 20.0
    while not holds():
        assert time.monotonic() < until
        time.sleep(0.02)


@pytest.fixture(scope="module", autouse=True)
def master(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A master on the loopback interface, and this process as a node."""
    port, folder = free_port(), str(tmp_path_factory.mktemp("ros"))
    uri = f"http://127.0.0.1:{port}"
    os.environ.update(ROS_IP="127.0.0.1", ROS_MASTER_URI=uri, ROS_HOME=folder, ROS_LOG_DIR=folder)
    with subprocess.Popen(["rosmaster", "--core", "-p", str(port)]) as process:
        import rosgraph
        import rospy

        wait_until(rosgraph.is_master_online)
        rospy.init_node("test", disable_signals=True)
        yield
        rospy.signal_shutdown("the tests end")
        process.terminate()


@pytest.fixture
def node(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """`skybody ros1` with the arguments and the map of the test; its first line."""
    arguments, text = request.param
    path = tmp_path / "map.yaml"
    path.write_text(text)
    command = [sys.executable, "-m", "skybody.ros1", *arguments, "--map", str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        yield process.stdout.readline()
        process.terminate()


def call(name: str, kind: str, **fields: Any) -> Any:
    """Calls a service of the node; `kind`: module and class."""
    import rospy

    module, _, of = kind.rpartition(".")
    rospy.wait_for_service(f"/skybody/{name}", 20.0)
    proxy = rospy.ServiceProxy(f"/skybody/{name}", getattr(__import__(module, fromlist=[of]), of))
    return proxy(**fields)


@pytest.mark.parametrize("node", [(["trajectory_ctbr", "--seed", "5"], POLICY_MAP)], indirect=True)
def test_a_policy_in_a_process_of_its_own_flies_the_same_bits(node: str) -> None:
    import rospy
    from skybody.train.policy_file import read_policy, shipped_policy
    from std_msgs.msg import Float32MultiArray

    assert "trajectory_ctbr, in lockstep" in node
    steps, seen = 200, []
    policy = read_policy(shipped_policy("trajectory_ctbr"))
    actions = rospy.Publisher("/quad/action", Float32MultiArray, queue_size=10)

    def act(message: Any) -> None:
        seen.append(np.array(message.data, np.float32))
        action = policy(seen[-1][None])[0].astype(np.float32)
        actions.publish(Float32MultiArray(data=action.tolist()))

    watch = rospy.Subscriber("/quad/observation", Float32MultiArray, act, tcp_nodelay=True)
    wait_until(lambda: actions.get_num_connections() > 0 and watch.get_num_connections() > 0)
    assert call("states", "std_srvs.srv.Trigger").success
    wait_until(lambda: len(seen) > steps)
    watch.unregister()

    alone = Simulation("trajectory_ctbr", seed=5)
    alone.reset()
    for row in seen[: steps + 1]:
        np.testing.assert_array_equal(alone.observation, row)
        alone.step(policy(row[None])[0].astype(np.float32))


SENSORS_MAP = f"""
publish:
  - {{topic: /depth, type: sensor_msgs/Image, from: front.depth}}
  - {{topic: /info, type: sensor_msgs/CameraInfo, from: front}}
  - {{topic: /odometry, type: nav_msgs/Odometry, from: odometry}}
  - {{topic: /tf, type: tf2_msgs/TFMessage, from: tf}}
command: [{{topic: /action, type: {NUMBERS}, to: action}}]
"""


@pytest.mark.parametrize("node", [(["hover_camera"], SENSORS_MAP)], indirect=True)
def test_messages_are_seen_by_subscribers_and_services_answer(node: str) -> None:
    import rospy
    from nav_msgs.msg import Odometry
    from rosgraph_msgs.msg import Clock
    from sensor_msgs.msg import CameraInfo, Image
    from tf2_msgs.msg import TFMessage

    seen: dict[str, Any] = {}
    topics = {
        "/depth": Image, "/info": CameraInfo, "/odometry": Odometry, "/tf": TFMessage,
        "/clock": Clock,
    }  # fmt: skip

    def keep(message: Any, name: str) -> None:
        seen[name] = message

    watches = [rospy.Subscriber(name, kind, keep, name) for name, kind in topics.items()]
    wait_until(lambda: all(watch.get_num_connections() > 0 for watch in watches))
    assert not call("restore", "std_srvs.srv.Trigger").success  # nothing was saved
    assert call("reset", "std_srvs.srv.Trigger").message == "episode 2"
    assert call("pause", "std_srvs.srv.SetBool", data=True).message == "paused"
    wait_until(lambda: len(seen) == len(topics))

    alone = Simulation("hover_camera")
    alone.reset()
    alone.reset()
    pixels = np.frombuffer(seen["/depth"].data, np.float32).reshape(64, 64)
    np.testing.assert_array_equal(pixels, alone.image("front.depth"))
    assert seen["/info"].K[0] > 0.0
    assert seen["/odometry"].pose.pose.position.z == alone.bodies[0].position[2]
    assert seen["/tf"].transforms[0].header.frame_id == "world"


PARAMETER_MAP = f"command: [{{topic: /action, type: {NUMBERS}, to: action}}]"
MASS = "robots.quad.links.base_link.mass"


@pytest.mark.parametrize("node", [(["hover"], PARAMETER_MAP)], indirect=True)
def test_a_value_is_set_or_left_out_of_the_answer(node: str) -> None:
    from dynamic_reconfigure.msg import Config, DoubleParameter

    rows = [DoubleParameter(MASS, 1.7), DoubleParameter(MASS, -1.0), DoubleParameter("no", 1.0)]
    answer = call(
        "set_parameters", "dynamic_reconfigure.srv.Reconfigure", config=Config(doubles=rows)
    )
    assert [(one.name, one.value) for one in answer.config.doubles] == [(MASS, 1.7)]


CLOCK_MAP = "publish: [{topic: /pose, type: geometry_msgs/PoseStamped, from: pose}]"


@pytest.mark.parametrize("node", [(["hover", "--real-time", "1"], CLOCK_MAP)], indirect=True)
def test_time_goes_by_itself_with_a_factor(node: str) -> None:
    import rospy
    from geometry_msgs.msg import PoseStamped

    assert "1 x real time" in node
    first, second = (rospy.wait_for_message("/pose", PoseStamped, 20.0) for _ in range(2))
    assert second.header.stamp > first.header.stamp


def test_without_a_master_there_is_one_error(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(CLOCK_MAP)
    command = [sys.executable, "-m", "skybody.ros1", "hover", "--map", str(path)]
    uri = f"http://127.0.0.1:{free_port()}"
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=60, check=False,
        env=os.environ | {"ROS_MASTER_URI": uri},
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.strip() == (
        f"error: no ROS master answers at {uri}: start `roscore`, or name another one in "
        "ROS_MASTER_URI"
    )


@pytest.mark.parametrize(
    ("topic", "name", "message"),
    [
        ("/a b", "skybody", "topic: is `/a b`; allowed: letters, digits, _ and /"),
        ("/a", "a b", "--name: is `a b`; allowed: letters, digits and _, a letter first"),
    ],
)
def test_a_name_that_the_master_would_refuse_is_one_error(
    topic: str, name: str, message: str, tmp_path: Path
) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(f"publish: [{{topic: {topic}, type: geometry_msgs/PoseStamped, from: pose}}]")
    command = [sys.executable, "-m", "skybody.ros1", "hover", "--map", str(path), "--name", name]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (2, f"error: {message}\n")


def test_a_master_forgets_a_node_that_is_terminated(tmp_path: Path) -> None:
    import rosgraph

    def is_known() -> bool:
        nodes = [name for rows in rosgraph.Master("/test").getSystemState() for row in rows
                 for name in row[1]]  # fmt: skip
        return "/brief" in nodes

    path = tmp_path / "map.yaml"
    path.write_text(CLOCK_MAP)
    command = [sys.executable, "-m", "skybody.ros1", "hover", "--map", str(path), "--name", "brief"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        assert is_known()
        process.terminate()
        assert process.wait(timeout=20) == 0
    assert not is_known()
