"""Betaflight's SITL: packets, and flights with a player of the other side."""

from __future__ import annotations

import json
import os
import random
import shutil
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from sitl_pilots import Array, HoldPilot, Kept
from skybody.sitl import betaflight, betaflight_link, betaflight_pilot
from skybody.sitl.__main__ import main
from skybody.sitl.betaflight_link import BetaflightLink
from skybody.sitl.betaflight_program import settings_for
from skybody.sitl.frames import HOME
from skybody.sitl.vehicle import Setup, Vehicle

ROOT = Path(__file__).resolve().parents[2]
FUZZED = 10_000
FIRMWARE = os.environ.get("SKYBODY_BETAFLIGHT", "")


def vehicle() -> Vehicle:
    return Vehicle("betaflight", Setup("hover_crazyflie"))


# --- packets ------------------------------------------------------------------------------------


def test_the_state_has_18_doubles_in_betaflights_frames() -> None:
    flying = vehicle()
    flying.simulation.teleport([0, 0, 9], velocity=[1, -2, 3], angular_velocity=[0.1, 0.2, 0.3])
    flying.advance(np.zeros(4), 100)
    reading = flying.read()
    values = struct.unpack("<18d", betaflight.encode_state(reading, HOME, 1.5))
    assert values[0] == 1.5
    x, y, z = reading.angular_rate
    assert values[1:4] == (x, -y, -z)  # FRD
    assert values[4:7] == tuple(-reading.specific_force)
    w, x, y, z = reading.rotation
    assert values[7:11] == (w, x, -y, -z)  # NED from FRD
    x, y, z = reading.fix_velocity
    assert values[11:14] == (-y, x, z)  # east, north, up
    latitude, longitude, altitude = HOME.place(reading.fix_position)
    assert values[14:18] == (longitude, latitude, altitude, reading.pressure)


def test_the_radio_has_a_time_and_16_channels_held_to_1000_to_2000_us() -> None:
    packet = betaflight.encode_radio(2.0, [1500.4, 900.0, 2500.0])
    assert struct.unpack("<d16H", packet) == (2.0, 1500, 1000, 2000, *[1000] * 13)


def test_motors_are_four_floats() -> None:
    assert betaflight.decode_motors(struct.pack("<4f", 0, 0.25, 0.5, 1)).tolist() == [
        0,
        0.25,
        0.5,
        1,
    ]
    for size in (0, 15, 17, 64):
        with pytest.raises(ValueError, match=f"{size} bytes"):
            betaflight.decode_motors(b"\x00" * size)


def test_random_packets_do_no_harm() -> None:
    link, generator = BetaflightLink(vehicle(), None, 1.0, Kept()), random.Random(9)
    taken = 0
    for _ in range(FUZZED):
        taken += link.take(generator.randbytes(generator.choice((0, 3, 15, 16, 16, 16, 17, 144))))
        assert ((link.throttles >= 0.0) & (link.throttles <= 1.0)).all()
        if generator.random() < 0.01:
            link.vehicle.advance(link.throttles, 1)
            link.state(link.vehicle.read())
    assert taken > FUZZED // 4
    kept = link.messages
    assert isinstance(kept, Kept) and len(kept.lines) == 2  # one of each kind


def test_settings_follow_from_the_frame() -> None:
    assert settings_for("x")[-2:] == ["mixer QUADX", "set yaw_motors_reversed = OFF"]
    assert settings_for("plus-reversed")[-2:] == ["mixer QUADP", "set yaw_motors_reversed = ON"]


# --- a player of Betaflight ---------------------------------------------------------------------


class FakeBetaflight:
    """Holds attitude by the state packets' rates and attitude, throttle and arming by the radio."""

    def __init__(self) -> None:
        self.console = socket.create_server(("127.0.0.1", 0))
        self.ports = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
        for port in self.ports:
            port.bind(("127.0.0.1", 0))
            port.settimeout(0.2)
        self.radio: tuple[float, ...] = (0.0,) * 17
        self.stamps: list[float] = []
        self.mute = 0  # states that are not answered
        self.ended = threading.Event()

    def motors(self, values: tuple[float, ...]) -> Array:
        armed, throttle = self.radio[5] > 1700, (self.radio[3] - 1000.0) / 1000.0
        if not armed:
            return np.zeros(4)
        pilot = HoldPilot(hover=max(throttle, 0.055) ** 2, height=0.0)
        return pilot.throttles(np.array(values[7:11]), np.array(values[1:4]), 0.0, 0.0)

    def run(self, motor_port: int) -> None:
        states, radio = self.ports
        states.settimeout(0.2)
        radio.setblocking(False)
        while not self.ended.is_set():
            try:
                values = struct.unpack("<18d", states.recv(4096))
            except TimeoutError:
                continue
            try:
                while True:
                    self.radio = struct.unpack("<d16H", radio.recv(4096))
            except BlockingIOError:
                pass
            self.stamps.append(values[0])
            if self.mute:
                self.mute -= 1
                continue
            packet = struct.pack("<4f", *self.motors(values))
            states.sendto(packet, ("127.0.0.1", motor_port))


@contextmanager
def fake(monkeypatch: pytest.MonkeyPatch, mute: int = 0) -> Iterator[FakeBetaflight]:
    """A player on ports of its own."""
    player = FakeBetaflight()
    player.mute = mute
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        motor_port = free.getsockname()[1]
    state_port, radio_port = (port.getsockname()[1] for port in player.ports)
    monkeypatch.setattr(betaflight_link, "MOTOR_PORT", motor_port)
    monkeypatch.setattr(betaflight_link, "STATE_PORT", state_port)
    monkeypatch.setattr(betaflight_link, "RADIO_PORT", radio_port)
    console = player.console.getsockname()[1]
    monkeypatch.setattr("skybody.sitl.betaflight_program.CONSOLE", console)
    thread = threading.Thread(target=player.run, args=(motor_port,), daemon=True)
    thread.start()
    yield player
    player.ended.set()
    thread.join(5.0)
    for port in (*player.ports, player.console):
        port.close()


def test_the_pilot_arms_takes_off_and_holds_the_height(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(betaflight_pilot, "GRACE", 0.5)
    with fake(monkeypatch):
        flying = vehicle()
        ground = flying.read().position[2]
        pilot = betaflight_pilot.HoldPilot(flying, 0.5)
        BetaflightLink(flying, pilot, 1e3, Kept()).serve(6.0, None)
    end = flying.read()
    assert pilot.armed
    assert end.position[2] - ground == pytest.approx(0.5, abs=0.2)  # about signs, not gains
    assert np.abs(end.turn_rate).max() < 0.05


def test_a_state_without_answer_is_repeated_with_a_later_stamp(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with fake(monkeypatch, mute=3) as player:
        link = BetaflightLink(vehicle(), None, 1e3, Kept())
        link.serve(0.02, None)
    assert np.diff(player.stamps[:4]) == pytest.approx([0.001] * 3)
    assert link.messages.counts["late answers"] == 3
    assert link.vehicle.time == pytest.approx(0.02)


def test_a_program_that_is_none_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["betaflight", "hover_crazyflie", "--shared-network", "--program", "no_such"]
    assert main(words) == 2
    assert "docs/sitl.md says how to build it" in capsys.readouterr().err


# --- the real one -------------------------------------------------------------------------------


def test_the_build_script_wants_a_folder() -> None:
    command = ["bash", str(ROOT / "scripts/build_betaflight.sh")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert "usage: scripts/build_betaflight.sh FOLDER" in done.stderr


@pytest.mark.skipif(not FIRMWARE, reason="set SKYBODY_BETAFLIGHT to Betaflight's SITL to fly it")
@pytest.mark.skipif(shutil.which("unshare") is None, reason="needs unshare")
def test_betaflight_itself_takes_off_and_hovers(tmp_path: Path) -> None:
    """`scripts/build_betaflight.sh` builds it."""
    command = [sys.executable, "-m", "research", "run", "betaflight_hold", "--quick"]
    done = subprocess.run(
        [*command, "--firmware", FIRMWARE, "--out", str(tmp_path)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    flight = json.loads((tmp_path / "data/betaflight_hold.json").read_text())["flights"][0]
    assert flight["largest_tilt"] < 30.0  # [deg]; the kick is 4 rad/s
    assert flight["height_error"] < 0.5  # [m]; of a take-off
