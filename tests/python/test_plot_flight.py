"""The picture of a flight: data read from a log, and positions of vehicles and obstacles."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
pytest.importorskip("h5py")
pytest.importorskip("matplotlib")


@pytest.fixture
def load(monkeypatch: pytest.MonkeyPatch):
    """Imports a module of scripts/."""
    monkeypatch.syspath_prepend(str(ROOT / "scripts"))
    return importlib.import_module


@pytest.fixture
def data(load) -> ModuleType:
    return load("plot_flight_data")


@pytest.fixture
def scene(load) -> ModuleType:
    return load("plot_flight_scene")


def flown(folder: Path, scenario: str, *arguments: str) -> Path:
    command = [PROGRAM, "run", scenario, "--out", folder, "--no-picture", "--steps", "20"]
    subprocess.run([*command, *arguments], check=True, capture_output=True, timeout=60)
    return folder / "flight.h5"


def episode_of(log: Path):
    h5py = importlib.import_module("h5py")
    return h5py.File(log)


def test_obstacles_are_read_from_the_scenario_in_the_log(data: ModuleType, tmp_path: Path) -> None:
    shapes = "[{name: wall, box: [1, 2, 3], position: [4, 5, 6], rpy: [0, 0, 0.5]}, "
    shapes += "{name: ball, sphere: 0.25, position: [0, 9, 9]}, {name: pole, cylinder: [0.1, 2]}]"
    log = episode_of(flown(tmp_path, "hover", "--set", f"obstacles={shapes}"))
    drawn = data.drawn_of(log, log["episodes/0001"])
    found = data.obstacles_of(str(log.attrs["scenario_text"]), drawn)
    assert [o.kind for o in found] == ["box", "sphere", "cylinder"]
    assert found[0].position.tolist() == [4, 5, 6]
    assert found[0].rotation @ [1, 0, 0] == pytest.approx([np.cos(0.5), np.sin(0.5), 0])
    assert found[1].size.tolist() == [0.25]
    assert found[2].size.tolist() == [0.1, 2]


def test_new_shapes_are_read_and_have_faces(
    data: ModuleType, scene: ModuleType, tmp_path: Path
) -> None:
    shapes = "[{name: bar, capsule: [0.1, 2], position: [0, 0, 9]}, {name: slope, plane: true, "
    shapes += "position: [0, 0, -9], rpy: [0, 0.5, 0]}, {name: hills, position: [0, 0, -5], "
    shapes += "height_field: {size: [4, 2], columns: 3, heights: [0, 1, 2, 3, 4, 5]}}]"
    log = episode_of(flown(tmp_path, "hover", "--set", f"obstacles={shapes}"))
    drawn = data.drawn_of(log, log["episodes/0001"])
    found = data.obstacles_of(str(log.attrs["scenario_text"]), drawn)
    assert [o.kind for o in found] == ["capsule", "plane", "height_field"]
    assert found[2].heights.tolist() == [[0, 1, 2], [3, 4, 5]]
    bar = np.concatenate(scene.faces_of(found[0]))
    assert bar.max(axis=0) == pytest.approx([0.1, 0.1, 9 + 1.1], abs=1e-9)
    hills = np.array(scene.faces_of(found[2]))
    assert hills.shape == (4, 3, 3)
    assert hills.reshape(-1, 3).max(axis=0).tolist() == [2, 1, 0]
    low, high = np.full(3, -10.0), np.full(3, 10.0)
    (slope,) = scene.plane_faces(found[1], low, high)
    assert len(slope) >= 4
    assert (slope - found[1].position) @ found[1].rotation[:, 2] == pytest.approx(0, abs=1e-9)
    assert scene.faces_of(found[1]) == []


def test_a_scenario_without_obstacles_has_none(data: ModuleType) -> None:
    assert data.obstacles_of("name: hover\nrobots:\n  - name: quad\n", {}) == []


def test_gates_are_four_bars_where_the_episode_has_them(data: ModuleType, tmp_path: Path) -> None:
    log = episode_of(flown(tmp_path, "gates"))
    drawn = data.drawn_of(log, log["episodes/0001"])
    found = data.obstacles_of(str(log.attrs["scenario_text"]), drawn)
    assert len(found) == 5 * 4
    middle = np.mean([bar.position for bar in found[:4]], axis=0)
    assert middle == pytest.approx([drawn[f"obstacles.gate_1.position[{k}]"] for k in range(3)])
    assert np.abs(middle - [3, 0, 1.5]).max() > 1e-3  # drawn


def test_ball_joints_show_how_far_they_have_turned(data: ModuleType, tmp_path: Path) -> None:
    joints = data.joints_of(episode_of(flown(tmp_path, "payload"))["episodes/0001"])
    assert [(j.unit, j.names) for j in joints] == [("deg", ["quad.rod (ball)", "quad.bob (ball)"])]
    assert joints[0].values[0] == pytest.approx([0, 0], abs=1e-9)


def test_pins_show_their_angle_and_a_free_base_none(data: ModuleType, tmp_path: Path) -> None:
    boom = data.joints_of(episode_of(flown(tmp_path / "boom", "boom"))["episodes/0001"])
    assert boom[0].names == [f"quad.rod_{k}" for k in range(1, 7)]
    assert data.joints_of(episode_of(flown(tmp_path / "hover", "hover"))["episodes/0001"]) == []


def test_bodies_hang_on_what_they_turn_about(scene: ModuleType) -> None:
    """Body 1 turns on the base's tip, body 2 on the other side of the base."""
    angles = np.linspace(0, 1, 9)
    bodies = np.zeros((9, 3, 13))
    bodies[:, :, 3] = 1
    bodies[:, 0, 0] = angles  # the base moves
    bodies[:, 1, :3] = bodies[:, 0, :3] + [0.1, 0, 0]
    bodies[:, 1, 3], bodies[:, 1, 5] = np.cos(angles), np.sin(angles)
    bodies[:, 2, :3] = bodies[:, 0, :3] - [0.3, 0, 0]
    assert scene.parents(bodies) == [0, 0]
    bodies[:, 2, :3] = bodies[:, 1, :3] + 0.2 * scene.rotation_of(bodies[:, 1, 3:7])[:, :, 2]
    assert scene.parents(bodies) == [0, 1]


def test_vehicles_stand_at_equal_distances_and_once_where_they_hover(scene: ModuleType) -> None:
    line = np.zeros((101, 3))
    line[:, 0] = np.linspace(0, 10, 101)
    assert scene.instants_along(line, 0.7).tolist() == [0, 17, 34, 50, 67, 84, 100]
    assert len(scene.instants_along(np.zeros((5, 3)), 0.7)) == 1


def test_a_reference_is_a_goal_that_moves_and_a_place_is_none(
    data: ModuleType, tmp_path: Path
) -> None:
    along = "circle:approach=0,ramp=0.01,check=false"
    log = episode_of(flown(tmp_path / "a", "hover", "--reference", along))
    (track,) = data.read_tracks(log["episodes/0001"])
    assert track.follows()
    assert track.goal[0, :3] == pytest.approx([1.5, 0, 1.5])  # start of the shipped circle
    assert np.hypot(track.goal[:, 0], track.goal[:, 1]) == pytest.approx(1.5, abs=1e-6)
    (hovers,) = data.read_tracks(episode_of(flown(tmp_path / "b", "hover"))["episodes/0001"])
    assert not hovers.follows()


def test_the_script_draws_a_robot_with_joints_among_obstacles(tmp_path: Path) -> None:
    wall = "obstacles=[{name: wall, box: [0.1, 1, 1], position: [9, 9, 1]}]"
    log = flown(tmp_path, "payload", "--set", wall)
    script = ROOT / "scripts/plot_flight.py"
    done = subprocess.run(
        [sys.executable, script, log], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    picture = tmp_path / "flight-0001.png"
    assert done.stdout == f"picture {picture}\n"
    assert picture.stat().st_size > 50_000


def plot(log: Path, *options: str) -> subprocess.CompletedProcess[str]:
    command = [PROGRAM, "plot", log, *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


def test_chosen_panels_are_drawn_as_pdf(tmp_path: Path) -> None:
    log = flown(tmp_path, "hover")
    done = plot(log, "--pdf", "--panels", "z,yaw,path", "--out", str(tmp_path / "drawn"))
    picture = tmp_path / "drawn/flight-0001.pdf"
    assert (done.returncode, done.stdout) == (0, f"picture {picture}\n"), done.stderr
    assert picture.read_bytes().startswith(b"%PDF")
    assert [file.name for file in picture.parent.iterdir()] == [picture.name]


def test_every_panel_is_drawn(tmp_path: Path, load, data: ModuleType) -> None:
    script = load("plot_flight")
    for scenario in ("hover", "payload"):
        log = episode_of(flown(tmp_path / scenario, scenario))
        flight = data.read_flight(log, "0001")
        figure = script.draw_chosen(flight, list(script.PANELS))
        assert len(figure.axes) >= len(script.PANELS)
        script.save(figure, tmp_path / "all.png")


def test_an_unknown_panel_is_an_error_with_the_list(tmp_path: Path) -> None:
    done = plot(Path(__file__), "--panels", "z,jaw")
    assert (done.returncode, done.stdout) == (2, "")
    assert "error: --panels: no panel `jaw`; allowed: x, y, z, " in (done.stderr)


def test_a_log_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    done = plot(tmp_path / "flight.h5")
    assert (done.returncode, done.stdout) == (2, "")
    said = f"error: {tmp_path}/flight.h5: No such file or directory; draw a flight.h5"
    assert said in done.stderr


def test_the_goals_heading_turns_on_as_the_bodys_does(data: ModuleType) -> None:
    turned = np.linspace(3.0, 3.0 + 4.0 * np.pi, 200)  # two turns
    angles = np.degrees(np.stack([0 * turned, 0 * turned, turned], axis=1))
    goal = np.zeros((200, 4))
    goal[:, 3] = (turned + 0.1 + np.pi) % (2.0 * np.pi) - np.pi  # wrapped, as in tasks
    track = data.Track("quad.base_link", "C0", np.zeros((200, 3)), angles, goal)
    assert track.goal_yaw() - angles[:, 2] == pytest.approx(np.degrees(0.1), abs=1e-9)


def test_what_touches_is_shaded_and_what_passes_at_a_distance_is_not(
    data: ModuleType, tmp_path: Path
) -> None:
    spans = data.touching_spans(np.array([0, 0, 1, 1, 0, 1]), np.arange(6.0))
    assert spans == [(1.0, 3.0), (4.0, 5.0)]
    log = episode_of(
        flown(tmp_path, "pendulum")
    )  # its rod is as long as the robot is high above the ground
    assert data.read_flight(log, "0001").touching == []


def test_the_title_says_the_reference_in_place_of_a_policy_that_commands_nothing(
    data: ModuleType, tmp_path: Path
) -> None:
    log = episode_of(flown(tmp_path / "a", "hover", "--reference", "figure_eight:check=false"))
    title = data.read_flight(log, "0001").title
    assert title == "hover along figure_eight  ·  episode 1 of 1  ·  seed 0"
    log = episode_of(flown(tmp_path / "b", "hover"))
    title = data.read_flight(log, "0001").title
    assert title == "hover  ·  episode 1 of 1  ·  policy hold  ·  seed 0"


def test_yaw_is_that_of_the_table(data: ModuleType, tmp_path: Path) -> None:
    """Heading first, then the shortest rotation that tilts: a tilt about any axis keeps the
    heading.
    """
    heading, tilt, axis = 0.7, 0.9, 1.1
    turn = np.array([np.cos(heading / 2), 0.0, 0.0, np.sin(heading / 2)])
    lean = np.array(
        [np.cos(tilt / 2), *(np.sin(tilt / 2) * np.array([np.cos(axis), np.sin(axis), 0]))]
    )
    w, v = lean[0] * turn[0] - lean[1:] @ turn[1:], lean[0] * turn[1:] + turn[0] * lean[1:]
    both = np.array([[w, *(v + np.cross(lean[1:], turn[1:]))]])
    assert data.attitude_degrees(both)[0, 2] == pytest.approx(np.degrees(heading))

    command = [PROGRAM, "run", "hover", "--out", tmp_path, "--no-picture", "--steps", "400"]
    along = "figure_eight:peak_speed=4,approach=0,ramp=0.01,yaw=tangent,check=false"
    done = subprocess.run(
        [*command, "--reference", along], check=True, capture_output=True, text=True, timeout=60
    )
    (track,) = data.read_tracks(episode_of(tmp_path / "flight.h5")["episodes/0001"])
    error = (track.angles[:, 2] - track.goal_yaw() + 180.0) % 360.0 - 180.0
    rows = done.stdout[done.stdout.index("reference of") :].splitlines()
    said = float(rows[2].split()[7])  # yaw RMS, after errors in position
    assert np.ptp(track.angles[:, :2]) > 20.0  # the body does tilt
    begin = 10  # steps of approach and ramp
    found = float(np.sqrt(np.mean(error[begin:] ** 2)))
    assert found == pytest.approx(said, abs=0.006)  # the table has two decimals


def test_a_log_says_where_its_scenario_lies_from_any_folder(tmp_path: Path) -> None:
    text = "include: hover\nname: mine\n"
    (tmp_path / "mine.yaml").write_text(text)
    command = [PROGRAM, "run", "mine.yaml", "--out", "out", "--no-picture", "--steps", "3"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, timeout=60)
    file = str(episode_of(tmp_path / "out/flight.h5").attrs["scenario_file"])
    assert file == str(tmp_path / "mine.yaml")


@pytest.mark.parametrize("kind", ["recording", "policy", "text", "folder", "nothing"])
def test_what_is_no_flight_log_is_one_message(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "file"
    if kind == "recording":
        command = [PROGRAM, "hash", "hover", "--envs", "1", "--steps", "3", "--record", file]
        subprocess.run(command, check=True, capture_output=True, timeout=60)
    elif kind == "policy":
        h5py = importlib.import_module("h5py")
        with h5py.File(file, "w") as written:
            written.attrs["format"] = "skybody-policy"
    elif kind == "folder":
        file.mkdir()
        (file / "flight.h5").write_text("")
    elif kind == "text":
        file.write_text("text")
    done = subprocess.run(
        [sys.executable, ROOT / "scripts/plot_flight.py", file],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 2
    reasons = {
        "recording": "a recording of many environments, which has no flight to draw; `skybody "
        "replay` runs it again, and `skybody run` writes flight.h5",
        "policy": "no flight log: draw a flight.h5, which `skybody run` writes",
        "text": "no HDF5 file; draw a flight.h5, which `skybody run` writes",
        "nothing": "No such file or directory; draw a flight.h5, which `skybody run` writes",
        "folder": "a folder; give its flight.h5",
    }
    assert done.stderr.endswith(f"error: {file}: {reasons[kind]}\n")


def test_a_missing_log_is_one_message() -> None:
    done = subprocess.run(
        [sys.executable, ROOT / "scripts/plot_flight.py"],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 2
    assert done.stderr == "error: LOG is missing; see `skybody plot --help`\n"
