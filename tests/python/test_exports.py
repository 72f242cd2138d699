"""`skybody export`: each format is read again by its own reader, and has the values of the log."""

from __future__ import annotations

import io
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import foxglove
import h5py
import numpy as np
import pandas as pd
import pyarrow.parquet
import pytest
import pyulog
from foxglove import messages as fox
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from numpy.typing import NDArray
from PIL import Image
from rerun.chunk import McapReader, RrdReader
from rosbags.highlevel import AnyReader
from skybody import InputError
from skybody.exports import formats, table
from skybody.exports.__main__ import main
from skybody.exports.frames import quaternion_of, topic_of
from skybody.look.flight import Flight, rotation_of

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
SCENARIOS = ("chase", "cooperative_payload_ropes", "hover_sensors", "racing")
STEPS = 20
FORMATS = [name for name, row in formats.FORMATS.items() if row.reads == formats.FLIGHT]
FLIP = np.array([1.0, -1.0, -1.0])
# A quaternion of the log has norm 1 up to round-off, and a rotation there and back adds some more.
ROUND_OFF = 1e-13

Array = NDArray[Any]


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A short flight of each of some scenarios."""
    found = {}
    for name in SCENARIOS:
        folder = tmp_path_factory.mktemp(name)
        command = [PROGRAM, "run", name, "--steps", str(STEPS), "--no-picture", "--out", folder]
        subprocess.run(command, check=True, capture_output=True, timeout=100)
        found[name] = folder / "flight.h5"
    return found


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Logs of these tests have several blocks."""
    monkeypatch.setattr(table, "MOST_ROWS", 7)


def export(log: Path, kind: str, out: Path, *options: str) -> Path:
    """Exports a log."""
    assert main([str(log), "--to", kind, "--out", str(out), *options]) == 0
    return out


def data_of(log: Path) -> dict[str, Array]:
    """The datasets of the first episode."""
    with h5py.File(log) as file:
        return {name: data[:] for name, data in file["episodes/0001"].items()}


def names_of(log: Path, dataset: str, key: str = "columns") -> list[str]:
    with h5py.File(log) as file:
        return [str(name) for name in file["episodes/0001"][dataset].attrs[key]]


def rows(data: dict[str, Array]) -> dict[str, Array]:
    """The datasets with a row for each time, (rows, values)."""
    skipped = ("time", "events", "params")
    return {k: v.reshape(len(v), -1) for k, v in data.items() if k not in skipped}


# --- tables -------------------------------------------------------------------------------------


def check_frame(frame: pd.DataFrame, log: Path) -> None:
    data = data_of(log)
    np.testing.assert_array_equal(frame["time"], data["time"])
    for name, values in rows(data).items():
        chosen = [c for c in frame.columns if c == name or c.startswith(f"{name}/")]
        assert len(chosen) == values.shape[1]
        np.testing.assert_array_equal(frame[chosen].to_numpy(), values.astype(np.float64))


@pytest.mark.parametrize("name", SCENARIOS)
def test_csv_has_all_digits(logs: dict[str, Path], tmp_path: Path, name: str) -> None:
    out = export(logs[name], "csv", tmp_path / "a.csv")
    check_frame(pd.read_csv(out), logs[name])


def test_columns_of_tables_are_named_after_datasets_and_bodies(
    logs: dict[str, Path], tmp_path: Path
) -> None:
    columns = pd.read_csv(export(logs["chase"], "csv", tmp_path / "a.csv")).columns
    assert columns[:3].tolist() == ["time", "bodies/hawk.base_link.x", "bodies/hawk.base_link.y"]
    assert {"reward", "rotor_speed/owl.front_left", "goal/evader.base_link.yaw"} <= set(columns)
    limited = [c for c in columns if c.startswith("info/velocity_tracking.limited")]
    assert [c[-2:] for c in limited] == ["ed", "_2", "_3"]  # of three robots, with one name
    assert len(set(columns)) == len(columns)


def test_parquet_has_types_units_and_the_scenario(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["hover_sensors"]
    out = export(log, "parquet", tmp_path / "a.parquet")
    frame = pd.read_parquet(out)
    check_frame(frame, log)
    assert frame["info/tilt"].dtype == np.float32
    schema = pyarrow.parquet.read_schema(out)
    assert schema.field("bodies/quad.base_link.vx").metadata[b"unit"] == b"m/s"
    assert schema.metadata[b"scenario_text"].startswith(b"name: hover_sensors\n")


def test_a_wide_dataset_is_one_column_of_lists(
    logs: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from skybody.exports import parquet

    monkeypatch.setattr(parquet, "MOST_COLUMNS", 60)
    frame = pd.read_parquet(export(logs["chase"], "parquet", tmp_path / "a.parquet"))
    np.testing.assert_array_equal(
        np.stack(frame["observation"]), data_of(logs["chase"])["observation"]
    )
    assert "info/evader_distance" in frame


def test_npz_has_the_arrays_of_the_log(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["chase"]
    found = np.load(export(log, "npz", tmp_path / "a.npz"), allow_pickle=False)
    data = data_of(log)
    for name in ("time", *rows(data)):
        np.testing.assert_array_equal(found[name], data[name])
        assert found[name].dtype == data[name].dtype
    assert found["bodies.items"].tolist() == names_of(log, "bodies", "items")
    assert found["events.text"].tolist() == [e["text"].decode() for e in data["events"]]
    assert str(found["scenario"]) == "chase"


# --- MCAP ---------------------------------------------------------------------------------------


def read_mcap(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Times [ns] and messages by topic, decoded by the schemas of the file."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append((message.log_time, decoded))
    return found


def check_times(stamps: list[int], log: Path) -> None:
    """Times [ns] are those of the log to 1 us."""
    np.testing.assert_allclose(np.array(stamps) * 1e-9, data_of(log)["time"], rtol=0, atol=1e-6)


def pose_in(pose: Any) -> list[float]:
    """Position and quaternion w x y z of a message."""
    p, q = pose.position, pose.orientation
    return [p.x, p.y, p.z, q.w, q.x, q.y, q.z]


def xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def check_odometry(messages: list[Any], body: Array) -> None:
    """Poses in the world and velocities in the body, of either of two programs' messages."""
    np.testing.assert_array_equal([pose_in(pose) for pose, _, _ in messages], body[:, :7])
    turned = rotation_of(body[:, 3:7])
    found = np.array([xyz(velocity) for _, velocity, _ in messages])
    world = np.einsum("nij,nj->ni", turned, found)
    np.testing.assert_allclose(world, body[:, 7:10], rtol=0, atol=ROUND_OFF * 100)
    np.testing.assert_array_equal([xyz(rate) for _, _, rate in messages], body[:, 10:])


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


# --- ROS 2 --------------------------------------------------------------------------------------


def read_bag(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Times [ns] and messages by topic."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with AnyReader([path]) as reader:
        for connection, time, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((time, message))
    return found


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
@pytest.mark.parametrize("name", ["hover_sensors", "chase"])
def test_bags_have_poses_velocities_and_transforms(
    logs: dict[str, Path], tmp_path: Path, name: str, storage: str
) -> None:
    log = logs[name]
    out = export(log, "rosbag2", tmp_path / "bag", "--storage", storage)
    assert len(list(out.glob("*.mcap" if storage == "mcap" else "*.db3"))) == 1
    found, data = read_bag(out), data_of(log)
    for k, body in enumerate(names_of(log, "bodies", "items")):
        robot, link = body.split(".")
        topic = f"/{robot}" if link == "base_link" else f"/{robot}/{link}"
        odometry = found[f"{topic}/odometry"]
        check_times([time for time, _ in odometry], log)
        stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for _, m in odometry]
        check_times(stamps, log)
        check_odometry(
            [(m.pose.pose, m.twist.twist.linear, m.twist.twist.angular) for _, m in odometry],
            data["bodies"][:, k],
        )
        assert odometry[0][1].child_frame_id == f"{robot}/{link}"
        place = [xyz(m.transforms[k].transform.translation) for _, m in found["/tf"]]
        np.testing.assert_array_equal(place, data["bodies"][:, k, :3])


def test_bags_have_the_imu_goals_rotors_and_shapes(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["hover_sensors"]
    found, data = read_bag(export(log, "rosbag2", tmp_path / "bag")), data_of(log)
    first = names_of(log, "sensors").index("imu.specific_force[0]")
    force = [xyz(m.linear_acceleration) for _, m in found["/imu"]]
    rate = [xyz(m.angular_velocity) for _, m in found["/imu"]]
    np.testing.assert_array_equal(np.hstack([force, rate]), data["sensors"][:, first : first + 6])
    assert found["/imu"][0][1].orientation_covariance[0] == -1.0  # no orientation
    goals = [xyz(m.pose.position) for _, m in found["/goal/quad/base_link"]]
    np.testing.assert_array_equal(goals, data["goal"][:, 0, :3])
    rotors = found["/quad/rotors"]
    np.testing.assert_array_equal([m.velocity for _, m in rotors], data["rotor_speed"])
    assert [f"quad.{n}" for n in rotors[0][1].name] == names_of(log, "rotor_speed")
    ((_, shapes),) = found["/markers"]
    assert {m.header.frame_id for m in shapes.markers} >= {"quad/base_link", "quad/bob"}
    values = found["/log/info"]
    np.testing.assert_array_equal([m.data for _, m in values], data["info"])
    assert values[0][1].layout.dim[0].label.split(",") == names_of(log, "info")


def test_bags_have_images(logs: dict[str, Path], tmp_path: Path) -> None:
    found = read_bag(export(logs["chase"], "rosbag2", tmp_path / "bag", "--images", "orbit"))
    image = found["/camera/image/compressed"][0][1]
    assert Image.open(io.BytesIO(image.data.tobytes())).size == (640, 360)
    assert found["/camera/camera_info"][0][1].header.frame_id == image.header.frame_id


# --- ULog ---------------------------------------------------------------------------------------


def test_ulog_has_the_state_of_each_robot_in_ned_and_frd(
    logs: dict[str, Path], tmp_path: Path
) -> None:
    log = logs["chase"]
    found, data = pyulog.ULog(str(export(log, "ulog", tmp_path / "a.ulg"))), data_of(log)
    assert not found.file_corruption
    for k in range(4):
        body = data["bodies"][:, k]
        place = found.get_dataset("vehicle_local_position", k).data
        stamps = place["timestamp"] * 1000
        check_times(stamps.tolist(), log)
        expected = np.hstack([body[:, :3] * FLIP, body[:, 7:10] * FLIP]).astype(np.float32)
        np.testing.assert_array_equal(
            np.stack([place[c] for c in ("x", "y", "z", "vx", "vy", "vz")], axis=1), expected
        )
        turn = found.get_dataset("vehicle_attitude", k).data
        q = np.stack([turn[f"q[{j}]"] for j in range(4)], axis=1).astype(np.float64)
        flip = np.diag(FLIP)
        turned = flip @ rotation_of(body[:, 3:7]) @ flip  # NED from W from B from FRD
        np.testing.assert_allclose(rotation_of(q), turned, atol=1e-6)  # of float32
        heading = np.arctan2(turned[:, 1, 0], turned[:, 0, 0])
        np.testing.assert_allclose(place["heading"], heading, atol=1e-6)
        rate = found.get_dataset("vehicle_angular_velocity", k).data
        rates = np.stack([rate[f"xyz[{j}]"] for j in range(3)], axis=1)
        np.testing.assert_array_equal(rates, (body[:, 10:] * FLIP).astype(np.float32))
        outputs = found.get_dataset("actuator_outputs", k).data
        speeds = np.stack([outputs[f"output[{j}]"] for j in range(4)], axis=1)
        mine = data["rotor_speed"][:, 4 * k : 4 * k + 4]
        np.testing.assert_array_equal(speeds, mine.astype(np.float32))
        assert set(outputs["noutputs"]) == {4}


def test_ulog_has_sensors_goals_and_events(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["hover_sensors"]
    found, data = pyulog.ULog(str(export(log, "ulog", tmp_path / "a.ulg"))), data_of(log)
    sensors = names_of(log, "sensors")
    imu = found.get_dataset("sensor_combined").data
    first = sensors.index("imu.specific_force[0]")
    force = np.stack([imu[f"accelerometer_m_s2[{j}]"] for j in range(3)], axis=1)
    expected = (data["sensors"][:, first : first + 3] * FLIP).astype(np.float32)
    np.testing.assert_array_equal(force, expected)
    volts = found.get_dataset("battery_status", 1).data["voltage_v"]  # instance 0: the pack's
    place = sensors.index("battery.voltage")
    np.testing.assert_array_equal(volts, data["sensors"][:, place].astype(np.float32))
    goal = found.get_dataset("vehicle_local_position_setpoint").data
    np.testing.assert_array_equal(goal["z"], -data["goal"][:, 0, 2].astype(np.float32))
    assert found.logged_messages[0].message == "reset"
    assert found.msg_info_dict["scenario"] == "hover_sensors"


# --- Rerun --------------------------------------------------------------------------------------


def read_rerun(path: Path) -> dict[str, dict[str, list[Any]]]:
    """Columns of each entity."""
    found: dict[str, dict[str, list[Any]]] = {}
    for chunk in RrdReader(path).stream().to_chunks():
        columns = found.setdefault(chunk.entity_path, {})
        for name, values in chunk.to_record_batch().to_pydict().items():
            columns.setdefault(name, []).extend(values)
    return found


def test_rrd_has_transforms_shapes_and_all_values(logs: dict[str, Path], tmp_path: Path) -> None:
    log = logs["cooperative_payload_ropes"]
    found, data = read_rerun(export(log, "rrd", tmp_path / "a.rrd")), data_of(log)
    for k, body in enumerate(names_of(log, "bodies", "items")):
        entity = body.replace(".", "/")
        moved = found[f"/world/{entity}"]
        stamps = [int(np.timedelta64(t, "ns").astype(np.int64)) for t in moved["time"]]
        check_times(stamps, log)
        place = np.array(moved["Transform3D:translation"]).reshape(-1, 3)
        np.testing.assert_array_equal(place, data["bodies"][:, k, :3].astype(np.float32))
        turn = np.array(moved["Transform3D:quaternion"]).reshape(-1, 4)[:, [3, 0, 1, 2]]
        np.testing.assert_array_equal(turn, data["bodies"][:, k, 3:7].astype(np.float32))
        values = np.array(found[f"/log/bodies/{entity}"]["Scalars:scalars"][: len(data["time"])])
        np.testing.assert_array_equal(values, data["bodies"][:, k])
    for name, values in rows(data).items():
        if name not in ("bodies", "goal"):
            scalars = [v for v in found[f"/log/{name}"]["Scalars:scalars"] if v]
            np.testing.assert_array_equal(np.array(scalars), values)
    assert found["/log/info"]["SeriesLines:names"][0] == names_of(log, "info")
    assert "Boxes3D:half_sizes" in found["/world/load/plate/shapes/boxes"]
    assert found["/events"]["TextLog:text"][0] == ["reset"]
    assert len(found["/world/couplings"]["LineStrips3D:strips"][0]) == 3


# --- parts of a log -----------------------------------------------------------------------------


def test_a_part_of_the_rows_and_datasets_can_be_exported(
    logs: dict[str, Path], tmp_path: Path
) -> None:
    log = logs["chase"]
    time = data_of(log)["time"].tolist()
    options = ["--from", f"{time[3]}", "--until", f"{time[15]}", "--every", "2"]
    out = export(log, "csv", tmp_path / "a.csv", *options, "--datasets", "reward,rotor_speed")
    frame = pd.read_csv(out)
    np.testing.assert_array_equal(frame["time"], time[3:16:2])
    assert {c.split("/")[0] for c in frame.columns} == {"time", "reward", "rotor_speed"}
    np.testing.assert_array_equal(
        frame["rotor_speed/hawk.front_left"], data_of(log)["rotor_speed"][3:16:2, 0]
    )


def test_rows_are_read_in_blocks_of_limited_size(
    logs: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = table.Table(Flight(logs["chase"]))
    assert [len(block.time) for block in whole.blocks()] == [7, 7, 7]
    width = len(whole.series["observation"].paths)
    monkeypatch.setattr(table, "MOST_VALUES", 2 * width)
    assert [len(block.time) for block in whole.blocks("observation")] == [2] * 10 + [1]


def test_the_file_is_written_beside_the_log_by_default(
    logs: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(logs["chase"], tmp_path / "flight.h5")
    for source, kind, name in (
        (str(tmp_path), "csv", "flight.csv"),
        (f"{tmp_path}/flight.h5:1", "rosbag2", "flight-1_bag"),
    ):
        assert main([source, "--to", kind]) == 0
        assert (tmp_path / name).exists()
        assert capsys.readouterr().out == f"{kind:<8} {tmp_path / name}\n"


def test_the_program_has_the_command(logs: dict[str, Path], tmp_path: Path) -> None:
    command = [PROGRAM, "export", logs["chase"], "--to", "npz", "-o", tmp_path / "a.npz"]
    subprocess.run(command, check=True, capture_output=True, timeout=60)
    text = subprocess.run([PROGRAM, "export", "--help"], capture_output=True, text=True).stdout
    assert all(f"--to {name}" in text for name in formats.FORMATS)


# --- names and rotations ------------------------------------------------------------------------


def test_topics_are_names_that_ros_accepts() -> None:
    assert topic_of("quad.base_link") == "/quad/base_link"
    assert topic_of("goal", "drone-1.2nd") == "/goal/drone_1/_2nd"


def test_matrices_become_the_quaternions_that_they_are_of() -> None:
    rng = np.random.default_rng(1)
    random = rng.normal(size=(200, 4))
    turns = [*random, *np.eye(4), *-np.eye(4), [0.0, 0.6, -0.8, 0.0]]
    for q in turns:
        turn = rotation_of(np.array(q))
        found = quaternion_of(turn)
        assert found[0] >= 0.0
        np.testing.assert_allclose(rotation_of(found), turn, atol=1e-15 * 4)


# --- bad input ----------------------------------------------------------------------------------


def refused(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """The one line about an error."""
    capsys.readouterr()
    try:
        status = main([str(argument) for argument in arguments])
    except SystemExit as error:
        status = error.code  # type: ignore[assignment]
    message = capsys.readouterr().err
    assert status == 2
    assert message.count("\n") == 1
    return message


def changed(log: Path, path: Path, change: Any) -> Path:
    """A copy of a log with some changes."""
    shutil.copy(log, path)
    with h5py.File(path, "a") as file:
        change(file)
    return path


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--to", "xls"], "--to: invalid choice: 'xls'"),
        ([], "--to is missing"),
        (["--to", "csv", "--images"], "--images is not for --to csv; allowed: mcap, rosbag2, rrd"),
        (["--to", "mcap", "--storage", "mcap"], "--storage is not for --to mcap; allowed: rosbag2"),
        (["--to", "csv", "--datasets", "inf"], "no dataset `inf`; there are: bodies, goal, action"),
        (["--to", "csv", "--from", "9"], "no rows from 9 to inf s; the flight has 0 to "),
        (["--to", "csv", "--every", "0"], "--every: 0 is out of range; allowed: 1.."),
        (["--to", "mcap", "--images", "drone"], "no camera `drone`; there are: "),
    ],
)
def test_wrong_options_are_errors(
    logs: dict[str, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    options: list[str],
    message: str,
) -> None:
    out = tmp_path / "out"
    assert message in refused(capsys, logs["chase"], *options, "-o", out)
    assert not list(tmp_path.iterdir())  # nothing half-written


def remove_bodies(file: h5py.File) -> None:
    del file["episodes/0001/bodies"]


def cut(file: h5py.File) -> None:
    short = file["episodes/0001/info"][:-3]
    del file["episodes/0001/info"]
    file["episodes/0001/info"] = short


def go_back(file: h5py.File) -> None:
    file["episodes/0001/time"][5] = 0.0


def make_empty(file: h5py.File) -> None:
    file["episodes/0001/time"].resize(0, axis=0)


@pytest.mark.parametrize(
    ("change", "kind", "message"),
    [
        (lambda f: f.attrs.modify("format", "skybody flight log 2"), "csv",
         "is a flight log of version 2; allowed: 1"),
        (lambda f: f.attrs.modify("format", "another"), "csv", "is no flight log"),
        (cut, "csv", "is cut short: `info` has 18 rows, `time` has 21"),
        (go_back, "csv", "its times do not increase from row to row"),
        (make_empty, "csv", "episode 1 has no rows"),
        (remove_bodies, "ulog", "has no bodies; PX4's topics are of a vehicle"),
    ],
)  # fmt: skip
def test_unusable_logs_are_errors(
    logs: dict[str, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    change: Any,
    kind: str,
    message: str,
) -> None:
    log = changed(logs["chase"], tmp_path / "flight.h5", change)
    found = refused(capsys, log, "--to", kind)
    assert found.startswith(f"error: {log}: {message}")
    assert list(tmp_path.iterdir()) == [log]


def test_files_that_are_no_logs_are_errors(
    logs: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short = tmp_path / "cut.h5"
    short.write_bytes(logs["chase"].read_bytes()[:4000])
    for path in (short, tmp_path / "none.h5"):
        assert refused(capsys, path, "--to", "csv").startswith(f"error: {path}: ")
    assert "no episode 7; it has 1" in refused(capsys, f"{logs['chase']}:7", "--to", "csv")


@pytest.mark.parametrize("kind", [kind for kind in FORMATS if kind != "ulog"])
def test_logs_without_bodies_are_exported_as_far_as_they_go(
    logs: dict[str, Path], tmp_path: Path, kind: str
) -> None:
    log = changed(logs["hover_sensors"], tmp_path / "flight.h5", remove_bodies)
    assert export(log, kind, tmp_path / "out").exists()


def test_rows_that_are_not_finite_have_no_poses(logs: dict[str, Path], tmp_path: Path) -> None:
    def spoil(file: h5py.File) -> None:
        file["episodes/0001/bodies"][4, 1] = np.nan

    log = changed(logs["chase"], tmp_path / "flight.h5", spoil)
    found = read_mcap(export(log, "mcap", tmp_path / "a.mcap"))
    assert [len(found[f"/{robot}/odometry"]) for robot in ("hawk", "kite")] == [21, 20]
    assert len(found["/tf"][4][1].transforms) == 3
    bag = read_bag(export(log, "rosbag2", tmp_path / "bag"))
    assert [len(bag[f"/{robot}/odometry"]) for robot in ("hawk", "kite")] == [21, 20]
    moved = read_rerun(export(log, "rrd", tmp_path / "a.rrd"))["/world/kite/base_link"]
    assert len(moved["time"]) == 20


def test_without_the_scenario_there_are_no_shapes_and_a_note(
    logs: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def forget(file: h5py.File) -> None:
        file.attrs["scenario_file"] = "/none/gone.yaml"
        file.attrs["scenario"] = "gone"
        file.attrs["scenario_text"] = "robots: []\n"

    log = changed(logs["chase"], tmp_path / "flight.h5", forget)
    found = read_mcap(export(log, "mcap", tmp_path / "a.mcap"))
    assert "/scene" not in found
    assert len(found["/hawk/odometry"]) == 21
    note = capsys.readouterr().err
    assert note.startswith("note: without shapes: ")
    assert note.count("\n") == 1


def test_outputs_that_cannot_be_written_are_errors(
    logs: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for kind in FORMATS:
        out = Path("/proc/none/out")
        found = refused(capsys, logs["chase"], "--to", kind, "-o", out)
        assert found.startswith(f"error: {out}: cannot be written")
    folder = tmp_path / "bag"
    folder.mkdir()
    found = refused(capsys, logs["chase"], "--to", "rosbag2", "-o", folder)
    assert found == f"error: {folder}: is a folder; remove it, or give another name\n"


def test_a_missing_package_is_named_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError(name="rosbags")

    monkeypatch.setattr(formats.importlib, "import_module", missing)
    message = "--to rosbag2 needs the package `rosbags`: `pip install rosbags`"
    with pytest.raises(InputError, match=message):
        formats.FORMATS["rosbag2"].writer()
