"""Messages with a pose: the columns of a robot whose map names a topic alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from skybody import InputError
from skybody.arguments import allowed_words

from .channels import Channels
from .map_file import Attitude, Columns, Robot

# Fields of position, quaternion, velocity (B) and angular velocity (B) in messages of known types.
KNOWN: Mapping[str, tuple[str, str, str, str]] = {
    "foxglove.Odometry": (
        "pose.position", "pose.orientation", "linear_velocity", "angular_velocity",
    ),
    "nav_msgs/msg/Odometry": (
        "pose.pose.position", "pose.pose.orientation", "twist.twist.linear", "twist.twist.angular",
    ),
    "foxglove.PoseInFrame": ("pose.position", "pose.orientation", "", ""),
    "geometry_msgs/msg/PoseStamped": ("pose.position", "pose.orientation", "", ""),
}  # fmt: skip


def with_columns(robot: Robot, channels: Channels, place: str) -> Robot:
    """The robot with the columns of its topic.

    Args:
        robot: of the map.
        channels: the log.
        place: file and key of the robot, for messages.

    Raises:
        InputError: there is no such topic, or its messages have no pose that is known.
    """
    topic = robot.topic
    if not topic:
        return robot
    if topic not in channels.kinds:
        hint = allowed_words(topic, sorted(channels.kinds))
        raise InputError(f"{channels.path}: no topic `{topic}` for {place}{hint}")
    kind = channels.kinds[topic]
    if kind not in KNOWN:
        raise InputError(
            f"{place}.topic: messages of `{topic}` are of type {kind}; allowed: "
            f"{', '.join(KNOWN)}; of others name the columns"
        )
    position, turn, velocity, rate = KNOWN[kind]

    def columns(field: str, letters: str, unit: str, axes: str = "") -> Columns | None:
        names = tuple(f"{topic}.{field}.{letter}" for letter in letters)
        return Columns(f"{place}.topic", names, 1.0, unit, axes) if field else None

    attitude = columns(turn, "wxyz", "")
    assert attitude is not None
    return replace(
        robot,
        position=columns(position, "xyz", "m"),
        attitude=Attitude(attitude, (0, 1, 2, 3)),
        velocity=columns(velocity, "xyz", "m/s", "body"),
        angular_velocity=robot.angular_velocity or columns(rate, "xyz", "rad/s", "body"),
    )
