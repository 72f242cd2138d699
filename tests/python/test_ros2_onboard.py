"""`skybody onboard --ros2`: messages as packets; a real node where there is rclpy (./dev ros)."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace as Message
from typing import Any

import numpy as np
import pytest
from skybody import CompiledScenario, Simulation
from skybody._native import mission_bytes
from skybody.onboard import packets
from skybody.onboard.lockstep import Vehicle, fly
from skybody.onboard.odometry import CTBR, fill_array, fill_rate_thrust, imu_of, rotated, state_of
from skybody.onboard.program import find_program, running
from skybody.program import module_command
from skybody.train.policy_file import shipped_policy

has_rclpy = (
    subprocess.run(
        [sys.executable, "-c", "import rclpy"], capture_output=True, check=False
    ).returncode
    == 0
)


def stamp(seconds: float) -> Message:
    whole = int(seconds)
    return Message(sec=whole, nanosec=round((seconds - whole) * 1e9))


def xyz(values: object) -> Message:
    x, y, z = np.asarray(values, float)
    return Message(x=x, y=y, z=z)


def test_the_twist_of_odometry_is_turned_into_the_world() -> None:
    half = np.sqrt(0.5)
    pose = Message(
        position=xyz([1, 2, 3]), orientation=Message(w=half, x=0.0, y=0.0, z=half)
    )  # looks to y
    twist = Message(linear=xyz([4, 0, 0]), angular=xyz([0.1, 0.2, 0.3]))
    message = Message(
        header=Message(stamp=stamp(2.5)), pose=Message(pose=pose), twist=Message(twist=twist)
    )
    packet = state_of(message, 7)
    values = np.frombuffer(packet, "<f8", 13, 32)
    expected = [1, 2, 3, half, 0, 0, half, 0, 4, 0, 0.1, 0.2, 0.3]
    np.testing.assert_allclose(values, expected, atol=1e-15)  # round-off of a rotation
    assert np.frombuffer(packet, "<f8", 1, 16)[0] == 2.5


def test_an_imu_keeps_its_axes() -> None:
    message = Message(
        header=Message(stamp=stamp(1.0)),
        linear_acceleration=xyz([1, 2, 9.8]),
        angular_velocity=xyz([0.1, 0.2, 0.3]),
    )
    values = np.frombuffer(imu_of(message, 0), "<f8", 6, 24)
    assert values.tolist() == [1, 2, 9.8, 0.1, 0.2, 0.3]


def test_a_ctbr_command_is_a_rate_thrust_and_others_are_refused() -> None:
    command = np.array([9.8, 0.1, 0.2, 0.3])
    answer = packets.Command(0, 0.0, packets.POLICY, (), CTBR, np.zeros(4, np.float32), command)
    message = Message(thrust=Message(), angular_rates=Message())
    fill_rate_thrust(message, answer)
    assert (message.thrust.z, message.angular_rates.y) == (9.8, 0.2)
    fill_array(message, answer)
    assert message.data == command.tolist()
    other = packets.Command(0, 0.0, packets.POLICY, (), 0, answer.action, command)
    with pytest.raises(ValueError, match="carries ctbr alone"):
        fill_rate_thrust(message, other)


@pytest.mark.skipif(not has_rclpy, reason="there is no rclpy in this Python: ./dev ros has it")
def test_ros2_node_flies_the_commands_of_the_program(tmp_path: Path) -> None:
    import rclpy
    from nav_msgs.msg import Odometry
    from std_msgs.msg import Float64MultiArray

    mission = tmp_path / "m"
    mission.write_bytes(
        mission_bytes(CompiledScenario("racing"), str(shipped_policy("racing", "racing")))
    )
    twin = Simulation("racing", overrides=["randomization=[]"], seed=1)
    twin.reset()
    with running(mission, ["--lockstep"]) as (port, _):
        expected = fly(twin, Vehicle(twin, port), steps=20)
    simulation = Simulation("racing", overrides=["randomization=[]"], seed=1)
    simulation.reset()
    os.environ.update(ROS_LOCALHOST_ONLY="1", ROS_DOMAIN_ID="37")
    environment = os.environ | {"SKYBODY_ONBOARD": " ".join(find_program())}
    command = [*module_command("skybody.onboard"), str(mission), "--lockstep"]
    with subprocess.Popen(command, env=environment) as process:
        rclpy.init()
        node = rclpy.create_node("vehicle")
        answers: list[list[float]] = []
        node.create_subscription(
            Float64MultiArray, "/command", lambda m: answers.append(list(m.data)), 10
        )
        publisher = node.create_publisher(Odometry, "/odometry", 10)
        deadline = time.monotonic() + 30.0
        while publisher.get_subscription_count() == 0 and time.monotonic() < deadline:
            rclpy.spin_once(node, timeout_sec=0.1)
        for answer in expected:
            publisher.publish(_odometry(Odometry(), simulation))
            count = len(answers)
            while len(answers) == count and time.monotonic() < deadline:
                rclpy.spin_once(node, timeout_sec=0.1)
            # The velocity is turned into the body and back: 1e-15, of which the network makes at
            # most 1e3 times as much in the range of 40 N, in float: 1e-6 of it.
            np.testing.assert_allclose(answers[-1], answer.command, atol=1e-3)
            simulation.step(answer.action)
        rclpy.try_shutdown()
        process.send_signal(signal.SIGINT)
        assert process.wait(20.0) in (0, 130)


def _odometry(message: Any, simulation: Simulation) -> Any:
    body = simulation.bodies[0]
    time_ = stamp(1.0 + simulation.time)
    message.header.stamp.sec, message.header.stamp.nanosec = time_.sec, time_.nanosec
    pose, twist = message.pose.pose, message.twist.twist
    w, x, y, z = map(float, body.rotation)
    pose.position.x, pose.position.y, pose.position.z = map(float, body.position)
    q = pose.orientation
    q.w, q.x, q.y, q.z = w, x, y, z
    velocity = rotated(np.array([w, -x, -y, -z]), body.velocity)
    twist.linear.x, twist.linear.y, twist.linear.z = map(float, velocity)
    rates = twist.angular
    rates.x, rates.y, rates.z = map(float, body.angular_velocity)
    return message
