"""`skybody onboard`: missions, lockstep with the same bits, MAVLink, limits, bad input."""

from __future__ import annotations

import json
import re
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink
from skybody import CompiledScenario, InputError, Simulation
from skybody._native import mission_bytes
from skybody.exports.__main__ import main
from skybody.onboard import packets
from skybody.onboard.lockstep import HOST, OWNERS, Vehicle, fly
from skybody.onboard.program import about, find_program, running
from skybody.train.policy_file import shipped_policy

from research.deploy.network_drafts import write_draft

LEVEL = ((0.0, 0.0, 1.5), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@pytest.fixture(scope="module")
def racing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The mission of the shipped policy for racing."""
    mission = tmp_path_factory.mktemp("missions") / "racing.mission"
    compiled = CompiledScenario("racing")
    mission.write_bytes(mission_bytes(compiled, str(shipped_policy("racing", "racing"))))
    return mission


def connected(port: int) -> socket.socket:
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.connect((HOST, port))
    made.settimeout(10.0)
    return made


def export(*words: str | Path) -> int:
    return main([str(word) for word in words])


# --- the same bits --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scenario", "episodes"),
    # The race's first gate is drawn; in episode 20 it is the mission's own again.
    [("racing", 20), ("obstacles", 2), ("landing", 2)],
)
def test_a_mission_flies_the_bits_of_the_engine(
    scenario: str, episodes: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "policy.mission"
    words = ("shipped", "--scenario", scenario, "--to", "onboard", "-o", out)
    assert export(*words, "--check", episodes) == 0
    assert f"{episodes} episodes" in (text := capsys.readouterr().out)
    assert "every action equal in all bits" in text


@pytest.mark.parametrize("network", ["with_memory", "with_cells"])
def test_a_recurrent_policy_of_hover_flies_the_bits_of_the_engine(
    network: str, tmp_path: Path
) -> None:
    policy = write_draft(tmp_path / "policy.h5", "hover_learn", network)
    assert export(policy, "--to", "onboard", "-o", tmp_path / "m", "--check", "2") == 0


def test_a_path_of_a_file_is_in_the_mission(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "path.csv"
    rows = [f"{t},{0.2 * np.cos(0.5 * t)},0,1.5" for t in np.arange(0.0, 20.0, 0.5)]
    table.write_text("\n".join(["t,x,y,z", *rows]) + "\n")
    parts = [f"{{kind: csv, file: {table}, yaw: fixed, ramp: 2}}", "[]"]
    paths = ("task.parameters", "randomization")
    changes = [
        w for path, part in zip(paths, parts, strict=True) for w in ("--set", f"{path}={part}")
    ]
    out = tmp_path / "m"
    command = ("shipped", "--scenario", "trajectory_ctbr", "--to", "onboard", "-o", out)
    assert export(*command, *changes, "--check", "1") == 0, capsys.readouterr().err
    table.unlink()
    assert "trajectory" in about(out)


def test_gates_of_a_file_replace_those_of_the_mission(racing: Path, tmp_path: Path) -> None:
    gates = tmp_path / "gates.txt"
    gates.write_text("# x y z yaw\n3 0 1.5 0\n6 3 1.5 1.57\n3 6 1.5 3.14\n-1 3 1.5 -1.57\n")
    with running(racing, ["--lockstep", "--gates", str(gates)]) as (port, _):
        link = connected(port)
        link.send(packets.state(0, 1.0, *LEVEL))
        first = packets.read_command(link.recv(4096))
    assert first.mode == packets.POLICY
    gates.write_text("3 0 1.5\n")
    with (
        pytest.raises(InputError, match=r"gates\.txt:1: is no gate"),
        running(racing, ["--gates", str(gates)]),
    ):
        pass


# --- MAVLink --------------------------------------------------------------------------------------


def odometry(sender: Any, body: Any, micros: int) -> bytes:
    """ODOMETRY in NED and FRD of a BodyState."""
    w, x, y, z = body.rotation
    turn = _matrix(body.rotation)
    velocity = turn.T @ body.velocity
    flip = np.array([1.0, -1.0, -1.0])
    message = sender.odometry_encode(
        micros, mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_BODY_FRD,
        *(body.position * flip), [w, x, -y, -z], *(velocity * flip),
        *(body.angular_velocity * flip), [np.nan] * 21, [np.nan] * 21,
    )  # fmt: skip
    return bytes(message.pack(sender))


def drawn(simulation: Simulation) -> list[str]:
    """Options with the drawn parameters of the task."""
    compiled = simulation.compiled
    return [
        word
        for path in compiled.param_paths
        if path.startswith(OWNERS) and simulation.param(path) != compiled.param_info(path)[0]
        for word in ("--set", f"{path}={simulation.param(path)!r}")
    ]


def _matrix(quaternion: Any) -> Any:
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_pymavlink_flies_the_race_by_odometry_and_rate_targets(racing: Path) -> None:
    simulation = Simulation("racing", seed=1)
    simulation.reset()
    sender, receiver = mavlink.MAVLink(None, srcSystem=9), mavlink.MAVLink(None)
    by_packets: list[packets.Command] = []
    with running(racing, ["--lockstep", "--mavlink", *drawn(simulation)]) as (port, _):
        link = connected(port)
        beat = sender.heartbeat_encode(2, 12, 0, 0, 4)
        link.send(beat.pack(sender))
        twin = Simulation("racing", seed=1)
        twin.reset()
        with running(racing, ["--lockstep"]) as (other, _):
            by_packets = fly(twin, Vehicle(twin, other), steps=50)
        simulation.reset(1)
        for answer in by_packets:
            micros = round((1.0 + simulation.time) * 1e6)
            link.send(odometry(sender, simulation.bodies[0], micros))
            found = None
            while found is None:
                for message in receiver.parse_buffer(link.recv(4096)) or []:
                    assert message.get_type() != "BAD_DATA"
                    if message.get_type() == "SET_ATTITUDE_TARGET":
                        found = message
            assert found.type_mask == 128 and found.target_system == 9
            thrust, roll, pitch, yaw = answer.command
            rates = (found.body_roll_rate, -found.body_pitch_rate, -found.body_yaw_rate)
            # Poses are rounded to float, 1e-6 of 10 m; the network and its memory of the last
            # action raise that by less than 1e3.
            np.testing.assert_allclose(rates, (roll, pitch, yaw), atol=1e-2)
            assert found.thrust * 39.4138 == pytest.approx(thrust, abs=1e-2)
            simulation.step(answer.action)


def test_mavlink_waits_for_the_packet_that_engages(racing: Path) -> None:
    simulation = Simulation("racing")
    simulation.reset()
    sender = mavlink.MAVLink(None)
    with running(racing, ["--lockstep", "--mavlink", "--wait"]) as (port, _):
        link, other = connected(port), connected(port)
        link.send(odometry(sender, simulation.bodies[0], 1_000_000))
        other.send(packets.control(0, True))
        link.send(odometry(sender, simulation.bodies[0], 2_000_000))
        found = []
        while "SET_ATTITUDE_TARGET" not in found:
            found += [m.get_type() for m in mavlink.MAVLink(None).parse_buffer(link.recv(4096))]
    assert found.count("SET_ATTITUDE_TARGET") == 1


# --- limits ---------------------------------------------------------------------------------------


def test_in_real_time_a_silent_peer_leads_to_a_descent_then_a_stop(
    racing: Path, tmp_path: Path
) -> None:
    report = tmp_path / "report.json"
    limits = ["--limit", "stale=0.3", "--limit", "safe_time=0.3", "--limit", "lateness=5"]
    options = [*limits, "--seconds", "1.6", "--json", str(report)]
    modes: list[int] = []
    with running(racing, options) as (port, process):
        link = connected(port)
        link.settimeout(0.5)
        begun = time.monotonic()
        for k in range(100):
            if time.monotonic() - begun < 0.4:
                link.send(packets.state(k, 1.0 + 0.02 * k, *LEVEL))
            try:
                modes.append(packets.read_command(link.recv(4096)).mode)
            except (TimeoutError, ConnectionRefusedError):
                break
        process.wait(10.0)
    seen = [mode for k, mode in enumerate(modes) if k == 0 or mode != modes[k - 1]]
    assert seen == [packets.POLICY, packets.SAFE, packets.STOPPED]
    results = json.loads(report.read_text())
    assert "stale pose" in results["reasons"]
    assert results["late"]["count"] == results["steps"] > 0
    assert results["late"]["p50_us"] <= results["late"]["p99_us"] <= results["late"]["max_us"]


def test_a_pose_that_is_no_number_is_left_out_and_an_old_one_too(racing: Path) -> None:
    with running(racing, ["--lockstep"]) as (port, process):
        link = connected(port)
        bad = (np.full(3, np.nan), *LEVEL[1:])
        link.send(packets.state(0, 1.0, *bad))
        link.send(packets.state(1, 2.0, *LEVEL)[:50])
        link.send(b"XXXX" + packets.state(2, 2.0, *LEVEL)[4:])
        link.send(packets.state(3, 2.0, *LEVEL))
        first = packets.read_command(link.recv(4096))
        link.send(packets.state(4, 1.5, *LEVEL))  # late: no answer
        link.send(packets.state(5, 2.0, *LEVEL))  # again: the same answer
        again = packets.read_command(link.recv(4096))
        link.send(packets.state(6, 2.02, *LEVEL))
        last = packets.read_command(link.recv(4096))
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=10.0)
    assert (first.stamp, again.stamp, last.stamp) == (2.0, 2.0, 2.02)
    assert again.sequence == first.sequence and last.sequence == first.sequence + 1
    assert process.returncode == 130
    assert len(errors.splitlines()) == 4  # one of each kind


def test_tilt_fence_and_a_gap_of_the_stamps_are_safe(racing: Path) -> None:
    upside_down = (LEVEL[0], (0.0, 1.0, 0.0, 0.0), *LEVEL[2:])
    outside = ((0.0, 0.0, 99.0), *LEVEL[1:])
    options = ["--lockstep", "--limit", "fence=-20,-20,0,20,20,10"]
    with running(racing, options) as (port, _):
        link = connected(port)
        for reason, pose in (("tilt", upside_down), ("fence", outside)):
            link.send(packets.control(0, True))
            link.send(packets.state(1, 1.0, *pose))
            answer = packets.read_command(link.recv(4096))
            assert (answer.mode, answer.reasons) == (packets.SAFE, (reason,))
            assert np.isfinite(answer.command).all()


# --- bad input ------------------------------------------------------------------------------------


def refused(*words: str | Path) -> str:
    done = subprocess.run(
        [*find_program(), *map(str, words)], capture_output=True, text=True, timeout=20, check=False
    )
    assert done.returncode == 2
    assert done.stderr.startswith("error: ") and done.stderr.count("\n") == 1
    return done.stderr


def test_each_mistake_of_the_command_line_is_one_line(racing: Path, tmp_path: Path) -> None:
    assert "give a mission" in refused()
    assert "no option --nothing" in refused(racing, "--nothing")
    assert "no address" in refused(racing, "--listen", "here")
    assert "allowed: 1 ... 99" in refused(racing, "--fifo", "0")
    assert "fence with six" in refused(racing, "--limit", "fence=1")
    assert "least x, y, z, then" in refused(racing, "--limit", "fence=4,4,4,0,0,0")
    assert "allowed: 0 and above" in refused(racing, "--limit", "tilt=-1")
    assert "no value `task.nothing`" in refused(racing, "--set", "task.nothing=1")
    assert "is no file" in refused(racing, "--reference", racing)
    assert "cannot be read" in refused(tmp_path / "nothing")
    (tmp_path / "text").write_text("no mission, but a text of more than 32 bytes")
    assert "it is no mission" in refused(tmp_path / "text")
    damaged = bytearray(racing.read_bytes())
    damaged[1000] ^= 1
    (tmp_path / "damaged").write_bytes(damaged)
    assert "its checksum is wrong" in refused(tmp_path / "damaged")


def test_a_port_in_use_is_one_line(racing: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind((HOST, 0))
        address = f"{HOST}:{taken.getsockname()[1]}"
        assert f"{address} is in use" in refused(racing, "--listen", address)


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["--scenario", "racing_vision"], "sees images"),
        (["--scenario", "pendulum_learn"], "the task `pendulum` is not in this program"),
        (["--scenario", "racing", "--limit", "tilt=x"], "--limit tilt=x"),
        (["--scenario", "racing", "--limit", "stale=nan"], "--limit stale=nan"),
        (["--scenario", "racing", "--limit", "tilt=1,2"], "fence with six"),
        (["--scenario", "racing", "--limit", "other=1"], "`other` with 1 values; allowed: stale"),
        (["--scenario", "racing", "--robot", "other"], "shared by no robots"),
    ],
)
def test_policies_that_no_vehicle_flies_are_refused(
    words: list[str], problem: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "m"
    assert export("shipped", *words, "--to", "onboard", "-o", out) == 2
    assert problem in capsys.readouterr().err
    assert not out.exists()


def test_columns_without_a_source_on_a_vehicle_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    policy = write_draft(tmp_path / "p.h5", "hover_sensors", "rectified")
    assert export(policy, "--to", "onboard", "-o", tmp_path / "m") == 2
    error = capsys.readouterr().err
    assert "columns of the observation: rotor_speed.speed, battery.voltage" in error
    assert "imu" not in error and "position_error" not in error


def test_an_observed_imu_is_sent_with_the_poses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario = tmp_path / "with_imu.yaml"
    scenario.write_text(
        "include: hover_sensors.yaml\nname: with_imu\n"
        "observe: [imu.specific_force, imu.angular_rate]\n"
    )
    policy = write_draft(tmp_path / "p.h5", str(scenario), "rectified")
    words = ("--to", "onboard", "-o", tmp_path / "m", "--check", "1")
    assert export(policy, "--scenario", scenario, *words) == 0
    assert "needs    an IMU" in capsys.readouterr().out


def test_the_programs_of_the_page_run_as_printed(racing: Path, tmp_path: Path) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs/onboard.md").read_text()
    program = re.search(r"<!-- file: fly_onboard.py -->\n```python\n(.*?)```", page, re.DOTALL)
    assert program is not None
    (tmp_path / "racing.mission").write_bytes(racing.read_bytes())
    done = subprocess.run(
        [sys.executable, "-c", program[1]],
        cwd=tmp_path, capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    assert re.match(r"\d+ steps, 15.0 gates", done.stdout)
