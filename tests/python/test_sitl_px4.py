"""PX4's simulator MAVLink: pymavlink plays the autopilot."""

from __future__ import annotations

import random
import socket
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink
from sitl_pilots import HoldPilot, Kept
from skybody.sitl.__main__ import main
from skybody.sitl.frames import HOME
from skybody.sitl.px4 import (
    ARMED,
    FIELD_FIELDS,
    IMU_FIELDS,
    LOCKSTEP,
    PRESSURE_FIELDS,
    Decoder,
    Encoder,
    controls_of,
)
from skybody.sitl.px4_link import Px4Link
from skybody.sitl.vehicle import Setup, Vehicle

FUZZED = 10_000
SECONDS = 5.0


def controls(values: list[float], mode: int = ARMED, flags: int = LOCKSTEP, stamp: int = 0) -> Any:
    sender = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    whole = values + [0.0] * (16 - len(values))
    message = sender.hil_actuator_controls_encode(stamp, whole, mode, flags)
    return bytes(message.pack(sender)), message


def decoded(packet: bytes) -> list[Any]:
    return list(mavlink.MAVLink(None).parse_buffer(packet))


def vehicle() -> Vehicle:
    return Vehicle("px4", Setup("hover_crazyflie"))


# --- messages -----------------------------------------------------------------------------------


def test_sensors_are_in_frd_gauss_and_hectopascal() -> None:
    flying = vehicle()
    flying.advance(np.zeros(4), 1000)
    reading = flying.read()
    (message,) = decoded(Encoder(mavlink, HOME).sensor(reading, 1_000_000, IMU_FIELDS))
    assert (message.get_type(), message.time_usec) == ("HIL_SENSOR", 1_000_000)
    assert message.zacc == pytest.approx(-9.81, abs=1e-3)
    x, y, z = reading.field / 100.0
    assert [message.xmag, message.ymag, message.zmag] == pytest.approx([x, -y, -z])
    assert message.zmag == pytest.approx(0.44)  # 44 uT down
    assert message.abs_pressure == pytest.approx(reading.pressure / 100.0)
    assert message.pressure_alt == pytest.approx(HOME.altitude, abs=0.1)
    assert message.fields_updated == IMU_FIELDS


def test_the_fix_is_in_1e_7_degrees_millimetres_and_centimetres_a_second() -> None:
    flying = vehicle()
    flying.simulation.teleport([10.0, -20.0, 30.0], velocity=[3.0, -4.0, 1.0])
    flying.advance(np.zeros(4), 100)  # the period of the GNSS
    (message,) = decoded(Encoder(mavlink, HOME).fix(flying.read(), 1))
    assert message.get_type() == "HIL_GPS" and message.fix_type == 3
    assert message.lat == pytest.approx(HOME.latitude * 1e7 + 10.3 / 111.2e-4, abs=30)
    assert message.lon > HOME.longitude * 1e7
    assert message.alt == pytest.approx((HOME.altitude + 30.0) * 1e3, abs=200)
    assert (message.vn, message.ve) == pytest.approx((300, 400), abs=5)
    assert message.vel == pytest.approx(500, abs=5)
    assert message.cog == pytest.approx(5313, abs=30)


def test_the_true_state_is_ned_from_frd() -> None:
    flying = vehicle()
    reading = flying.read()
    (message,) = decoded(Encoder(mavlink, HOME).truth(reading, 1))
    w, x, y, z = reading.rotation
    assert message.get_type() == "HIL_STATE_QUATERNION"
    assert message.attitude_quaternion == pytest.approx([w, x, -y, -z])


def test_speeds_beyond_a_message_are_held() -> None:
    flying = vehicle()
    flying.simulation.teleport([0.0, 0.0, 5.0], velocity=[4e4, 0.0, 0.0])
    (message,) = decoded(Encoder(mavlink, HOME).truth(flying.read(), 1))
    assert message.vx == 32767 and message.ind_airspeed == 65535


@pytest.mark.parametrize(
    ("values", "mode", "throttles", "bad"),
    [
        ([0.0, 0.5, 1.0, 2.0], ARMED, [0.0, 0.5, 1.0, 1.0], 0),
        ([0.5] * 4, 0, [0.0] * 4, 0),  # disarmed
        ([-1.0, -0.5, 0.25, 0.5], ARMED, [0.0, 0.0, 0.25, 0.5], 0),
        ([float("nan"), float("inf"), 0.5, 0.5], ARMED, [0.0, 0.0, 0.5, 0.5], 2),
        ([float("nan")] * 4, 0, [0.0] * 4, 0),
    ],
)
def test_controls_from_0_to_1_are_throttles_of_an_armed_autopilot(
    values: list[float], mode: int, throttles: list[float], bad: int
) -> None:
    found = controls_of(controls(values, mode)[1], 4)
    assert found.throttles.tolist() == throttles
    assert (found.armed, found.bad) == (mode == ARMED, bad)


def test_messages_are_found_in_pieces_between_other_bytes() -> None:
    packet, _ = controls([0.5] * 4)
    decoder = Decoder(mavlink)
    found = [len(decoder.take(part)) for part in (b"junk", packet[:20], packet[20:] + packet)]
    assert found == [0, 0, 2]
    assert decoder.bad > 0


def test_random_bytes_do_no_harm() -> None:
    link, generator = Px4Link(vehicle(), Kept()), random.Random(7)
    found = 0
    for _ in range(FUZZED):
        values = [generator.choice((0.5, -1.0, float("nan"), 1e30)) for _ in range(4)]
        packet = bytearray(controls(values, generator.randrange(256), generator.randrange(2))[0])
        for _ in range(generator.choice((0, 0, 0, 1, 3))):
            packet[generator.randrange(len(packet))] = generator.randrange(256)
        if generator.random() < 0.2:
            packet = bytearray(generator.randbytes(generator.randrange(1, 300)))
        if generator.random() < 0.2:
            del packet[generator.randrange(len(packet)) :]
        found += link.incoming(bytes(packet))
    assert 100 < found < FUZZED
    kept = link.messages
    assert isinstance(kept, Kept)
    assert Counter(line.partition(" ")[0] for line in kept.lines)["warning:"] <= 3


def test_controls_for_an_earlier_sensor_message_are_no_answer() -> None:
    link = Px4Link(vehicle(), Kept())
    assert link.incoming(controls([0.1] * 4, stamp=4000)[0])
    for _ in range(2):
        link.vehicle.advance(np.zeros(4), 4)
        link.outgoing()
    assert not link.incoming(controls([0.1] * 4, stamp=4000)[0])
    assert link.incoming(controls([0.1] * 4, stamp=8000)[0])
    assert link.incoming(controls([0.1] * 4, flags=0, stamp=4000)[0])  # its clock is its own


# --- flights ------------------------------------------------------------------------------------


class FakePx4:
    """Flies by HIL_SENSOR's gyro and by HIL_STATE_QUATERNION; counts messages."""

    def __init__(self, port: int) -> None:
        self.link = socket.create_connection(("127.0.0.1", port), timeout=20.0)
        self.link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.parser = mavlink.MAVLink(None)
        self.counts: Counter[str] = Counter()
        self.fields: Counter[int] = Counter()
        self.stamps: list[int] = []
        self.pilot = HoldPilot(hover=0.787, height=1.0)
        self.truth: Any = None

    def read(self) -> bool:
        """Reads to the next HIL_SENSOR; False at the end of the flight."""
        while True:
            try:
                data = self.link.recv(65536)
            except ConnectionError:
                return False
            if not data:
                return False
            messages = self.parser.parse_buffer(data) or []
            for message in messages:
                self.counts[message.get_type()] += 1
                if message.get_type() == "HIL_STATE_QUATERNION":
                    self.truth = message
            if messages and messages[-1].get_type() == "HIL_SENSOR":
                self.sensor = messages[-1]
                self.stamps.append(self.sensor.time_usec)
                for bits in (IMU_FIELDS, FIELD_FIELDS, PRESSURE_FIELDS):
                    self.fields[bits] += self.sensor.fields_updated & bits == bits
                return True

    def throttles(self) -> list[float]:
        rates = np.array([self.sensor.xgyro, self.sensor.ygyro, self.sensor.zgyro])
        height = self.truth.alt / 1e3 - HOME.altitude
        attitude = np.array(self.truth.attitude_quaternion)
        return self.pilot.throttles(attitude, rates, height, -self.truth.vz / 100.0).tolist()

    def finish(self) -> None:
        """Answers with idle motors until the flight is over."""
        try:
            self.send([0.0] * 4)
            while self.read():
                self.send([0.0] * 4)
        except ConnectionError:
            pass
        self.link.close()

    def send(self, values: list[float], mode: int = ARMED) -> None:
        self.link.sendall(controls(values, mode)[0])


@contextmanager
def served(seconds: float) -> Iterator[tuple[Px4Link, int, threading.Thread]]:
    """A link on a thread of its own, and its port."""
    link = Px4Link(vehicle(), Kept())
    thread = threading.Thread(target=link.serve, args=(0, seconds), daemon=True)
    thread.start()
    kept = link.messages
    assert isinstance(kept, Kept)
    yield link, kept.port(), thread


def flown(silent: float = 0.0) -> tuple[str, FakePx4, Px4Link]:
    """A flight of SECONDS; the autopilot boots for some seconds on the wall."""
    with served(SECONDS) as (link, port, thread):
        px4 = FakePx4(port)
        end = time.monotonic() + silent
        while time.monotonic() < end:
            px4.read()
        px4.read()
        px4.send([0.0] * 4, mode=0)  # up, and disarmed
        while px4.read():
            try:
                px4.send(px4.throttles())
            except ConnectionError:
                break
        thread.join(20.0)
        assert not thread.is_alive()
        px4.link.close()
    return link.vehicle.hash(), px4, link


def test_an_autopilot_takes_off_the_same_in_two_runs_however_long_it_boots() -> None:
    first, px4, link = flown()
    again, _, _ = flown(silent=0.2)
    end = link.vehicle.read()
    assert end.position[2] == pytest.approx(1.0, abs=0.2)  # about signs, not gains
    assert np.abs(end.turn_rate).max() < 0.05
    assert first == again
    periods = set(np.diff(px4.stamps[10:]).tolist())
    assert periods == {4000}  # 250 Hz [us]
    rates = {name: count / SECONDS for name, count in px4.counts.items()}
    # within two messages of the boot and of the first sample
    assert rates["HIL_SENSOR"] == pytest.approx(250.0, abs=1.0)
    assert rates["HIL_GPS"] == pytest.approx(10.0, abs=0.5)
    assert rates["HIL_STATE_QUATERNION"] == pytest.approx(50.0, abs=0.5)
    assert rates["HEARTBEAT"] == rates["SYSTEM_TIME"] == pytest.approx(1.0, abs=0.3)
    assert px4.fields[FIELD_FIELDS] / SECONDS == pytest.approx(100.0, abs=1.0)
    assert px4.fields[PRESSURE_FIELDS] / SECONDS == pytest.approx(50.0, abs=1.0)


def test_the_simulation_is_blocked_until_controls_come() -> None:
    with served(0.1) as (link, port, thread):
        px4 = FakePx4(port)
        px4.read()
        px4.send([0.0] * 4)
        px4.read()
        px4.send([0.0] * 4)
        while not link.locked or link.vehicle.steps == 0:
            time.sleep(0.01)
        time.sleep(0.1)
        before = link.vehicle.steps
        time.sleep(0.2)
        assert link.vehicle.steps == before
        px4.finish()
        thread.join(20.0)


def test_after_an_autopilot_that_goes_away_the_next_one_flies() -> None:
    with served(0.1) as (link, port, thread):
        first = FakePx4(port)
        first.read()
        first.send([1.0] * 4)
        first.link.close()
        FakePx4(port).finish()
        thread.join(20.0)
        assert not thread.is_alive()
    kept = link.messages
    assert isinstance(kept, Kept)
    assert "waiting  PX4 is gone; for the next one" in kept.lines


def test_without_pymavlink_the_error_names_the_package(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "pymavlink.dialects.v20", None)
    assert main(["px4", "hover_crazyflie", "--port", "0"]) == 2
    error = capsys.readouterr().err
    assert "needs the package" in error and "`pip install pymavlink`" in error
