"""`skybody export --to mcap`: Foxglove's messages, read by the schemas in the file."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import foxglove
import numpy as np
import pytest
from exported import (
    SCENARIOS,
    STEPS,
    check_odometry,
    check_times,
    data_of,
    export,
    names_of,
    pose_in,
    read_mcap,
    rows,
    xyz,
)
from foxglove import messages as fox
from mcap.reader import make_reader
from PIL import Image
from rerun.chunk import McapReader
from skybody.look.flight import Flight, rotation_of

pytestmark = pytest.mark.usefixtures("small_blocks")


# --- MCAP ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SCENARIOS)
def test_mcap_has_the_poses_and_velocities_of_all_bodies(
    logs: dict[str, Path], tmp_path: Path, name: str
) -> None:
    log = logs[name]
    found = read_mcap(export(log, "mcap", tmp_path / "a.mcap"))
    data, bodies = data_of(log), names_of(log, "bodies", "items")
    robots = list(dict.fromkeys(body.split(".")[0] for body in bodies))
    for k, body in enumerate(bodies):
        robot, link = body.split(".")
        is_base = next(b for b in bodies if b.startswith(f"{robot}.")) == body
        topic = f"/{robot}" if is_base else f"/{robot}/{link}"
        odometry = found[f"{topic}/odometry"]
        check_times([time for time, _ in odometry], log)
        check_odometry(
            [(m.pose, m.linear_velocity, m.angular_velocity) for _, m in odometry],
            data["bodies"][:, k],
        )
        assert odometry[0][1].body_frame_id == f"{robot}/{link}"
        moved = [m.transforms[k] for _, m in found["/tf"]]
        assert {m.child_frame_id for m in moved} == {f"{robot}/{link}"}
        place = [xyz(m.translation) for m in moved]
        np.testing.assert_array_equal(place, data["bodies"][:, k, :3])
    for robot in robots:
        assert len(found[f"/{robot}/pose"]) == len(data["time"])
    assert found["/events"][0][1].message == "reset"


def test_mcap_has_goals_and_all_values_by_name(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["hover_sensors"]
    found = read_mcap(export(log, "mcap", tmp_path / "a.mcap"))
    data = data_of(log)
    goals = [pose_in(m.pose) for _, m in found["/goal/quad/base_link"]]
    np.testing.assert_array_equal(np.array(goals)[:, :3], data["goal"][:, 0, :3])
    yaw = 2.0 * np.arctan2(np.array(goals)[:, 6], np.array(goals)[:, 3])
    np.testing.assert_allclose(yaw, data["goal"][:, 0, 3], atol=1e-15)  # half angles and back
    info, sensors = names_of(log, "info"), names_of(log, "sensors")
    tilt = [m.failed.tilt for _, m in found["/log/info"]]
    np.testing.assert_array_equal(tilt, data["info"][:, info.index("failed.tilt")])
    force = [list(m.imu.specific_force) for _, m in found["/log/sensors"]]
    first = sensors.index("imu.specific_force[0]")
    np.testing.assert_array_equal(force, data["sensors"][:, first : first + 3])
    reward = [m.reward for _, m in found["/log/reward"]]
    np.testing.assert_array_equal(reward, data["reward"])


def test_every_value_of_a_log_is_in_the_mcap(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["chase"]  # has names that occur several times
    found = read_mcap(export(log, "mcap", tmp_path / "a.mcap"))
    for name, values in rows(data_of(log)).items():
        if name in ("bodies", "goal"):
            continue
        for (_, message), row in zip(found[f"/log/{name}"], values, strict=True):
            assert sorted(numbers_in(message)) == sorted(row.astype(float).tolist())


def numbers_in(message: Any) -> Iterator[float]:
    """All numbers of a message, also those that are 0."""
    for field in message.DESCRIPTOR.fields:
        value = getattr(message, field.name)
        if field.message_type is not None:
            yield from numbers_in(value)
        elif isinstance(value, float):
            yield value
        else:
            yield from value


def test_mcap_has_the_schemas_of_foxglove(logs: dict[str, Path], tmp_path: Path) -> None:
    out = export(logs["cooperative_payload_ropes"], "mcap", tmp_path / "a.mcap", "--images")
    with out.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    theirs = [s for s in summary.schemas.values() if s.name.startswith("foxglove.")]
    expected = {
        "CameraCalibration", "CompressedImage", "FrameTransforms", "Log", "Odometry",
        "PoseInFrame", "SceneUpdate",
    }  # fmt: skip
    assert {s.name for s in theirs} == {f"foxglove.{name}" for name in expected}
    for schema in theirs:
        own: foxglove.Schema = getattr(fox, schema.name.split(".")[1]).get_schema()
        assert (schema.encoding, schema.data) == (own.encoding, own.data)


def test_another_program_understands_the_mcap(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["racing"]
    out = export(log, "mcap", tmp_path / "a.mcap", "--images")
    found: dict[str, int] = {}
    for chunk in McapReader(out).stream().to_chunks():  # Rerun's, which knows Foxglove's schemas
        for name in chunk.to_record_batch().schema.names:
            key = f"{chunk.entity_path} {name}"
            found[key] = found.get(key, 0) + chunk.num_rows
    rows, robot = STEPS + 1, names_of(log, "bodies", "items")[0].split(".")[0]
    assert found["/tf Transform3D:quaternion"] == rows  # of the only body
    assert found[f"/{robot}/pose InstancePoses3D:translations"] == rows
    assert found["/camera/image EncodedImage:blob"] == found["/camera/tf Transform3D:translation"]
    assert found["/camera/calibration Pinhole:image_from_camera"] > 0
    assert found["/events TextLog:text"] == len(data_of(log)["events"])


def test_mcap_has_the_shapes_of_vehicles_gates_and_ropes(
    logs: dict[str, Path], tmp_path: Path
) -> None:
    log = logs["racing"]
    ((time, scene),) = read_mcap(export(log, "mcap", tmp_path / "a.mcap"))["/scene"]
    entities = {entity.id: entity for entity in scene.entities}
    assert time == 0
    assert entities["obstacles"].frame_id == "world"
    gates = entities["obstacles"].cubes
    assert len(gates) == 5 * 4  # bars of gates
    drawn = Flight(log).drawn
    centre = np.mean([xyz(bar.pose.position) for bar in gates[:4]], axis=0)
    place = [drawn[f"obstacles.gate_1.position[{k}]"] for k in range(3)]
    np.testing.assert_allclose(centre, place, atol=1e-12)
    vehicle = next(e for e in scene.entities if e.id != "obstacles")
    assert vehicle.frame_id == vehicle.id.replace(".", "/")
    assert vehicle.frame_locked
    assert len(vehicle.cylinders) >= 4  # discs of rotors

    log = logs["cooperative_payload_ropes"]
    lines = read_mcap(export(log, "mcap", tmp_path / "b.mcap"))["/couplings"]
    compiled, bodies = Flight(log).compiled, data_of(log)["bodies"][0]
    assert [e.id for e in lines[0][1].entities] == [c.name for c in compiled.couplings]
    first = compiled.couplings[0]
    body = bodies[first.bodies[0]]
    end = body[:3] + rotation_of(body[3:7]) @ np.array(first.points[0])
    found = xyz(lines[0][1].entities[0].lines[0].points[0])
    np.testing.assert_allclose(found, end, atol=1e-12)


def test_images_are_pictures_of_the_camera(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["racing"]
    found = read_mcap(export(log, "mcap", tmp_path / "a.mcap", "--images", "chase"))
    duration = float(data_of(log)["time"][-1])
    assert len(found["/camera/image"]) == int(duration * 10.0) + 1
    image = Image.open(io.BytesIO(found["/camera/image"][0][1].data))
    assert image.size == (640, 360)
    assert np.asarray(image).std() > 5.0  # not of one colour
    lens = found["/camera/calibration"][0][1]
    assert lens.K[0] == lens.K[4] > 0.0
    (eye,) = found["/camera/tf"][0][1].transforms
    assert eye.child_frame_id == found["/camera/image"][0][1].frame_id
