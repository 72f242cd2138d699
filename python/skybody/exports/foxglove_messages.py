"""Foxglove's messages of the rows of a flight; None for rows whose values are not finite."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from foxglove import messages as fox

from skybody.look.couplings import RADIUS
from skybody.look.flight import Array
from skybody.look.scene import ROPE, Fixed
from skybody.look.shapes import BOX, CYLINDER, MESH, SPHERE

from .frames import CAMERA, WORLD, finite, goal_quaternions, quaternion_of, to_body
from .images import FOCAL, SIZE, Picture
from .lens import NOT_TURNED, camera_matrix, projection_matrix
from .table import NANO, Block
from .world import Part, World

LINE_WIDTH = 2.0 * RADIUS  # of couplings [m]


def stamp_of(nanoseconds: int) -> fox.Timestamp:
    """A time."""
    return fox.Timestamp(*divmod(nanoseconds, NANO))


def vector(values: Sequence[float]) -> fox.Vector3:
    """A vector of 3 numbers."""
    return fox.Vector3(x=values[0], y=values[1], z=values[2])


def turn(values: Sequence[float]) -> fox.Quaternion:
    """A quaternion w x y z."""
    return fox.Quaternion(w=values[0], x=values[1], y=values[2], z=values[3])


def pose(values: Sequence[float]) -> fox.Pose:
    """A pose of 7 numbers: position, quaternion w x y z."""
    return fox.Pose(position=vector(values), orientation=turn(values[3:7]))


# --- of rows ------------------------------------------------------------------------------------


def transforms(block: Block, frames: Sequence[str]) -> Iterator[fox.FrameTransforms]:
    """All bodies' frames in the world."""
    bodies = block.real("bodies")
    rows = zip(block.stamps(NANO).tolist(), bodies.tolist(), finite(bodies[:, :, :7]), strict=True)
    for stamp, row, known in rows:
        time = stamp_of(stamp)
        yield fox.FrameTransforms(
            transforms=[
                fox.FrameTransform(
                    timestamp=time,
                    parent_frame_id=WORLD,
                    child_frame_id=frame,
                    translation=vector(body),
                    rotation=turn(body[3:7]),
                )
                for frame, body, good in zip(frames, row, known, strict=True)
                if good
            ]
        )


def poses(block: Block, values: Array) -> Iterator[fox.PoseInFrame | None]:
    """Poses in the world of rows of 7 numbers: position, quaternion w x y z."""
    stamps = block.stamps(NANO).tolist()
    for stamp, row, good in zip(stamps, values.tolist(), finite(values), strict=True):
        made = fox.PoseInFrame(timestamp=stamp_of(stamp), frame_id=WORLD, pose=pose(row))
        yield made if good else None


def base(block: Block, body: int) -> Iterator[fox.PoseInFrame | None]:
    """The poses of a body."""
    return poses(block, block.real("bodies")[:, body, :7])


def goals(block: Block, goal: int) -> Iterator[fox.PoseInFrame | None]:
    """The poses of a goal."""
    rows = block.real("goal")[:, goal]
    return poses(block, np.concatenate([rows[:, :3], goal_quaternions(rows[:, 3])], axis=1))


def odometry(block: Block, body: int, frame: str) -> Iterator[fox.Odometry | None]:
    """Pose in the world and velocities in the frame of a body."""
    rows = block.real("bodies")[:, body]
    velocities = to_body(rows[:, 3:7], rows[:, 7:10])
    stamps, known = block.stamps(NANO).tolist(), finite(rows)
    for stamp, row, velocity, good in zip(
        stamps, rows.tolist(), velocities.tolist(), known, strict=True
    ):
        made = fox.Odometry(
            timestamp=stamp_of(stamp),
            frame_id=WORLD,
            body_frame_id=frame,
            pose=pose(row),
            linear_velocity=vector(velocity),
            angular_velocity=vector(row[10:13]),
        )
        yield made if good else None


# --- shapes -------------------------------------------------------------------------------------


def color_of(rgb: Sequence[float]) -> fox.Color:
    """A colour that hides all behind it."""
    return fox.Color(r=rgb[0], g=rgb[1], b=rgb[2], a=1.0)


def entity(part: Part, stamp: int) -> fox.SceneEntity:
    """The shapes of a body or of the world, which move with their frame."""
    return fox.SceneEntity(
        timestamp=stamp_of(stamp),
        frame_id=part.frame,
        id=part.name,
        frame_locked=True,
        cubes=[
            fox.CubePrimitive(pose=place(s), size=edges(s), color=color_of(s.color))
            for s in part.shapes
            if s.kind == BOX
        ],
        spheres=[
            fox.SpherePrimitive(pose=place(s), size=edges(s), color=color_of(s.color))
            for s in part.shapes
            if s.kind == SPHERE
        ],
        cylinders=[
            fox.CylinderPrimitive(
                pose=place(s),
                size=edges(s),
                bottom_scale=1.0,
                top_scale=1.0,
                color=color_of(s.color),
            )
            for s in part.shapes
            if s.kind == CYLINDER
        ],
        triangles=[triangles(s) for s in part.shapes if s.kind == MESH],
    )


def place(shape: Fixed) -> fox.Pose:
    """The pose of a shape in its frame."""
    return pose([*shape.position.tolist(), *quaternion_of(shape.axes).tolist()])


def edges(shape: Fixed) -> fox.Vector3:
    """Edges of a box about a shape."""
    return vector([2.0 * half for half in shape.half])


def triangles(shape: Fixed) -> fox.TriangleListPrimitive:
    """A mesh."""
    assert shape.corners is not None
    points = [
        fox.Point3(x=x, y=y, z=z) for x, y, z in shape.corners.reshape(-1, 3).astype(float).tolist()
    ]
    return fox.TriangleListPrimitive(pose=place(shape), points=points, color=color_of(shape.color))


def couplings(block: Block, world: World) -> Iterator[fox.SceneUpdate | None]:
    """The lines of couplings in rows where they are due."""
    for stamp, points in zip(block.stamps(NANO).tolist(), world.lines(block), strict=True):
        yield None if points is None else lines(stamp, points)


def lines(stamp: int, points: dict[str, list[Array]]) -> fox.SceneUpdate:
    """The couplings, each as an entity that replaces its last one."""
    return fox.SceneUpdate(
        entities=[
            fox.SceneEntity(
                timestamp=stamp_of(stamp),
                frame_id=WORLD,
                id=name,
                lines=[
                    fox.LinePrimitive(
                        type=fox.LinePrimitiveLineType.LineStrip,
                        thickness=LINE_WIDTH,
                        points=[fox.Point3(x=x, y=y, z=z) for x, y, z in np.array(line).tolist()],
                        color=color_of(ROPE),
                    )
                ],
            )
            for name, line in points.items()
        ]
    )


# --- images -------------------------------------------------------------------------------------


def image(picture: Picture, stamp: int) -> fox.CompressedImage:
    """A picture."""
    return fox.CompressedImage(
        timestamp=stamp_of(stamp), frame_id=CAMERA, data=picture.jpeg, format="jpeg"
    )


def calibration(stamp: int) -> fox.CameraCalibration:
    """The lens of pictures: no distortion."""
    x, y = 0.5 * SIZE.width, 0.5 * SIZE.height
    return fox.CameraCalibration(
        timestamp=stamp_of(stamp),
        frame_id=CAMERA,
        width=SIZE.width,
        height=SIZE.height,
        K=camera_matrix(FOCAL, x, y),
        R=NOT_TURNED,
        P=projection_matrix(FOCAL, x, y),
    )


def eye(picture: Picture, stamp: int) -> fox.FrameTransforms:
    """The frame of a picture's camera: x right, y down, z ahead."""
    return fox.FrameTransforms(
        transforms=[
            fox.FrameTransform(
                timestamp=stamp_of(stamp),
                parent_frame_id=WORLD,
                child_frame_id=CAMERA,
                translation=vector(picture.view.eye.tolist()),
                rotation=turn(quaternion_of(picture.view.axes).tolist()),
            )
        ]
    )
