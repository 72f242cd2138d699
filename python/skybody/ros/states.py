"""Parts of a simulation as messages: the rows of the table `from`.

Each filler writes into a message that is there, of any class with the fields of its type, so that
the same code serves rclpy, rospy and tests.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skybody import BodyState, Simulation
from skybody.camera import Camera
from skybody.exports.frames import frame_of, to_body
from skybody.exports.lens import NOT_TURNED, camera_matrix, projection_matrix

Fill = Callable[[Any, Simulation, Any], None]  # message, simulation, row of the map


@dataclass(frozen=True)
class State:
    """A part of the simulation."""

    types: dict[str, Fill]
    frame: str  # header.frame_id
    meaning: str


def body_of(simulation: Simulation, row: Any) -> BodyState:
    """The body of a row: named, or the base of its robot."""
    if row.body:
        names = simulation.body_names
        if row.body not in names:
            raise ValueError(f"no body `{row.body}`: there are {', '.join(names)}")
        return simulation.bodies[names.index(row.body)]
    return simulation.base(row.robot)


def base_name(simulation: Simulation, robot: str) -> str:
    """ROBOT.LINK of a robot's base."""
    name = robot or simulation.compiled.robots[0]
    return next(body for body in simulation.body_names if body.startswith(f"{name}."))


def sensor(simulation: Simulation, row: Any, channel: str) -> Any:
    """A channel of the sensor that the row names as NAME or NAME.CHANNEL."""
    name = row.part.split(".")[0]
    return simulation.state(f"sensors.{name}.{channel}")


def set_vector(to: Any, values: Any) -> None:
    """x, y, z of a Vector3 or Point."""
    to.x, to.y, to.z = (float(v) for v in values)


def set_quaternion(to: Any, values: Any) -> None:
    """x, y, z, w from w x y z."""
    to.w, to.x, to.y, to.z = (float(v) for v in values)


def set_pose(to: Any, body: BodyState) -> None:
    """A Pose of a body in W."""
    set_vector(to.position, body.position)
    set_quaternion(to.orientation, body.rotation)


def set_stamp(stamp: Any, time: float) -> None:
    """Whole seconds and nanoseconds of a time [s], under the names of ROS 2 or of ROS 1."""
    names = ("sec", "nanosec") if hasattr(stamp, "nanosec") else ("secs", "nsecs")
    for name, value in zip(names, divmod(round(time * 1e9), 10**9), strict=True):
        setattr(stamp, name, value)


# --- motion -------------------------------------------------------------------------------------


def odometry(message: Any, simulation: Simulation, row: Any) -> None:
    """Pose in W; twist in the axes of the body, as REP 105 and nav_msgs say."""
    body = body_of(simulation, row)
    message.child_frame_id = frame_of(row.body or base_name(simulation, row.robot))
    set_pose(message.pose.pose, body)
    set_vector(message.twist.twist.linear, to_body(body.rotation, body.velocity))
    set_vector(message.twist.twist.angular, body.angular_velocity)


def pose_stamped(message: Any, simulation: Simulation, row: Any) -> None:
    """Pose in W."""
    set_pose(message.pose, body_of(simulation, row))


def twist_stamped(message: Any, simulation: Simulation, row: Any) -> None:
    """Velocity in W, angular velocity in the axes of the body."""
    body = body_of(simulation, row)
    set_vector(message.twist.linear, body.velocity)
    set_vector(message.twist.angular, body.angular_velocity)


def goal(message: Any, simulation: Simulation, row: Any) -> None:
    """The task's first goal in W."""
    if len(simulation.goals) == 0:
        raise ValueError("the task has no goal")
    x, y, z, yaw = simulation.goals[:4]
    set_vector(message.pose.position, (x, y, z))
    set_quaternion(message.pose.orientation, (np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)))


def rotor_speeds(message: Any, simulation: Simulation, row: Any) -> None:
    """Speeds of all rotors [rad/s], in the world's order, as joints by their names."""
    message.name = [rotor.name for rotor in simulation.compiled.rotors]
    message.velocity = simulation.rotor_speeds.tolist()


# --- rows of the learner ------------------------------------------------------------------------


def observation(message: Any, simulation: Simulation, row: Any) -> None:
    """The policy's row, exactly."""
    message.data = simulation.observation.tolist()


def info(message: Any, simulation: Simulation, row: Any) -> None:
    """Infos, in the order of CompiledScenario.info_channels."""
    message.data = simulation.info.tolist()


def reward(message: Any, simulation: Simulation, row: Any) -> None:
    """The reward of the last step."""
    message.data = float(simulation.reward)


def status(message: Any, simulation: Simulation, row: Any) -> None:
    """The end of the episode as bits: 1 terminated, 2 truncated, 4 fault (docs/flight-log.md)."""
    message.data = int(simulation.status) & 7


# --- sensors ------------------------------------------------------------------------------------


def imu(message: Any, simulation: Simulation, row: Any) -> None:
    """Specific force and rates in the sensor's axes; no orientation, in the way of REP 145."""
    set_vector(message.linear_acceleration, sensor(simulation, row, "specific_force"))
    set_vector(message.angular_velocity, sensor(simulation, row, "angular_rate"))
    message.orientation_covariance[0] = -1.0


def battery(message: Any, simulation: Simulation, row: Any) -> None:
    """Voltage [V], current [A] (negative: it discharges), charge as a share."""
    message.voltage = float(sensor(simulation, row, "voltage"))
    message.current = -float(sensor(simulation, row, "current"))
    message.percentage = float(sensor(simulation, row, "charge"))
    message.present = True


def numbers(message: Any, simulation: Simulation, row: Any) -> None:
    """A sensor's channel as a list of numbers."""
    message.data = np.ravel(simulation.state(f"sensors.{row.part}")).tolist()


ENCODINGS = {  # of images, by type and channels
    ("float32", 1): "32FC1",
    ("uint8", 3): "rgb8",
    ("uint8", 1): "mono8",
    ("uint16", 1): "mono16",
    ("float32", 2): "32FC2",
    ("float32", 3): "32FC3",
}


def image(message: Any, simulation: Simulation, row: Any) -> None:
    """An image that the scenario observes."""
    pixels = simulation.image(row.part)
    pixels = pixels if pixels.ndim == 3 else pixels[..., None]
    message.height, message.width, channels = pixels.shape
    kind = pixels.dtype.name, channels
    if kind not in ENCODINGS:
        raise ValueError(f"ROS has no encoding of {channels} channels of {kind[0]}")
    message.encoding = ENCODINGS[kind]
    message.step = message.width * channels * pixels.itemsize
    message.is_bigendian = 0
    message.data = pixels.tobytes()


MODELS = {"pinhole": "plumb_bob", "fisheye": "equidistant"}  # names of lenses in ROS


def camera_info(message: Any, simulation: Simulation, row: Any) -> None:
    """Size, intrinsics and distortion of the camera that the row names."""
    camera = Camera(simulation.compiled, row.part.split(".")[0])
    message.width, message.height = camera.width, camera.height
    if camera.projection not in MODELS:
        raise ValueError(f"ROS has no name for the lens of a {camera.projection}")
    message.distortion_model = MODELS[camera.projection]
    k = [*camera.distortion, 0.0, 0.0, 0.0, 0.0, 0.0]
    focal, x, y = camera.focal, 0.5 * camera.width, 0.5 * camera.height
    matrices = {
        "d": k[: 5 if camera.projection == "pinhole" else 4],
        "k": camera_matrix(focal, x, y),
        "r": NOT_TURNED,
        "p": projection_matrix(focal, x, y),
    }
    for name, matrix in matrices.items():  # ROS 1 has them as D, K, R, P
        setattr(message, name if hasattr(message, name) else name.upper(), matrix)


def point_cloud(message: Any, simulation: Simulation, row: Any) -> None:
    """The points of a lidar, rings x columns, in the axes that its `axes` gives."""
    points = simulation.image(row.part)
    field = importlib.import_module("sensor_msgs.msg").PointField
    message.height, message.width = points.shape[:2]
    message.fields = [
        field(name=name, offset=4 * k, datatype=field.FLOAT32, count=1)
        for k, name in enumerate("xyz")
    ]
    message.is_bigendian, message.is_dense = False, True
    message.point_step, message.row_step = 12, 12 * message.width
    message.data = points.tobytes()


def transforms(message: Any, simulation: Simulation, row: Any) -> None:
    """World to each body."""
    transform = importlib.import_module("geometry_msgs.msg").TransformStamped
    message.transforms = []
    for name, body in zip(simulation.body_names, simulation.bodies, strict=True):
        one = transform()
        one.header.frame_id, one.child_frame_id = "world", frame_of(name)
        set_stamp(one.header.stamp, simulation.time)
        set_vector(one.transform.translation, body.position)
        set_quaternion(one.transform.rotation, body.rotation)
        message.transforms.append(one)


_ARRAY = "std_msgs/msg/Float32MultiArray"

STATES: dict[str, State] = {
    "odometry": State({"nav_msgs/msg/Odometry": odometry}, "world", "pose and twist of a body"),
    "pose": State({"geometry_msgs/msg/PoseStamped": pose_stamped}, "world", "pose of a body"),
    "twist": State({"geometry_msgs/msg/TwistStamped": twist_stamped}, "world", "twist of a body"),
    "goal": State({"geometry_msgs/msg/PoseStamped": goal}, "world", "the task's first goal"),
    "tf": State({"tf2_msgs/msg/TFMessage": transforms}, "", "world to each body"),
    "rotor_speeds": State({"sensor_msgs/msg/JointState": rotor_speeds}, "", "all rotors"),
    "observation": State({_ARRAY: observation}, "", "the policy's row"),
    "info": State({_ARRAY: info}, "", "the task's infos"),
    "reward": State({"std_msgs/msg/Float32": reward}, "", "of the last step"),
    "status": State({"std_msgs/msg/UInt8": status}, "", "1 terminated, 2 truncated, 4 fault"),
}
SENSORS: dict[str, Fill] = {  # by type: parts that are sensors, channels or images
    "sensor_msgs/msg/Imu": imu,
    "sensor_msgs/msg/BatteryState": battery,
    "sensor_msgs/msg/Image": image,
    "sensor_msgs/msg/CameraInfo": camera_info,
    "sensor_msgs/msg/PointCloud2": point_cloud,
    _ARRAY: numbers,
}


def filler(row: Any) -> Fill | None:
    """The function that fills a row's message; None: there is none for this type."""
    if row.part in STATES:
        return STATES[row.part].types.get(row.type)
    return SENSORS.get(row.type)
