"""Messages of ROS 2 of the rows of a flight; None for rows whose values are not finite."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from skybody.look.couplings import RADIUS
from skybody.look.flight import Array
from skybody.look.scene import ROPE, Fixed
from skybody.look.shapes import BOX, CYLINDER, MESH, SPHERE

from .frames import CAMERA, WORLD, finite, goal_quaternions, quaternion_of, to_body
from .images import FOCAL, SIZE, Picture
from .lens import NOT_TURNED, camera_matrix, projection_matrix
from .table import NANO, Block
from .world import Part, World

TYPES = get_typestore(Stores.ROS2_HUMBLE)
LINE_WIDTH = 2.0 * RADIUS  # of couplings [m]
NO_COVARIANCE = np.zeros(36)  # unknown, by ROS's convention
UNKNOWN = np.array([-1.0, 0, 0, 0, 0, 0, 0, 0, 0])  # covariance of values that are not there
NUMBERS = np.zeros(0)


def ros(kind: str, /, **fields: Any) -> Any:
    """A message of a type such as `nav_msgs/Odometry`."""
    package, _, name = kind.partition("/")
    return TYPES.types[f"{package}/msg/{name}"](**fields)


def header(nanoseconds: int, frame: str = WORLD) -> Any:
    """A time and a frame."""
    sec, nanosec = divmod(nanoseconds, NANO)
    stamp = ros("builtin_interfaces/Time", sec=sec, nanosec=nanosec)
    return ros("std_msgs/Header", stamp=stamp, frame_id=frame)


def vector(values: Sequence[float]) -> Any:
    """A vector of 3 numbers."""
    return ros("geometry_msgs/Vector3", x=values[0], y=values[1], z=values[2])


def point(values: Sequence[float]) -> Any:
    """A point of 3 numbers."""
    return ros("geometry_msgs/Point", x=values[0], y=values[1], z=values[2])


def turn(values: Sequence[float]) -> Any:
    """A quaternion w x y z."""
    return ros("geometry_msgs/Quaternion", w=values[0], x=values[1], y=values[2], z=values[3])


def pose(values: Sequence[float]) -> Any:
    """A pose of 7 numbers: position, quaternion w x y z."""
    return ros("geometry_msgs/Pose", position=point(values), orientation=turn(values[3:7]))


# --- of rows ------------------------------------------------------------------------------------


def transform(head: Any, frame: str, values: Sequence[float]) -> Any:
    """A frame in that of a header."""
    moved = ros("geometry_msgs/Transform", translation=vector(values), rotation=turn(values[3:7]))
    return ros("geometry_msgs/TransformStamped", header=head, child_frame_id=frame, transform=moved)


def transforms(block: Block, frames: Sequence[str]) -> Iterator[Any]:
    """All bodies' frames in the world."""
    bodies = block.real("bodies")
    rows = zip(block.stamps(NANO).tolist(), bodies.tolist(), finite(bodies[:, :, :7]), strict=True)
    for stamp, row, known in rows:
        head = header(stamp)
        bodies_there = zip(frames, row, known, strict=True)
        moved = [transform(head, frame, body) for frame, body, good in bodies_there if good]
        yield ros("tf2_msgs/TFMessage", transforms=moved)


def odometry(block: Block, body: int, frame: str) -> Iterator[Any]:
    """Pose in the world and velocities in the frame of a body."""
    rows = block.real("bodies")[:, body]
    velocities = to_body(rows[:, 3:7], rows[:, 7:10]).tolist()
    stamps, known = block.stamps(NANO).tolist(), finite(rows)
    for stamp, row, velocity, good in zip(stamps, rows.tolist(), velocities, known, strict=True):
        twist = ros("geometry_msgs/Twist", linear=vector(velocity), angular=vector(row[10:13]))
        made = ros(
            "nav_msgs/Odometry",
            header=header(stamp),
            child_frame_id=frame,
            pose=ros("geometry_msgs/PoseWithCovariance", pose=pose(row), covariance=NO_COVARIANCE),
            twist=ros("geometry_msgs/TwistWithCovariance", twist=twist, covariance=NO_COVARIANCE),
        )
        yield made if good else None


def goals(block: Block, goal: int) -> Iterator[Any]:
    """The poses of a goal."""
    rows = block.real("goal")[:, goal]
    values = np.concatenate([rows[:, :3], goal_quaternions(rows[:, 3])], axis=1)
    stamps = block.stamps(NANO).tolist()
    for stamp, row, good in zip(stamps, values.tolist(), finite(values), strict=True):
        made = ros("geometry_msgs/PoseStamped", header=header(stamp), pose=pose(row))
        yield made if good else None


def speeds(block: Block, dataset: str, columns: Sequence[int], names: list[str]) -> Iterator[Any]:
    """Speeds of rotors as velocities of joints [rad/s]."""
    rows = np.ascontiguousarray(block.real(dataset)[:, columns])
    for stamp, row in zip(block.stamps(NANO).tolist(), rows, strict=True):
        yield ros(
            "sensor_msgs/JointState",
            header=header(stamp),
            name=names,
            position=NUMBERS,
            velocity=row,
            effort=NUMBERS,
        )


def imu(block: Block, force: Sequence[int], rate: Sequence[int], frame: str) -> Iterator[Any]:
    """Specific force and angular rate of a sensor, whose orientation is not known."""
    rows = block.real("sensors")
    stamps = block.stamps(NANO).tolist()
    for stamp, forces, rates in zip(
        stamps, rows[:, force].tolist(), rows[:, rate].tolist(), strict=True
    ):
        yield ros(
            "sensor_msgs/Imu",
            header=header(stamp, frame),
            orientation=turn([1.0, 0.0, 0.0, 0.0]),
            orientation_covariance=UNKNOWN,
            angular_velocity=vector(rates),
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=vector(forces),
            linear_acceleration_covariance=np.zeros(9),
        )


def numbers(block: Block, dataset: str, names: Sequence[str]) -> Iterator[Any]:
    """The values of a dataset; the label of their dimension has their names."""
    size = len(names)
    label = ros("std_msgs/MultiArrayDimension", label=",".join(names), size=size, stride=size)
    layout = ros("std_msgs/MultiArrayLayout", dim=[label], data_offset=0)
    for row in block.real(dataset).reshape(len(block.time), size):
        yield ros("std_msgs/Float64MultiArray", layout=layout, data=row)


def log(stamp: int, text: str) -> Any:
    """An event."""
    return ros(
        "rcl_interfaces/Log", stamp=header(stamp).stamp, level=20, name="skybody", msg=text,
        file="", function="", line=0,
    )  # fmt: skip


# --- shapes -------------------------------------------------------------------------------------

MARKER = TYPES.types["visualization_msgs/msg/Marker"]
KINDS = {BOX: 1, SPHERE: 2, CYLINDER: 3, MESH: 11}  # by the constants of Marker
LINE_STRIP = 4


def color_of(rgb: Sequence[float]) -> Any:
    """A colour that hides all behind it."""
    return ros("std_msgs/ColorRGBA", r=rgb[0], g=rgb[1], b=rgb[2], a=1.0)


def marker(head: Any, space: str, number: int, **fields: Any) -> Any:
    """A marker that stays, with some fields other than empty."""
    nothing = ros("builtin_interfaces/Duration", sec=0, nanosec=0)
    no_image = ros(
        "sensor_msgs/CompressedImage", header=head, format="", data=np.zeros(0, np.uint8)
    )
    empty = {
        "pose": pose([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        "scale": vector([1.0, 1.0, 1.0]),
        "points": [],
        "colors": [],
        "texture_resource": "",
        "texture": no_image,
        "uv_coordinates": [],
        "text": "",
        "mesh_resource": "",
        "mesh_file": ros("visualization_msgs/MeshFile", filename="", data=np.zeros(0, np.uint8)),
        "mesh_use_embedded_materials": False,
    }
    named = {"header": head, "ns": space, "id": number, "action": 0, "lifetime": nothing}
    return MARKER(**(empty | named | {"frame_locked": True} | fields))


def markers(parts: Sequence[Part], stamp: int) -> Any:
    """The shapes of bodies, which move with their frames, and of obstacles."""
    made = [
        shape_marker(header(stamp, part.frame), part.name, number, shape)
        for part in parts
        for number, shape in enumerate(part.shapes)
    ]
    return ros("visualization_msgs/MarkerArray", markers=made)


def shape_marker(head: Any, space: str, number: int, shape: Fixed) -> Any:
    """A shape."""
    place = pose([*shape.position.tolist(), *quaternion_of(shape.axes).tolist()])
    corners = [] if shape.corners is None else shape.corners.reshape(-1, 3).astype(float).tolist()
    scale = vector([1.0, 1.0, 1.0] if corners else [2.0 * half for half in shape.half])
    return marker(
        head, space, number, type=KINDS[shape.kind], pose=place, scale=scale,
        color=color_of(shape.color), points=[point(corner) for corner in corners],
    )  # fmt: skip


def couplings(block: Block, world: World) -> Iterator[Any]:
    """The lines of couplings in rows where they are due."""
    for stamp, lines in zip(block.stamps(NANO).tolist(), world.lines(block), strict=True):
        yield None if lines is None else line_markers(stamp, lines)


def line_markers(stamp: int, lines: dict[str, list[Array]]) -> Any:
    """The couplings."""
    made = [
        marker(
            header(stamp), name, 0, type=LINE_STRIP, scale=vector([LINE_WIDTH, 0.0, 0.0]),
            color=color_of(ROPE), points=[point(place.tolist()) for place in places],
        )
        for name, places in lines.items()
    ]  # fmt: skip
    return ros("visualization_msgs/MarkerArray", markers=made)


# --- images -------------------------------------------------------------------------------------


def image(picture: Picture, stamp: int) -> Any:
    """A picture."""
    data = np.frombuffer(picture.jpeg, np.uint8)
    return ros(
        "sensor_msgs/CompressedImage", header=header(stamp, CAMERA), format="jpeg", data=data
    )


def lens(stamp: int) -> Any:
    """The lens of pictures: no distortion."""
    x, y = 0.5 * SIZE.width, 0.5 * SIZE.height
    whole = ros(
        "sensor_msgs/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
    )
    return ros(
        "sensor_msgs/CameraInfo",
        header=header(stamp, CAMERA),
        height=SIZE.height,
        width=SIZE.width,
        distortion_model="plumb_bob",
        d=np.zeros(5),
        k=np.array(camera_matrix(FOCAL, x, y)),
        r=np.array(NOT_TURNED),
        p=np.array(projection_matrix(FOCAL, x, y)),
        binning_x=0,
        binning_y=0,
        roi=whole,
    )


def eye(picture: Picture, stamp: int) -> Any:
    """The frame of a picture's camera: x right, y down, z ahead."""
    place = [*picture.view.eye.tolist(), *quaternion_of(picture.view.axes).tolist()]
    return ros("tf2_msgs/TFMessage", transforms=[transform(header(stamp), CAMERA, place)])
