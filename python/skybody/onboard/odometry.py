"""Messages of ROS as packets of the program onboard. Frames are those of REP 103, as ours."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import packets
from .packets import Command

# SkybodySignal of commands that have a message of their own (core/plugin_abi/signals.h).
CTBR = 3


def seconds(stamp: Any) -> float:
    """Seconds of a builtin_interfaces/Time."""
    return float(stamp.sec) + 1e-9 * float(stamp.nanosec)


def rotated(quaternion: Any, vector: Any) -> Any:
    """A vector (3,) of the body's axes in the world's, by a unit quaternion w x y z."""
    w, xyz = quaternion[0], np.asarray(quaternion[1:])
    twice = 2.0 * np.cross(xyz, vector)
    return vector + w * twice + np.cross(xyz, twice)


def state_of(message: Any, sequence: int) -> bytes:
    """nav_msgs/Odometry: pose in W, twist in the axes of the body (child_frame_id)."""
    pose, twist = message.pose.pose, message.twist.twist
    q = pose.orientation
    rotation = np.array([q.w, q.x, q.y, q.z])
    p, v, w = pose.position, twist.linear, twist.angular
    return packets.state(
        sequence,
        seconds(message.header.stamp),
        [p.x, p.y, p.z],
        rotation,
        rotated(rotation, np.array([v.x, v.y, v.z])),
        [w.x, w.y, w.z],
    )


def imu_of(message: Any, sequence: int) -> bytes:
    """sensor_msgs/Imu: specific force and angular velocity in the axes of the body."""
    f, w = message.linear_acceleration, message.angular_velocity
    stamp = seconds(message.header.stamp)
    return packets.imu(sequence, stamp, [f.x, f.y, f.z], [w.x, w.y, w.z])


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
