"""`skybody plot`: values that are drawn from a log, and the pictures."""

from __future__ import annotations

import subprocess
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pytest
from skybody.look.flight import Flight
from skybody.plot.measures import height_over_deck, separation, touch_down
from skybody.plot.page import PANELS, draw_chosen, draw_for_paper, draw_page, names_on_page
from skybody.plot.rows import ROWS, chosen
from skybody.plot.still import instants_along
from skybody.plot.subject import Subject, Track, attitude_degrees, touching_spans

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"


def flown(folder: Path, scenario: str, *arguments: str, steps: int = 20) -> Path:
    command = [PROGRAM, "run", scenario, "--out", folder, "--no-picture", "--steps", str(steps)]
    subprocess.run([*command, *arguments], check=True, capture_output=True, timeout=60)
    return folder / "flight.h5"


def subject_of(folder: Path, scenario: str, *arguments: str, steps: int = 20) -> Subject:
    return Subject(Flight(flown(folder, scenario, *arguments, steps=steps)))


def plot(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [PROGRAM, "plot", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


# --- values ---------------------------------------------------------------------------------------


def test_ball_joints_show_how_far_they_have_turned(tmp_path: Path) -> None:
    joints = subject_of(tmp_path, "payload").joints
    assert [name for name, _ in joints["deg"]] == ["quad.rod (ball)", "quad.bob (ball)"]
    assert joints["m"] == []
    assert [values[0] for _, values in joints["deg"]] == pytest.approx([0, 0], abs=1e-9)


def test_pins_show_their_angle_and_a_free_base_none(tmp_path: Path) -> None:
    boom = subject_of(tmp_path / "boom", "boom").joints
    assert [name for name, _ in boom["deg"]] == [f"quad.rod_{k}" for k in range(1, 7)]
    assert subject_of(tmp_path / "hover", "hover").joints == {"deg": [], "m": []}


def test_vehicles_stand_at_equal_distances_and_once_where_they_hover() -> None:
    line = np.zeros((101, 3))
    line[:, 0] = np.linspace(0, 10, 101)
    assert instants_along(line, 0.7).tolist() == [0, 20, 40, 60, 80, 100]
    assert instants_along(np.zeros((5, 3)), 0.7).tolist() == [4]


def test_the_goals_heading_turns_on_as_the_bodys_does() -> None:
    turned = np.linspace(3.0, 3.0 + 4.0 * np.pi, 200)  # two turns
    angles = np.degrees(np.stack([0 * turned, 0 * turned, turned], axis=1))
    goal = np.zeros((200, 4))
    goal[:, 3] = (turned + 0.1 + np.pi) % (2.0 * np.pi) - np.pi  # wrapped, as in tasks
    track = Track("quad.base_link", (0, 0, 0), np.zeros((200, 3)), angles, goal)
    assert track.goal_yaw() - angles[:, 2] == pytest.approx(np.degrees(0.1), abs=1e-9)


def test_a_goal_stays_within_half_a_turn_of_a_robot_that_tumbles() -> None:
    """The goal's heading is constant; the robot turns twice, and comes to rest 40 degrees off."""
    yaw = np.concatenate([np.linspace(0.0, 760.0, 100), np.full(10, 760.0)])
    angles = np.stack([0 * yaw, 0 * yaw, yaw], axis=1)
    track = Track("quad.base_link", (0, 0, 0), np.zeros((110, 3)), angles, np.zeros((110, 4)))
    assert np.abs(track.goal_yaw() - yaw).max() <= 180.0
    assert track.goal_yaw()[-1] == pytest.approx(720.0)


def test_what_touches_is_shaded_and_what_passes_at_a_distance_is_not(tmp_path: Path) -> None:
    spans = touching_spans(np.array([0, 0, 1, 1, 0, 1]), np.arange(6.0))
    assert spans == [(1.0, 3.0), (4.0, 5.0)]
    # The pendulum's rod is as long as the robot is high above the ground.
    assert subject_of(tmp_path, "pendulum").touching == []


def test_the_title_says_the_reference_in_place_of_a_policy_that_commands_nothing(
    tmp_path: Path,
) -> None:
    along = subject_of(tmp_path / "a", "hover", "--reference", "figure_eight:check=false")
    assert along.title == "hover along figure_eight  ·  episode 1 of 1  ·  seed 0"
    plain = subject_of(tmp_path / "b", "hover")
    assert plain.title == "hover  ·  episode 1 of 1  ·  policy hold  ·  seed 0"


def test_yaw_is_that_of_the_table(tmp_path: Path) -> None:
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
    assert attitude_degrees(both)[0, 2] == pytest.approx(np.degrees(heading))

    command = [PROGRAM, "run", "hover", "--out", tmp_path, "--no-picture", "--steps", "400"]
    along = "figure_eight:peak_speed=4,approach=0,ramp=0.01,yaw=tangent,check=false"
    done = subprocess.run(
        [*command, "--reference", along], check=True, capture_output=True, text=True, timeout=60
    )
    (track,) = Subject(Flight(tmp_path)).tracks
    assert track.angles is not None
    error = track.angles[:, 2] - track.goal_yaw()
    rows = done.stdout[done.stdout.index("reference of") :].splitlines()
    said = float(rows[2].split()[7])  # yaw RMS, after errors in position
    assert np.ptp(track.angles[:, :2]) > 20.0  # the body does tilt
    begin = 10  # steps of approach and ramp
    found = float(np.sqrt(np.mean(error[begin:] ** 2)))
    assert found == pytest.approx(said, abs=0.006)  # the table has two decimals


def test_the_smallest_distance_is_that_of_the_task(tmp_path: Path) -> None:
    subject = subject_of(tmp_path, "formation_learn")
    ((_, nearest, _),) = subject.infos("nearest_distance")
    values = separation(subject)
    assert values is not None
    assert values[1:] == pytest.approx(nearest[1:], abs=1e-6)
    assert separation(subject_of(tmp_path / "one", "hover")) is None


def test_a_landing_ends_at_height_0_with_its_speed(tmp_path: Path) -> None:
    subject = subject_of(tmp_path, "landing", "--policy", "shipped", steps=400)
    ((_, height),) = height_over_deck(subject)
    assert height[0] > 0.5
    assert height[-1] == pytest.approx(0.0, abs=0.02)  # legs and a tilted deck give way
    ((time, words),) = touch_down(subject)
    assert 0.0 < time <= subject.time[-1]
    speed = float(words.removeprefix("touch-down ").removesuffix(" m/s"))
    assert 0.0 < speed < 2.0  # the task's limit of a crash


def test_of_a_long_flight_some_rows_are_drawn_and_no_contact_is_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = subject_of(tmp_path, "collision", steps=150)
    monkeypatch.setattr("skybody.plot.subject.MOST_ROWS", 16)
    few = Subject(Flight(tmp_path))
    assert len(few.time) == len(few.bodies) == len(few.command) == 16
    assert few.time[-1] == whole.time[-1]
    ((begin, end),), ((first, last),) = few.touching, whole.touching
    assert begin <= first < last <= end  # shorter than the 0.1 s between two rows
    assert end - begin <= 0.2 + 1e-9
    figure = draw_page(few)
    plt.close(figure)


# --- rows -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scenario", "first"),
    [
        ("hover", ["error", "speed"]),
        ("racing", ["gates", "speed"]),
        ("payload", ["load", "swing"]),
        ("cooperative_payload", ["load", "tilt", "separation"]),
        ("formation_learn", ["formation", "separation"]),
        ("landing", ["height", "error"]),
        ("pendulum", ["upright"]),
        ("arm", ["tool", "joints"]),
        ("four_bar", ["joints"]),
    ],
)
def test_what_matters_for_a_task_comes_first(
    scenario: str, first: list[str], tmp_path: Path
) -> None:
    subject = subject_of(tmp_path, scenario)
    assert chosen(subject)[: len(first)] == first
    assert names_on_page(subject)[: len(first)] == first


def test_laps_are_marked_with_their_times(tmp_path: Path) -> None:
    subject = subject_of(tmp_path, "racing", "--policy", "shipped", steps=1000)
    laps = ROWS["gates"].marks(subject)
    assert len(laps) == 3
    assert laps[0][0] == pytest.approx(float(laps[0][1].split()[0]), abs=0.011)  # two decimals
    apart = laps[1][0] - laps[0][0]
    assert apart == pytest.approx(float(laps[1][1].split()[0]), abs=0.011)


# --- pictures -------------------------------------------------------------------------------------


def test_a_robot_with_joints_among_obstacles_is_drawn(tmp_path: Path) -> None:
    wall = "obstacles=[{name: wall, box: [0.1, 1, 1], position: [9, 9, 1]}]"
    done = plot(flown(tmp_path, "payload", "--set", wall))
    picture = tmp_path / "flight-0001.png"
    assert (done.returncode, done.stdout) == (0, f"picture {picture}\n"), done.stderr
    assert picture.stat().st_size > 50_000


def test_chosen_panels_are_drawn_as_pdf(tmp_path: Path) -> None:
    log = flown(tmp_path, "hover")
    done = plot(log, "--pdf", "--panels", "z,yaw,path", "--out", tmp_path / "drawn")
    picture = tmp_path / "drawn/flight-0001.pdf"
    assert (done.returncode, done.stdout) == (0, f"picture {picture}\n"), done.stderr
    assert picture.read_bytes().startswith(b"%PDF")
    assert [file.name for file in picture.parent.iterdir()] == [picture.name]


def test_for_a_paper_each_panel_is_a_pdf_and_an_svg_of_a_columns_width(tmp_path: Path) -> None:
    log = flown(tmp_path, "hover")
    more = ("--style", "paper", "--panels", "path,error", "--out")
    for folder in ("a", "b"):
        assert plot(log, *more, tmp_path / folder).returncode == 0
    stems = ("flight-0001-error", "flight-0001-path")
    names = [f"{stem}.{kind}" for stem in stems for kind in ("pdf", "svg")]
    assert sorted(file.name for file in (tmp_path / "a").iterdir()) == names
    for name in names:
        drawn = (tmp_path / "a" / name).read_bytes()
        assert drawn == (tmp_path / "b" / name).read_bytes(), "the same flight, the same file"
        if name.endswith("svg"):
            width = float(drawn.split(b'width="')[1].split(b'pt"')[0])
            assert width == pytest.approx(88.0 / 25.4 * 72.0, abs=1e-3)
        else:
            assert b"/Type3" not in drawn  # fonts of outlines, which journals refuse
    assert b"/CIDFontType2" in (tmp_path / "a/flight-0001-error.pdf").read_bytes()


def test_every_panel_is_drawn_also_where_a_flight_has_nothing_for_it(tmp_path: Path) -> None:
    for scenario in ("payload", "four_bar"):
        subject = subject_of(tmp_path / scenario, scenario)
        figure = draw_chosen(subject, list(PANELS))
        assert len(figure.axes) == len(PANELS)
        figure.savefig(tmp_path / "all.png", dpi=30)
        plt.close(figure)


def test_a_flight_whose_scenario_is_gone_has_its_curves(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("include: hover\nname: mine\n")
    log = flown(tmp_path, str(tmp_path / "mine.yaml"))
    (tmp_path / "mine.yaml").unlink()
    with h5py.File(log, "a") as file:
        file.attrs["scenario_text"] = "name: mine\nrobots: {quad: {model: gone.urdf}}\n"
    subject = Subject(Flight(log))
    assert "its scenario cannot be loaded any more" in subject.problem
    assert chosen(subject)[0] == "error"
    figure = draw_page(subject)
    assert "cannot be loaded" in " ".join(text.get_text() for text in figure.axes[0].texts)
    plt.close(figure)


def test_a_panel_of_a_team_says_its_robots(tmp_path: Path) -> None:
    figure = draw_for_paper(subject_of(tmp_path, "collision"), "x")
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["left", "right", "goal"]
    plt.close(figure)


# --- bad input ------------------------------------------------------------------------------------


def test_an_unknown_panel_is_an_error_with_the_list() -> None:
    done = plot(Path(__file__), "--panels", "z,jaw")
    assert (done.returncode, done.stdout) == (2, "")
    assert "error: --panels: no panel `jaw`; allowed: path, x, y, z, " in done.stderr


def test_pdf_and_paper_together_are_an_error(tmp_path: Path) -> None:
    done = plot(flown(tmp_path, "hover"), "--pdf", "--style", "paper")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "error: --pdf: --style paper writes PDF and SVG; leave --pdf out\n"


def test_a_log_says_where_its_scenario_lies_from_any_folder(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("include: hover\nname: mine\n")
    command = [PROGRAM, "run", "mine.yaml", "--out", "out", "--no-picture", "--steps", "3"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, timeout=60)
    with h5py.File(tmp_path / "out/flight.h5") as log:
        assert str(log.attrs["scenario_file"]) == str(tmp_path / "mine.yaml")


@pytest.mark.parametrize("kind", ["recording", "policy", "text", "folder", "nothing"])
def test_what_is_no_flight_log_is_one_message(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "file"
    if kind == "recording":
        command = [PROGRAM, "hash", "hover", "--envs", "1", "--steps", "3", "--record", file]
        subprocess.run(command, check=True, capture_output=True, timeout=60)
    elif kind == "policy":
        with h5py.File(file, "w") as written:
            written.attrs["format"] = "skybody-policy"
    elif kind == "folder":
        file.mkdir()
    elif kind == "text":
        file.write_text("text")
    done = plot(file)
    assert done.returncode == 2
    reasons = {
        "recording": "file: a recording of many environments has no flight; `skybody run` writes "
        "flight.h5",
        "policy": "file: is no flight log; `skybody run` writes flight.h5",
        "text": "file: cannot be read as a flight log (",
        "nothing": "file: no such file; `skybody run` writes flight.h5",
        "folder": "file/flight.h5: no such file; `skybody run` writes flight.h5",
    }
    assert done.stderr.startswith(f"error: {tmp_path}/{reasons[kind]}")
    assert done.stderr.count("\n") == 1


def test_a_missing_log_is_one_message() -> None:
    done = plot()
    assert done.returncode == 2
    assert done.stderr == "error: LOG[:EPISODE] is missing; see `skybody plot --help`\n"


def test_a_folder_that_cannot_be_written_is_one_message(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("a file")
    done = plot(flown(tmp_path / "log", "hover"), "--out", tmp_path / "out")
    assert done.returncode == 2
    assert done.stderr.startswith(f"error: {tmp_path}/out/flight-0001.png: cannot be written (")
    assert done.stderr.count("\n") == 1
