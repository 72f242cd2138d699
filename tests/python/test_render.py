"""`skybody render` draws the flights of a log as they were."""

from __future__ import annotations

import base64
import io
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from skybody import InputError
from skybody.look.cameras import CAMERAS, camera
from skybody.look.couplings import hanging
from skybody.look.film import Film, Panel, Size
from skybody.look.flight import Flight
from skybody.look.scene import Scene, Style

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
SMALL = Size(width=160, height=96, rate=10.0)
PLAIN = Style(trail=0.0, goal=False)

Render = Callable[..., subprocess.CompletedProcess[str]]


def skybody(*arguments: str, **more: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(PROGRAM), *arguments],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
        env=more or None,
    )


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A log of each of some scenarios."""
    found = {}
    for name in ("racing", "cooperative_payload_ropes", "arm"):
        folder = tmp_path_factory.mktemp(name)
        done = skybody("run", name, "--steps", "40", "--no-picture", "--out", str(folder))
        assert done.returncode == 0, done.stderr
        found[name] = folder / "flight.h5"
    return found


def picture(scene: Scene, time: float, view: str = "fixed") -> NDArray[np.uint8]:
    film = Film([Panel((scene,), view, 0, 0, SMALL.width, SMALL.height)], SMALL)
    return film.frame(time)


# --- pictures -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["racing", "cooperative_payload_ropes", "arm"])
@pytest.mark.parametrize("view", sorted(CAMERAS))
def test_every_camera_draws_the_same_picture_twice(
    logs: dict[str, Path], name: str, view: str
) -> None:
    first = picture(Scene(Flight(logs[name])), 0.3, view)
    assert first.std() > 5.0  # not of one colour
    np.testing.assert_array_equal(first, picture(Scene(Flight(logs[name])), 0.3, view))


def test_a_vehicle_is_drawn_where_it_is(
    logs: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    flight = Flight(logs["racing"])
    scene = Scene(flight, PLAIN)
    with_vehicle = picture(scene, 0.4)
    monkeypatch.setattr(scene, "add_robots", lambda shapes, time: None)  # the world alone
    changed = np.argwhere((with_vehicle != picture(scene, 0.4)).any(axis=2))
    view = camera("fixed", [Scene(flight, PLAIN)], SMALL.field_of_view)(0.4)
    ahead = view.axes.T @ (flight.at(0.4)[0][0] - view.eye)
    focal = 0.5 * SMALL.width / np.tan(0.5 * SMALL.field_of_view)
    at = focal * ahead[:2] / ahead[2] + [SMALL.width / 2, SMALL.height / 2]
    nearest = np.linalg.norm(changed[:, ::-1] + 0.5 - at, axis=1).min()
    assert nearest < 1.5  # pixels: the base's box is about its origin


@pytest.mark.parametrize("name", ["fixed", "orbit"])
def test_a_camera_of_two_flights_in_a_world_sees_the_vehicles_of_both(
    logs: dict[str, Path], name: str
) -> None:
    scenes = [Scene(Flight(logs[log]), PLAIN) for log in ("racing", "arm")]  # 4 m apart
    tangents = np.tan(0.5 * SMALL.field_of_view) * np.array([1.0, 0.6])
    view = camera(name, scenes, SMALL.field_of_view, 0.6)(0.4)
    for scene in scenes:
        ahead = view.axes.T @ (scene.flight.at(0.4)[0][0] - view.eye)
        assert ahead[2] > 0.0
        assert (np.abs(ahead[:2] / ahead[2]) < tangents).all()


def test_gates_are_drawn_where_the_episode_has_them(logs: dict[str, Path]) -> None:
    flight = Flight(logs["racing"])
    scene = Scene(flight, PLAIN)
    gates = [shape for shape in scene.obstacles if shape.color[0] > 0.9]
    assert len(gates) == 5 * 4  # bars
    drawn = [flight.drawn[f"obstacles.gate_1.position[{k}]"] for k in range(3)]
    middle = np.mean([bar.position for bar in gates[:4]], axis=0)
    np.testing.assert_allclose(middle, drawn, atol=1e-12)
    assert not np.allclose(drawn, flight.compiled.obstacles[0].position)  # it was moved


def test_ropes_hang_between_their_ends(logs: dict[str, Path]) -> None:
    a, b = np.array([0.0, 0.0, 2.0]), np.array([0.6, 0.0, 2.0])
    assert len(hanging(a[None], b[None], [0.6])[0]) == 2  # taut
    for length in (0.61, 0.7, 1.0, 2.0):
        points = hanging(a[None], b[None], [length])[0]
        np.testing.assert_array_equal(points[[0, -1]], [a, b])
        drawn = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        assert abs(drawn - length) < 1e-6 * length  # 30 halvings of the sag
        assert points[:, 2].min() < 2.0
    shapes = Scene(Flight(logs["cooperative_payload_ropes"]), PLAIN)
    assert len(shapes.couplings.names) == len(shapes.flight.compiled.couplings) > 0


def test_poses_between_rows_are_between_them(logs: dict[str, Path]) -> None:
    flight = Flight(logs["racing"])
    for row in (0, 7, 39):
        position, axes = flight.at(float(flight.time[row]))
        np.testing.assert_allclose(position, flight.bodies[row, :, :3], atol=1e-12)
        np.testing.assert_allclose(axes[0] @ axes[0].T, np.eye(3), atol=1e-12)
    half = flight.at(float(flight.time[7:9].mean()))[0]
    np.testing.assert_allclose(half, flight.bodies[7:9, :, :3].mean(axis=0), atol=1e-12)


# --- files --------------------------------------------------------------------------------------


def frames_of(path: Path) -> int:
    with Image.open(path) as image:
        return int(getattr(image, "n_frames", 1))


def test_films_have_the_frames_of_their_time(logs: dict[str, Path], tmp_path: Path) -> None:
    log, options = str(logs["racing"]), ["--size", "128x96", "--rate", "10"]
    for name in ("film.gif", "film.webp"):
        done = skybody("render", log, "-o", str(tmp_path / name), *options, "--to", "0.5")
        assert (done.returncode, done.stdout) == (0, f"film     {tmp_path / name}\n"), done.stderr
        assert frames_of(tmp_path / name) == 6  # 0, 0.1, ... 0.5 s
    still = tmp_path / "still.png"
    plots = ["--plot", "speed,gates_passed", "--camera", "chase,onboard", "--thrust"]
    done = skybody("render", log, log, "-o", str(still), *options, "--at", "0.4", *plots)
    assert done.returncode == 0, done.stderr
    assert frames_of(still) == 1
    folder = tmp_path / "frames"
    assert skybody("render", log, "-o", str(folder), *options, "--to", "0.2").returncode == 0
    assert len(list(folder.glob("frame_*.png"))) == 3
    assert not list(tmp_path.glob(".*"))  # nothing half-written


def test_a_video_has_the_same_bytes_in_two_runs(logs: dict[str, Path], tmp_path: Path) -> None:
    options = ["--size", "128x96", "--rate", "10", "--to", "0.5", "--ghost"]
    for name in ("a.mp4", "b.mp4"):
        done = skybody("render", *[str(logs["arm"])] * 2, "-o", str(tmp_path / name), *options)
        assert done.returncode == 0, done.stderr
    first = (tmp_path / "a.mp4").read_bytes()
    assert len(first) > 1000
    assert first == (tmp_path / "b.mp4").read_bytes()


def test_frames_are_the_same_by_any_number_of_threads(
    logs: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = Panel((Scene(Flight(logs["racing"])),), "orbit", 0, 0, SMALL.width, SMALL.height)
    times = np.linspace(0.0, 0.8, 12).tolist()
    found = []
    for threads in (1, 5):
        monkeypatch.setattr("os.cpu_count", lambda count=threads: count)
        found.append(np.array(list(Film([whole], SMALL).frames(times))))
    np.testing.assert_array_equal(found[0], found[1])


def test_ctrl_c_leaves_nothing_half_written(logs: dict[str, Path], tmp_path: Path) -> None:
    command = [str(PROGRAM), "render", str(logs["racing"]), "-o", str(tmp_path / "film.webp")]
    slow = ["--speed", "0.01"]  # some thousand frames
    with subprocess.Popen([*command, *slow], stderr=subprocess.PIPE, text=True) as process:
        for _ in range(600):  # until the first bytes are written
            if list(tmp_path.iterdir()) or process.poll() is not None:
                break
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        _, message = process.communicate(timeout=60)
    assert (process.returncode, message) == (130, "interrupted\n")
    assert not list(tmp_path.iterdir())


# --- bad input ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--camera", "drone"], "no camera `drone`; there are: chase, fixed, orbit, onboard"),
        (["--size", "101x96"], "--size is 101x96; allowed: even numbers, 64x64 to 3840x2160"),
        (["--size", "big"], "--size is `big`; allowed: WIDTHxHEIGHT, such as 1280x720"),
        (["--rate", "0"], "--rate is 0; allowed: 1 to 120"),
        (["--from", "nan"], "--from is nan; allowed: 0 to 1e+09"),
        (["--trail", "nan"], "--trail is nan; allowed: 0 to 1e+09"),
        (["--plot", "sped"], "no value `sped`; there are: reward, gates_passed"),
        (["--hide", "goals"], "--hide goals: unknown; allowed: goal, reference, contacts"),
        (["--from", "9"], "no frames between --from 9 and --to"),
        (["--at", "99"], "--at is 99; the flight ends at 0.8 s"),
        (["-o", "film.avi"], "film.avi: unknown ending `.avi`; allowed: .mp4, .gif, .webp, .png"),
        (["-o", "/proc/none/film.gif"], "/proc/none/film.gif: cannot be written"),
    ],
)
def test_wrong_options_are_errors(
    logs: dict[str, Path], tmp_path: Path, options: list[str], message: str
) -> None:
    out = tmp_path / "film.gif"
    done = skybody("render", str(logs["racing"]), "-o", str(out), "--size", "128x96", *options)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr
    assert not out.exists()


def test_files_that_are_no_flight_logs_are_errors(logs: dict[str, Path], tmp_path: Path) -> None:
    text, other = tmp_path / "text.h5", tmp_path / "other.h5"
    text.write_text("no log")
    with h5py.File(other, "w") as file:
        file.attrs["format"] = "another"
    cut = tmp_path / "cut.h5"
    cut.write_bytes(logs["racing"].read_bytes()[:4000])
    for path in (text, other, cut, tmp_path / "none.h5"):
        done = skybody("render", str(path), "-o", str(tmp_path / "film.gif"))
        assert done.returncode == 2, path
        assert done.stderr.startswith(f"error: {path}: "), done.stderr
    without = tmp_path / "without.h5"
    without.write_bytes(logs["racing"].read_bytes())
    with h5py.File(without, "r+") as file:
        del file["episodes/0001/bodies"]
    with pytest.raises(InputError, match=r"without.h5: episode 1 has no bodies to draw"):
        Flight(without)
    with pytest.raises(InputError, match="no episode 7; it has 1"):
        Flight(logs["racing"], 7)


def test_without_ffmpeg_the_message_has_the_remedy_and_pictures_still_come(
    logs: dict[str, Path], tmp_path: Path
) -> None:
    (tmp_path / "imageio_ffmpeg.py").write_text("raise ImportError")  # its package has one, too
    paths = os.pathsep.join([str(tmp_path), str(ROOT / "python")])
    environment = {"PATH": "", "PYTHONPATH": paths}

    def render(out: str) -> subprocess.CompletedProcess[str]:
        options = [str(logs["racing"]), "-o", out, "--size", "128x96", "--to", "0.1"]
        command = [sys.executable, "-m", "skybody.look", *options]
        return subprocess.run(
            command, capture_output=True, text=True, check=False, cwd=tmp_path, env=environment
        )

    done = render("film.mp4")
    assert done.returncode == 2
    assert done.stderr.startswith("error: an MP4 needs ffmpeg: `pip install imageio-ffmpeg`")
    assert "folder of PNG files" in done.stderr
    assert render("frames").returncode == 0
    assert sorted(path.name for path in (tmp_path / "frames").iterdir()) == [
        f"frame_{k:06d}.png"
        for k in range(4)  # 0, 1/30, ... 0.1 s
    ]
    assert not list(tmp_path.glob("*.mp4"))


def test_a_flight_whose_scenario_has_changed_is_drawn_by_its_own_text(
    logs: dict[str, Path], tmp_path: Path
) -> None:
    folder = tmp_path / "own"
    own = tmp_path / "own.yaml"
    own.write_text("include: racing.yaml\nname: own\n")
    done = skybody("run", str(own), "--steps", "5", "--no-picture", "--out", str(folder))
    assert done.returncode == 0, done.stderr
    own.unlink()
    assert [shape.kind for shape in Flight(folder).compiled.obstacles] == ["gate"] * 5


# --- notebooks ----------------------------------------------------------------------------------


class Elements(HTMLParser):
    """Tags of a page with their attributes, and its text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: dict[str, dict[str, str | None]] = {}
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found[tag] = dict(attrs)

    def handle_data(self, data: str) -> None:
        self.text += data


def test_a_flight_shows_itself_in_a_notebook(
    logs: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    from skybody.look import Flight as Shown
    from skybody.look import embed

    for has_ffmpeg, tag, begins in ((True, "video", b"ftyp"), (False, "img", b"WEBP")):
        monkeypatch.setattr(embed, "has_ffmpeg", lambda has=has_ffmpeg: has)
        page = Elements(Shown(logs["racing"])._repr_html_())
        source = page.found[tag]["src"] or ""
        film = base64.b64decode(source.partition("base64,")[2])
        assert begins in film[:16]
        assert len(film) < 2_000_000
        assert page.text == "racing, episode 1, 0.8 s"
    with Image.open(io.BytesIO(film)) as image:
        assert image.size == (480, 270)
        assert image.n_frames == 21  # 0, 0.04, ... 0.8 s


def test_a_long_flight_is_shown_faster_and_in_part(
    logs: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    from skybody.look import embed

    shown: list[float] = []

    def film_of(flight: Flight, times: NDArray[np.float64]) -> str:
        shown.extend(times)
        return ""

    monkeypatch.setattr(embed, "film_of", film_of)
    flight = Flight(logs["racing"])
    flight.time = 100.0 * flight.time / flight.time[-1]
    assert "100 s; 4 times as fast; the first 40 s" in embed.html_of(flight)
    assert shown[-1] == pytest.approx(40.0)
    assert len(shown) == 251  # 10 s, 25 frames per second


def test_a_notebook_shows_the_error_of_a_flight_that_cannot_be_drawn(
    logs: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    from skybody.look import embed

    def scene(flight: Flight) -> None:
        raise InputError("no <mesh>")

    monkeypatch.setattr(embed, "Scene", scene)
    assert "<pre>no &lt;mesh&gt;</pre>" in Flight(logs["racing"])._repr_html_()
