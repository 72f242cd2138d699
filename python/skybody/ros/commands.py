"""Messages as commands of a simulation: the rows of the table `to`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .frames import Reals, flipped, yaw_of

Read = Callable[[Any], Reals]


@dataclass(frozen=True)
class Command:
    """A command of the simulation."""

    control: str | None  # control mode of skybody.Simulation; None: the action of the scenario
    meaning: str
    readers: dict[str, Read]  # by message type


def array(message: Any) -> Reals:
    """The numbers of a list."""
    return np.asarray(message.data, np.float64)


def vector(of: Any) -> list[float]:
    """x, y, z."""
    return [of.x, of.y, of.z]


def quaternion(of: Any) -> list[float]:
    """w x y z."""
    return [of.w, of.x, of.y, of.z]


def actuators(message: Any) -> Reals:
    """mav_msgs/Actuators: rotor speeds [rad/s]."""
    return np.asarray(message.angular_velocities, np.float64)


def rate_thrust(message: Any) -> Reals:
    """mav_msgs/RateThrust: thrust along z of the body [N], rates in B [rad/s]."""
    return np.array([message.thrust.z, *vector(message.angular_rates)])


def attitude_thrust(message: Any) -> Reals:
    """mav_msgs/AttitudeThrust: thrust along z of the body [N], attitude."""
    return np.array([message.thrust.z, *quaternion(message.attitude)])


def pose(message: Any) -> Reals:
    """geometry_msgs/PoseStamped: position in W [m] and heading [rad]."""
    return np.array([*vector(message.pose.position), yaw_of(quaternion(message.pose.orientation))])


def wrench(message: Any) -> Reals:
    """geometry_msgs/WrenchStamped: force [N] and moment [N m] in W."""
    return np.array([*vector(message.wrench.force), *vector(message.wrench.torque)])


def twist(message: Any) -> Reals:
    """geometry_msgs/TwistStamped: velocity in W [m/s] and yaw rate [rad/s]."""
    return np.array([*vector(message.twist.linear), message.twist.angular.z])


def px4_motors(message: Any) -> Reals:
    """px4_msgs/ActuatorMotors: control 0 to 1 of each motor; NaN: stopped."""
    return np.nan_to_num(np.asarray(message.control, np.float64), nan=0.0)


def px4_trajectory(message: Any) -> Reals:
    """px4_msgs/TrajectorySetpoint: position NED [m] and yaw from north, clockwise [rad]."""
    return np.array([*flipped(message.position), -message.yaw])


def px4_rates(message: Any) -> Reals:
    """px4_msgs/VehicleRatesSetpoint: rates in FRD [rad/s]; thrust_body as shares, -z is up.

    The share is of the robot's largest thrust; the bridge multiplies it.
    """
    rates = flipped([message.roll, message.pitch, message.yaw])
    return np.array([-message.thrust_body[2], *rates])


_ARRAY = "std_msgs/msg/Float32MultiArray"

COMMANDS: dict[str, Command] = {
    "action": Command(None, "the policy's action in [-1, 1]", {_ARRAY: array}),
    "rotor_speed": Command(
        "rotor_speed",
        "speed of each rotor [rad/s]",
        {_ARRAY: array, "mav_msgs/msg/Actuators": actuators},
    ),
    "throttle": Command(
        "throttle",
        "share of each rotor's own largest speed",
        {_ARRAY: array, "px4_msgs/msg/ActuatorMotors": px4_motors},
    ),
    "ctbr": Command(
        "ctbr",
        "thrust [N], rates in B [rad/s]",
        {
            _ARRAY: array,
            "mav_msgs/msg/RateThrust": rate_thrust,
            "px4_msgs/msg/VehicleRatesSetpoint": px4_rates,
        },
    ),
    "attitude": Command(
        "attitude",
        "thrust [N], attitude",
        {_ARRAY: array, "mav_msgs/msg/AttitudeThrust": attitude_thrust},
    ),
    "wrench": Command(
        "wrench",
        "force [N], moment [N m] in W",
        {_ARRAY: array, "geometry_msgs/msg/WrenchStamped": wrench},
    ),
    "velocity": Command(
        "velocity_tracking",
        "velocity in W [m/s], yaw rate [rad/s]",
        {_ARRAY: array, "geometry_msgs/msg/TwistStamped": twist},
    ),
    "position": Command(
        "position",
        "position in W [m], heading [rad]",
        {
            _ARRAY: array,
            "geometry_msgs/msg/PoseStamped": pose,
            "px4_msgs/msg/TrajectorySetpoint": px4_trajectory,
        },
    ),
}
SHARES = {px4_rates}  # readers whose first number is a share of the largest thrust
