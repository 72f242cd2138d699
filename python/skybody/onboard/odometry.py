"""Messages of ROS as packets of the program onboard. Frames are those of REP 103, as ours."""

from __future__ import annotations

from typing import Any

import numpy as np

from skybody.ros.commands import quaternion, vector

from . import packets
from .packets import Command

# SkybodySignal of commands that have a message of their own (core/plugin_abi/signals.h).
CTBR = 3


def seconds(stamp: Any) -> float:
    """Seconds of a builtin_interfaces/Time."""
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def rotated(rotation: Any, body: Any) -> Any:
    """A vector (3,) of the body's axes in the world's, by a unit quaternion w x y z."""
    w, xyz = rotation[0], np.asarray(rotation[1:])
    twice = 2.0 * np.cross(xyz, body)
    return body + w * twice + np.cross(xyz, twice)


def state_of(message: Any, sequence: int) -> bytes:
    """nav_msgs/Odometry: pose in W, twist in the axes of the body (child_frame_id)."""
    pose, twist = message.pose.pose, message.twist.twist
    rotation = np.array(quaternion(pose.orientation))
    return packets.state(
        sequence,
        seconds(message.header.stamp),
        vector(pose.position),
        rotation,
        rotated(rotation, np.array(vector(twist.linear))),
        vector(twist.angular),
    )


def imu_of(message: Any, sequence: int) -> bytes:
    """sensor_msgs/Imu: specific force and angular velocity in the axes of the body."""
    force, rate = vector(message.linear_acceleration), vector(message.angular_velocity)
    return packets.imu(sequence, seconds(message.header.stamp), force, rate)


def fill_array(message: Any, answer: Command) -> None:
    """std_msgs/Float64MultiArray: the command in physical units."""
    message.data = [float(value) for value in answer.command]


def fill_rate_thrust(message: Any, answer: Command) -> None:
    """mav_msgs/RateThrust: thrust along z of the body [N], rates in B [rad/s].

    Raises:
        ValueError: the command is no ctbr.
    """
    if answer.signal != CTBR:
        raise ValueError("mav_msgs/msg/RateThrust carries ctbr alone: take Float64MultiArray")
    thrust, roll, pitch, yaw = map(float, answer.command)
    message.thrust.x, message.thrust.y, message.thrust.z = 0.0, 0.0, thrust
    rates = message.angular_rates
    rates.x, rates.y, rates.z = roll, pitch, yaw


FILLS = {
    "std_msgs/msg/Float64MultiArray": fill_array,
    "mav_msgs/msg/RateThrust": fill_rate_thrust,
}
