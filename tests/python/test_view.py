"""`skybody view` shows flights in a browser, and a simulation that can be changed."""

from __future__ import annotations

import gzip
import hashlib
import http.client
import json
import re
import signal
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, sync_playwright
from skybody import CompiledScenario
from skybody.look.flight import Flight
from skybody.view.live import Live, due_steps
from skybody.view.pack import Packer
from skybody.view.page import PAGE, Shown, document
from skybody.view.samples import chosen_rows, of_flight
from skybody.view.server import HOST, Server

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
CHROMIUM = "/usr/bin/chromium"
SOFTWARE_GRAPHICS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def skybody(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(PROGRAM), *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )


def flown(folder: Path, *arguments: object) -> Path:
    done = skybody("run", *arguments, "--no-picture", "--out", folder)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def racing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("racing")
    return flown(folder, "racing", "--policy", "shipped", "--steps", 150, "--episodes", 2)


@pytest.fixture(scope="module")
def ropes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return flown(tmp_path_factory.mktemp("ropes"), "cooperative_payload_ropes", "--steps", 60)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=SOFTWARE_GRAPHICS)
        yield started
        started.close()


class Tab:
    """A page in the browser, with all that its console said."""

    def __init__(self, browser: Browser, address: str) -> None:
        self.page: Page = browser.new_page(viewport={"width": 640, "height": 400})
        self.said: list[str] = []
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.goto(address)
        self.page.wait_for_function("globalThis.skybody !== undefined")

    def value(self, expression: str) -> Any:
        return self.page.evaluate(expression)

    def place(self, body: int = 0) -> list[float]:
        return list(self.value(f"[...skybody.stage.worlds[0].bodies[{body}].position]"))

    def seek(self, time: float) -> None:
        """Moves the slider as a hand would, and waits for a frame."""
        self.page.get_by_label("time").evaluate(
            "(slider, time) => { slider.value = time; slider.dispatchEvent(new Event('input')); }",
            time,
        )
        self.page.wait_for_function(f"Math.abs(skybody.player.time - {time}) < 0.01")
        self.value(
            "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )


# --- a page in the browser ----------------------------------------------------------------------


def test_a_page_plays_and_its_slider_moves_the_vehicle_as_the_log_says(
    browser: Browser, racing: Path
) -> None:
    assert skybody("view", racing).stdout == f"page     {racing / 'flight.html'}\n"
    tab = Tab(browser, (racing / "flight.html").as_uri())
    tab.page.wait_for_function("skybody.player.time > 0.1")  # it plays
    flight = Flight(racing)
    for time in (0.4, 1.2, 0.0):
        tab.seek(time)
        there, _ = flight.at(time)
        # The page has 50 rows a second: a chord of 8 m/s at 2 g lies within 1 mm of the way.
        np.testing.assert_allclose(tab.place(), there[0], atol=2e-3)
    assert tab.said == []
    tab.page.close()


def test_a_page_draws_a_picture_that_changes_with_the_view(browser: Browser, ropes: Path) -> None:
    assert skybody("view", ropes).returncode == 0
    tab = Tab(browser, (ropes / "flight.html").as_uri())
    tab.seek(0.3)
    pictures = set()
    for view in ("Orbit", "Follow", "Onboard"):
        tab.page.get_by_role("button", name=view).click()
        tab.value("new Promise((done) => requestAnimationFrame(() => setTimeout(done, 50)))")
        pictures.add(tab.page.locator("#stage canvas").screenshot())
    assert len(pictures) == 3
    assert min(map(len, pictures)) > 4000  # a PNG of one colour has 2,000 bytes
    assert tab.said == []
    tab.page.close()


def test_several_flights_are_shown_beside_each_other(
    browser: Browser, racing: Path, tmp_path: Path
) -> None:
    out = tmp_path / "two.html"
    assert skybody("view", racing, "-o", out).returncode == 0  # all episodes of a log
    tab = Tab(browser, out.as_uri())
    assert tab.value("skybody.stage.worlds.length") == 2
    tab.page.get_by_role("button", name="Side by side").click()
    assert tab.value("skybody.stage.apart")
    tab.page.get_by_label("episode 2").uncheck()
    assert tab.value("skybody.stage.shown") == [True, False]
    assert tab.said == []
    tab.page.close()


def test_a_run_shows_its_checkpoints_and_its_learning_curve(
    browser: Browser, tmp_path: Path
) -> None:
    run = tmp_path / "run"
    sizes = ("--total-steps", 20_000, "--checkpoint-every", 8_192)
    done = skybody("train", "hover_learn", *sizes, "--out", run, "--eval-episodes", 0)
    assert done.returncode == 0, done.stderr
    assert skybody("view", run).returncode == 0
    tab = Tab(browser, (run / "flight.html").as_uri())
    assert tab.value("skybody.stage.worlds.length") >= 2
    assert tab.page.get_by_text("Learning curve").count() == 1
    assert tab.said == []
    tab.page.close()


def test_train_ends_with_the_page_of_its_run_and_run_with_that_of_its_flight(
    tmp_path: Path,
) -> None:
    run, flight = tmp_path / "run", tmp_path / "flight"
    small = ("--total-steps", 4_000, "--checkpoint-every", 4_000, "--eval-episodes", 1)
    trained = skybody("train", "hover_learn", *small, "--out", run)
    assert trained.stdout.endswith(f"see it  {run / 'flight.html'}\n")
    assert (run / "flight.html").exists()
    done = skybody("run", "hover", "--steps", 20, "--no-picture", "--view", "--out", flight)
    assert done.stdout.endswith(f"page     {flight / 'flight.html'}\n")
    assert (flight / "flight.html").exists()


# --- the file -----------------------------------------------------------------------------------


def test_a_page_needs_no_network_and_is_small(racing: Path) -> None:
    text = document("racing", [Shown(of_flight(Flight(racing)), "racing")])
    assert not re.findall(r"(?:src|href)=\"(?!data:)", text)
    assert len(text) < 4e6


def test_a_minute_of_twenty_robots_takes_less_than_a_megabyte_of_the_page() -> None:
    time = np.arange(6001) * 0.01
    width = 20 * (7 + 4 + 4 + 3) + 40
    rows = chosen_rows(time, width)
    random = np.random.default_rng(1)
    packer = Packer()
    packer.add(np.cumsum(random.normal(size=(len(rows), width)), axis=0))
    assert len(packer.text()) < 1e6
    assert rows[0] == 0
    assert rows[-1] == 6000


def test_arrays_come_back_to_one_part_in_65534_of_their_range() -> None:
    values = np.array([[0.0, 5.0], [1.0, np.nan], [-3.0, 5.0]])
    packer = Packer()
    spec = packer.add(values)
    assert (spec["rows"], spec["columns"]) == (3, 2)
    assert spec["low"] == [-3.0, 5.0]
    assert spec["step"][0] == pytest.approx(4.0 / 65534)
    assert spec["step"][1] == 0.0


def test_three_js_is_that_of_npm() -> None:
    wanted = {
        "three.core.js.gz": "613e370f76638fdef83926642bf256dc9615684922de1ce1f63a8583e5d78578",
        "three.module.js.gz": "104f56145899722094556490d787aae0617cc2fc3382f31df02d724ea1aee341",
        "OrbitControls.js.gz": "e7fca2fe9e7670a828af9b28084669a5909445b7f36f1f26cee9bf8f2961c32c",
    }
    for name, digest in wanted.items():
        content = gzip.decompress((PAGE / "three" / name).read_bytes())
        assert hashlib.sha256(content).hexdigest() == digest


# --- a running simulation -----------------------------------------------------------------------


@pytest.fixture
def server() -> Iterator[Server]:
    live = Live(CompiledScenario("hover", ["randomization=~"]), "hold", 0)
    made = Server(live, 0)
    live.start()
    thread = threading.Thread(target=made.serve_forever, daemon=True)
    thread.start()
    yield made
    made.shutdown()
    live.close()
    made.server_close()


AWAY = (
    "Math.hypot(...[0, 1, 2].map((k) => skybody.live.state.poses[k] - skybody.live.state.goals[k]))"
)
SEEN = (
    "(() => { const [x, y] = skybody.stage.seen(0);"
    "const box = skybody.stage.renderer.domElement.getBoundingClientRect();"
    "return [box.left + x * box.width, box.top + y * box.height]; })()"
)


def test_a_drag_pushes_the_robot_and_it_comes_back(browser: Browser, server: Server) -> None:
    tab = Tab(browser, server.address)
    tab.page.wait_for_function(f"{AWAY} < 0.02")  # it hovers at its goal
    x, y = tab.value(SEEN)
    tab.page.mouse.move(x, y)
    tab.page.mouse.down()
    tab.page.mouse.move(x + 60, y, steps=3)
    tab.page.wait_for_function(f"{AWAY} > 0.06")
    tab.page.mouse.up()
    tab.page.wait_for_function(f"{AWAY} < 0.02")
    assert tab.said == []
    tab.page.close()


def post(server: Server, change: object, **headers: str) -> tuple[int, str]:
    connection = http.client.HTTPConnection(HOST, server.server_port, timeout=10)
    connection.request("POST", "/change", json.dumps(change), headers)
    reply = connection.getresponse()
    return reply.status, reply.read().decode()


def test_a_simulation_pauses_steps_resets_and_takes_parameters(server: Server) -> None:
    states = server.live.states()
    next(state for state in states if state["time"] > 0.1)
    assert post(server, {"pause": True})[0] == 200
    stopped = next(state for state in states if state["paused"])
    later = next(state for state in states)
    assert later["time"] == next(states)["time"]
    assert post(server, {"step": 5})[0] == 200
    period = server.live.compiled.dt * server.live.compiled.action_repeat
    stepped = next(state for state in states if state["time"] > later["time"])
    assert stepped["time"] == pytest.approx(later["time"] + 5 * period, abs=1e-9)
    mass = "robots.quad.links.base_link.mass"
    assert post(server, {"param": mass, "value": 2.0})[0] == 200
    assert post(server, {"reset": True})[0] == 200
    assert next(s for s in states if s["episode"] > stopped["episode"])["time"] < 0.1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({}, "a change has one of pause, step, reset, speed, param, pull"),
        ({"speed": 1e9}, "is no number in 0.01..20"),
        ({"pull": 99, "along": [0, 0, 0]}, "is no number in 0..0"),
        ({"pull": 0, "along": [0, 0]}, "`along` has three numbers"),
        ({"param": "robots.quad.links.base_link.mass", "value": -1}, "is no number in 1e-12..inf"),
        ({"param": "no.such", "value": 1}, "no.such"),
        ([1], "a change is a map"),
    ],
)
def test_a_wrong_change_is_refused_with_its_reason(
    server: Server, change: object, message: str
) -> None:
    status, said = post(server, change)
    assert status == 400
    assert message in said


def test_pages_of_other_sites_may_not_change_the_simulation(server: Server) -> None:
    assert post(server, {"reset": True}, Origin="http://example.org")[0] == 403
    assert post(server, {"reset": True}, Host="example.org")[0] == 403


def test_pages_of_other_sites_may_not_frame_the_page(server: Server) -> None:
    connection = http.client.HTTPConnection(HOST, server.server_port, timeout=10)
    connection.request("GET", "/")
    assert connection.getresponse().headers["X-Frame-Options"] == "DENY"


def test_a_pause_makes_all_steps_of_a_request(server: Server) -> None:
    states = server.live.states()
    assert post(server, {"pause": True})[0] == 200
    stopped = next(state for state in states if state["paused"])
    assert post(server, {"step": 1000})[0] == 200
    stepped = next(state for state in states if state["time"] > stopped["time"])
    period = server.live.compiled.dt * server.live.compiled.action_repeat
    assert stepped["time"] == pytest.approx(stopped["time"] + 1000 * period, abs=1e-5)


def test_a_slow_machine_drops_the_time_that_it_cannot_fly() -> None:
    assert due_steps(0.0351, 0.01, 1.0) == (3, pytest.approx(0.0051))
    assert due_steps(60.0, 0.01, 1.0) == (20, 0.0)
    assert due_steps(0.3, 0.5, 0.01) == (0, 0.3)


def test_an_error_of_the_flight_reaches_the_page(
    server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise ValueError("no policy")

    monkeypatch.setattr(server.live, "_advance", fail)
    states = server.live.states()
    assert next(state for state in states if state["text"])["text"] == "stopped: no policy"


def test_ctrl_c_ends_a_page_that_a_browser_shows_with_one_line(browser: Browser) -> None:
    command = [str(PROGRAM), "view", "--live", "hover"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        address = process.stdout.readline().split()[1]
        tab = Tab(browser, address)
        tab.page.wait_for_function("skybody.live.state.time > 0.1")
        process.send_signal(signal.SIGINT)
        _, message = process.communicate(timeout=60)
    tab.page.close()
    assert (process.returncode, message) == (130, "interrupted\n")


# --- errors -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "error: needs flights or a training run, or --live SCENARIO, and not both; "),
        (["--live", "hover", "none.h5"], "error: needs flights or a training run, or --live"),
        (["--live", "hvoer"], "did you mean `hover`?"),
        (["--live", "hover", "--policy", "none"], "none"),
        (["missing.h5"], "error: missing.h5: no such file; `skybody run` writes flight.h5"),
    ],
)
def test_a_wrong_command_is_one_error(arguments: list[str], message: str, tmp_path: Path) -> None:
    done = skybody("view", *arguments)
    assert done.returncode == 2
    assert message in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_page_that_cannot_be_written_is_one_error(racing: Path) -> None:
    done = skybody("view", racing, "-o", "/proc/none/page.html")
    assert done.returncode == 2
    assert re.fullmatch(r"error: .*/proc/none/page.html: cannot be written \(.*\)\n", done.stderr)
