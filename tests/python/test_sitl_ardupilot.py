"""ArduPilot's JSON interface: an autopilot flies through its packets; bad ones are ignored."""

from __future__ import annotations

import json
import random
import signal
import socket
import subprocess
from typing import Any

import numpy as np
import pytest
from sitl_pilots import HoldPilot, Kept
from skybody.program import module_command
from skybody.sitl import ardupilot
from skybody.sitl.__main__ import main
from skybody.sitl.ardupilot import Servos
from skybody.sitl.ardupilot_link import ArdupilotLink
from skybody.sitl.vehicle import Setup, Vehicle

STOPPED = (1000,) * 16
FUZZED = 10_000


def link_to(scenario: str, **setup: Any) -> ArdupilotLink:
    return ArdupilotLink(Vehicle("ardupilot", Setup(scenario, **setup)), Kept())


def asked(
    link: ArdupilotLink, count: int, pulses: tuple[int, ...] = STOPPED, rate: int = 1000
) -> Any:
    answer = link.answer(ardupilot.encode(Servos(rate, count, pulses)))
    assert answer is not None
    return json.loads(answer)


# --- packets ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("magic", "channels"), [(18458, 16), (29569, 32)])
def test_a_packet_is_magic_rate_count_and_pulses_little_endian(magic: int, channels: int) -> None:
    numbers = [magic % 256, magic // 256, 400 % 256, 400 // 256, 5, 0, 1, 0]
    packet = bytes(numbers) + bytes([0xDC, 0x05]) * channels
    assert ardupilot.decode(packet) == Servos(400, 65541, (1500,) * channels)
    assert ardupilot.encode(ardupilot.decode(packet)) == packet


@pytest.mark.parametrize(
    ("packet", "problem"),
    [
        (b"", "0 bytes"),
        (b"\x1a\x48\x00", "3 bytes"),
        (ardupilot.encode(Servos(1, 1, STOPPED))[:-1], "39 bytes; it needs 40"),
        (ardupilot.encode(Servos(1, 1, STOPPED)) + b"\x00", "41 bytes; it needs 40"),
        (b"\x00" * 40, "begins with 0"),
    ],
)
def test_another_packet_is_refused(packet: bytes, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        ardupilot.decode(packet)


@pytest.mark.parametrize(
    ("pulse", "throttle"), [(0, 0), (999, 0), (1000, 0), (1500, 0.5), (2000, 1), (65535, 1)]
)
def test_pulses_from_1000_to_2000_us_are_throttles_from_0_to_1(pulse: int, throttle: float) -> None:
    assert ardupilot.throttles((pulse,), 1).tolist() == [throttle]


def test_a_reply_is_one_line_between_two_ends_of_lines_without_spaces() -> None:
    link = link_to("hover_crazyflie")
    line = link.answer(ardupilot.encode(Servos(1000, 0, STOPPED)))
    assert line is not None and line[:1] == line[-1:] == b"\n" and line.count(b"\n") == 2
    assert b" " not in line
    assert list(json.loads(line)) == ["timestamp", "imu", "position", "quaternion", "velocity"]


def test_a_vehicle_at_rest_measures_gravity_upwards_in_frd() -> None:
    link = link_to("hover_crazyflie")
    for count in range(1000):  # the legs sink in within some tenths of a second
        reply = asked(link, count)
    assert reply["imu"]["accel_body"] == pytest.approx([0.0, 0.0, -9.81], abs=1e-3)
    truth = link.vehicle.read()
    assert reply["position"] == pytest.approx((truth.position * [1, -1, -1]).tolist())
    assert reply["timestamp"] == pytest.approx(1.0)


def test_range_finder_and_battery_of_the_scenario_are_in_the_reply() -> None:
    reply = asked(link_to("hover_sensors", frame="x-reversed"), 0)
    assert {f"rng_{number}" for number in range(1, 7)} < set(reply)
    assert reply["battery"]["voltage"] > 10.0


# --- lockstep -----------------------------------------------------------------------------------


def test_a_rate_that_is_no_divisor_of_the_physics_rate_is_kept_on_average() -> None:
    link = link_to("hover_crazyflie")
    times = [asked(link, count, rate=400)["timestamp"] for count in range(400)]
    assert times[-1] == pytest.approx(1.0, abs=1e-3)  # a physics step
    assert min(np.diff(times)) > 0.0
    assert asked(link, 400, rate=0)["timestamp"] > times[-1]
    assert asked(link, 401, rate=65535)["timestamp"] > times[-1]


def test_a_repeated_frame_gets_the_same_reply_and_no_step() -> None:
    link = link_to("hover_crazyflie")
    first = asked(link, 7)
    assert asked(link, 7) == first
    assert asked(link, 8)["timestamp"] > first["timestamp"]


def test_a_smaller_frame_count_begins_the_flight_anew() -> None:
    link = link_to("hover_crazyflie")
    first = [asked(link, count, (1900,) * 16) for count in range(50)]
    again = [asked(link, count, (1900,) * 16) for count in range(50)]
    assert first == again


def test_lost_frames_are_told_once() -> None:
    link = link_to("hover_crazyflie")
    for count in (0, 3, 9):
        asked(link, count)
    kept = link.messages
    assert isinstance(kept, Kept)
    assert kept.lines == ["warning: 2 frames before frame 3 are lost"]
    assert kept.summary() == "2 gaps"


def flight(scenario: str, frame: str, pilot: HoldPilot, rate: int, kick: bool) -> ArdupilotLink:
    """Six seconds; after half of them the vehicle is set turning about all axes."""
    link = link_to(scenario, frame=frame)
    pulses = [1000] * 16
    for count in range(6 * rate):
        if kick and count == 3 * rate:
            link.vehicle.simulation.teleport(angular_velocity=[2.0, -2.0, 1.0])
        seen = asked(link, count, tuple(pulses), rate)
        throttles = pilot.throttles(
            np.array(seen["quaternion"]),
            np.array(seen["imu"]["gyro"]),
            -seen["position"][2],
            -seen["velocity"][2],
        )
        pulses[:4] = [round(1000.0 + 1000.0 * value) for value in throttles]
    return link


def test_an_autopilot_takes_off_and_recovers_from_a_turn_the_same_in_two_runs() -> None:
    first, second = (
        flight("hover_crazyflie", "x", HoldPilot(hover=0.787, height=1.0), 1000, kick=True)
        for _ in range(2)
    )
    end = first.vehicle.read()
    assert end.position[2] == pytest.approx(1.0, abs=0.2)  # about signs, not gains
    assert np.abs(end.turn_rate).max() < 0.02
    assert abs(end.rotation[1]) + abs(end.rotation[2]) < 0.02
    assert first.vehicle.hash() == second.vehicle.hash()


def test_reversed_motors_fly_with_their_frame() -> None:
    """ArduPilot's X_REV has Betaflight's order: back right, front right, back left, front left."""
    pilot = HoldPilot(hover=0.383, height=1.0, yaw_sign=-1.0, order=(3, 0, 1, 2))
    end = flight("hover", "x-reversed", pilot, 400, kick=True).vehicle.read()
    assert end.position[2] == pytest.approx(1.0, abs=0.2)
    assert np.abs(end.turn_rate).max() < 0.1  # of 2 rad/s; yaw is slow


def test_random_packets_do_no_harm() -> None:
    link, generator = link_to("hover_crazyflie"), random.Random(5)
    good = ardupilot.encode(Servos(1000, 0, STOPPED))
    answers = 0
    for _ in range(FUZZED):
        packet = bytearray(good if generator.random() < 0.7 else generator.randbytes(72))
        for _ in range(generator.randrange(4)):
            packet[generator.randrange(len(packet))] = generator.randrange(256)
        del packet[len(packet) - generator.choice((0, 0, 0, 0, 1, 7, 32)) :]
        answers += link.answer(bytes(packet)) is not None
        if link.vehicle.time > 60.0:
            link.vehicle.reset()
    assert 100 < answers < FUZZED
    kept = link.messages
    assert isinstance(kept, Kept)
    assert sum("ignored" in line for line in kept.lines) == 1


# --- the command --------------------------------------------------------------------------------


def started(*arguments: str) -> tuple[subprocess.Popen[str], int]:
    """The command, and its port."""
    process = subprocess.Popen(
        module_command("skybody.sitl", "ardupilot", "hover_crazyflie", "--port", "0", *arguments),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("waiting"):
            return process, int(line.rpartition(":")[2])
    raise AssertionError(process.communicate()[1])


def test_the_command_flies_with_a_client_on_udp_and_prints_a_hash() -> None:
    process, port = started("--seconds", "0.5")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(20.0)
        for count in range(500):
            packet = ardupilot.encode(Servos(1000, count, (1800,) * 16))
            client.sendto(b"no packet", ("127.0.0.1", port))
            client.sendto(packet, ("127.0.0.1", port))
            reply = json.loads(client.recv(4096))
    out, error = process.communicate(timeout=20)
    assert (process.returncode, error) == (0, "")
    assert reply["timestamp"] == 0.5
    link = link_to("hover_crazyflie")
    for count in range(500):
        asked(link, count, (1800,) * 16)
    assert f"hash     {link.vehicle.hash()}" in out
    assert "time     0.500 s (500 ignored)" in out


def test_an_autopilot_that_goes_away_is_told_and_ctrl_c_ends_the_wait() -> None:
    process, port = started()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.sendto(ardupilot.encode(Servos(1000, 0, STOPPED)), ("127.0.0.1", port))
    assert process.stdout is not None
    lines = [process.stdout.readline() for _ in range(2)]
    assert lines[0].startswith("flying") and "ArduPilot is silent" in lines[1]
    process.send_signal(signal.SIGINT)
    out, error = process.communicate(timeout=20)
    assert process.returncode == 130
    assert error == "interrupted\n" and "time     0.001 s" in out


@pytest.mark.parametrize(
    ("autopilot", "kind"), [("ardupilot", socket.SOCK_DGRAM), ("px4", socket.SOCK_STREAM)]
)
def test_a_port_in_use_is_an_error_with_the_remedy(
    autopilot: str, kind: socket.SocketKind, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket(socket.AF_INET, kind) as other:
        other.bind(("127.0.0.1", 0))
        if kind == socket.SOCK_STREAM:
            other.listen()
        port = str(other.getsockname()[1])
        assert main([autopilot, "hover_crazyflie", "--port", port]) == 2
    error = capsys.readouterr().err
    assert f"port {port} of 127.0.0.1 is in use; end the other program" in error
    assert error.count("\n") == 1
