"""A recording for the Rerun viewer: transforms, shapes, goals, images, and plots of all values."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skybody.look.couplings import RADIUS
from skybody.look.flight import Array
from skybody.look.scene import ROPE, Fixed
from skybody.look.shapes import BOX, CYLINDER, MESH, SPHERE, Color

from .about import SCENARIO, about
from .frames import WORLD, finite, frame_of, goal_quaternions, quaternion_of
from .images import FOCAL, SIZE, Picture, pictures
from .order import events
from .table import NANO, Block, Table
from .world import World

os.environ.setdefault("RUST_LOG", "off")  # Rerun prints errors beside those that it raises
import rerun

TIME = "time"  # timeline
AXIS_LENGTH = 0.2  # of goals [m]
SOLID = rerun.components.FillMode.Solid


def write(table: Table, path: Path, options: argparse.Namespace) -> None:
    """Writes the recording; docs/exports.md lists its entities."""
    recording = rerun.RecordingStream("skybody")
    recording.set_log_time_enabled(False)
    recording.save(path)
    try:
        for _ in parts(recording, table, options.images):
            recording.flush()
    except RuntimeError as error:
        fail_as_a_file(path)
        raise OSError(str(error)) from None
    recording.disconnect()


def fail_as_a_file(path: Path) -> None:
    """Raises the OSError for which no more can be written to a file, which Rerun does not tell."""
    with path.open("ab") as file:
        file.write(bytes(1 << 16))


def parts(file: rerun.RecordingStream, table: Table, camera: str | None) -> Iterator[None]:
    """Adds all parts of the recording, one after another."""
    file.send_recording_name(table.flight.scenario)
    file.log(WORLD, rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    texts: dict[str, Any] = about(table, SCENARIO)
    file.log("about", rerun.AnyValues(**texts), static=True)
    world = World(table)
    for part in world.parts:
        place = WORLD if part.frame == WORLD else f"{WORLD}/{part.frame}"
        write_shapes(file, f"{place}/shapes", part.shapes)
    describe(file, table)
    for block in table.blocks():
        write_block(file, table, world, block)
        yield
    for time, text in events(table):
        set_time(file, time)
        file.log("events", rerun.TextLog(text, level="INFO"))
    for time, picture in pictures(table, camera):
        set_time(file, time)
        write_picture(file, picture)
        yield
    yield


def set_time(file: rerun.RecordingStream, time: float) -> None:
    """Sets the time of the next values [s]."""
    file.set_time(TIME, duration=np.timedelta64(round(time * NANO), "ns"))


# --- rows ---------------------------------------------------------------------------------------


def describe(file: rerun.RecordingStream, table: Table) -> None:
    """Names the plots, and shows goals as axes."""
    for name, series in table.series.items():
        if not series.items:
            plot_names(file, f"log/{name}", series.columns or (name,))
        for item in series.items:
            plot_names(file, f"log/{name}/{frame_of(item)}", series.columns)
        if name == "goal":
            for item in series.items:
                axes = rerun.TransformAxes3D(AXIS_LENGTH)
                file.log(f"{WORLD}/goal/{frame_of(item)}", axes, static=True)


def plot_names(file: rerun.RecordingStream, entity: str, names: Sequence[str]) -> None:
    """Names the values of an entity."""
    file.log(entity, rerun.SeriesLines(names=list(names)), static=True)


def write_block(file: rerun.RecordingStream, table: Table, world: World, block: Block) -> None:
    """Writes the rows of a block."""
    for name, series in table.series.items():
        values = block.real(name)
        for k, item in enumerate(series.items):
            rows = values[:, k]
            if name == "bodies":
                write_poses(file, f"{WORLD}/{frame_of(item)}", block, rows[:, :7])
            else:
                pose = np.concatenate([rows[:, :3], goal_quaternions(rows[:, 3])], axis=1)
                write_poses(file, f"{WORLD}/goal/{frame_of(item)}", block, pose)
            write_plot(file, f"log/{name}/{frame_of(item)}", block, rows)
        if not series.items:
            write_plot(file, f"log/{name}", block, values.reshape(len(block.time), -1))
    if world.has_lines:
        write_lines(file, world, block)


def time_of(block: Block, rows: NDArray[np.bool_] | slice = slice(None)) -> rerun.TimeColumn:
    """The times of some rows of a block; default: of all."""
    return rerun.TimeColumn(TIME, duration=block.stamps(NANO)[rows].astype("timedelta64[ns]"))


def write_poses(file: rerun.RecordingStream, entity: str, block: Block, poses: Array) -> None:
    """Poses of 7 numbers: position, quaternion w x y z; those that are not finite are left out."""
    known = finite(poses)
    columns = rerun.Transform3D.columns(
        translation=poses[known, :3], quaternion=poses[known][:, [4, 5, 6, 3]]
    )
    if known.any():
        file.send_columns(entity, [time_of(block, known)], columns)


def write_plot(file: rerun.RecordingStream, entity: str, block: Block, values: Array) -> None:
    """Values of an entity, (rows, number)."""
    rows, number = values.shape
    columns = rerun.Scalars.columns(scalars=values.ravel()).partition([number] * rows)
    file.send_columns(entity, [time_of(block)], columns)


def write_lines(file: rerun.RecordingStream, world: World, block: Block) -> None:
    """The couplings in rows where they are due."""
    for time, lines in zip(block.time.tolist(), world.lines(block), strict=True):
        if lines is not None:
            set_time(file, time)
            strips = [np.array(line) for line in lines.values()]
            drawn = rerun.LineStrips3D(strips, radii=RADIUS, colors=rgb(ROPE))
            file.log(f"{WORLD}/couplings", drawn)


# --- shapes and images --------------------------------------------------------------------------


def rgb(color: Color) -> list[int]:
    """A colour of bytes."""
    return [round(255 * part) for part in color]


def write_shapes(file: rerun.RecordingStream, entity: str, shapes: Sequence[Fixed]) -> None:
    """The shapes of a body, or of the world."""
    for kind, word in ((BOX, "boxes"), (SPHERE, "spheres"), (CYLINDER, "cylinders")):
        chosen = [shape for shape in shapes if shape.kind == kind]
        if chosen:
            file.log(f"{entity}/{word}", solids(kind, chosen), static=True)
    for k, shape in enumerate(s for s in shapes if s.kind == MESH):
        assert shape.corners is not None
        corners = shape.position + shape.corners.reshape(-1, 3) @ shape.axes.T
        mesh = rerun.Mesh3D(vertex_positions=corners, albedo_factor=rgb(shape.color))
        file.log(f"{entity}/mesh_{k}", mesh, static=True)


def solids(kind: int, shapes: Sequence[Fixed]) -> rerun.AsComponents:
    """Boxes, spheres or cylinders."""
    half = np.array([shape.half for shape in shapes])
    places: dict[str, Any] = {
        "centers": np.array([shape.position for shape in shapes]),
        "quaternions": np.array([quaternion_of(shape.axes)[[1, 2, 3, 0]] for shape in shapes]),
        "colors": [rgb(shape.color) for shape in shapes],
        "fill_mode": SOLID,
    }
    if kind == BOX:
        return rerun.Boxes3D(half_sizes=half, **places)
    if kind == SPHERE:
        return rerun.Ellipsoids3D(half_sizes=half, **places)
    return rerun.Cylinders3D(lengths=2.0 * half[:, 2], radii=half[:, 0], **places)


def write_picture(file: rerun.RecordingStream, picture: Picture) -> None:
    """A picture at the place of its camera."""
    place = rerun.Transform3D(translation=picture.view.eye, mat3x3=picture.view.axes)
    lens = rerun.Pinhole(focal_length=FOCAL, width=SIZE.width, height=SIZE.height)
    image = rerun.EncodedImage(contents=picture.jpeg, media_type="image/jpeg")
    file.log(f"{WORLD}/camera", place, lens, image)
