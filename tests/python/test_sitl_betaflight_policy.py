"""A policy at Betaflight's sticks: maps of rates, thrust, gains, actions and observations."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from sitl_pilots import Array, Kept
from skybody import CompiledScenario, Simulation
from skybody.sitl.__main__ import main, parser, serve_betaflight
from skybody.sitl.betaflight_link import BetaflightLink
from skybody.sitl.betaflight_pilot import hover_share
from skybody.sitl.betaflight_policy import PolicyPilot, command_range, rate_gains, with_action
from skybody.sitl.betaflight_rates import (
    THROTTLE_LOW,
    RateSticks,
    authority_of,
    gain_lines,
    inertia_of,
    speed_slope,
    throttle_stick,
)
from skybody.sitl.vehicle import Reading, Setup, Vehicle
from test_sitl_betaflight import fake

ROOT = Path(__file__).resolve().parents[2]
FIRMWARE = os.environ.get("SKYBODY_BETAFLIGHT", "")


@pytest.fixture(scope="module")
def racer() -> Vehicle:
    setup = Setup("racing", frame="x-reversed", on_ground=False, seed=101)
    return Vehicle("betaflight", setup)


# --- sticks -------------------------------------------------------------------------------------


def test_rates_are_shares_of_full_sticks_right_down_and_clockwise() -> None:
    sticks = RateSticks.of([10.0, 10.0, 5.0], 40.0)
    assert sticks.max_rates == (580.0, 580.0, 290.0)
    half = np.radians([290.0, 290.0, 145.0])
    assert sticks.channels(0.0, half) == pytest.approx([1750.0, 1750.0, THROTTLE_LOW, 1250.0])
    assert sticks.channels(0.0, -half) == pytest.approx([1250.0, 1250.0, THROTTLE_LOW, 1750.0])
    assert sticks.channels(0.0, [99.0, -99.0, 99.0]) == [2000.0, 1000.0, THROTTLE_LOW, 1000.0]


def test_console_lines_are_those_of_a_linear_curve_of_the_same_rates() -> None:
    lines = RateSticks.of([10.0, 9.0, 5.0], 40.0).settings()
    assert f"set min_check = {THROTTLE_LOW}" in lines
    for axis, unit in (("roll", 58), ("pitch", 52), ("yaw", 29)):
        assert f"set {axis}_rc_rate = {unit}" in lines
        assert f"set {axis}_srate = {unit}" in lines
        assert f"set {axis}_expo = 0" in lines


def test_a_rate_beyond_betaflights_is_refused() -> None:
    with pytest.raises(ValueError, match="beyond Betaflight's 1990"):
        RateSticks.of([40.0, 10.0, 5.0], 40.0)


def speed_by_betaflight(stick: float) -> float:
    """Its share of the greatest speed (rc.c, pid.c, with `thrust_linear = 150`)."""
    throttle = (stick - THROTTLE_LOW) / (2000.0 - THROTTLE_LOW)
    command = throttle / (1.0 + (1.5 - 0.5 * 1.5**2) * (1.0 - throttle) ** 2)
    return command * (1.0 + 1.5 * (1.0 - command) ** 2)


@pytest.mark.parametrize("share", [0.0, 0.04, 0.25, 0.5, 0.81, 1.0])
def test_thrust_is_the_square_of_the_speed_by_betaflights_own_map(share: float) -> None:
    assert speed_by_betaflight(throttle_stick(share)) ** 2 == pytest.approx(share, abs=1e-6)
    assert throttle_stick(-1.0) == THROTTLE_LOW
    assert throttle_stick(2.0) == 2000.0


def test_the_slope_is_that_of_the_speed_over_the_command() -> None:
    for command in (0.1, 0.4, 0.9):
        near = [m * (1.0 + 1.5 * (1.0 - m) ** 2) for m in (command - 1e-4, command, command + 1e-4)]
        assert speed_slope(near[1]) == pytest.approx((near[2] - near[0]) / 2e-4, rel=1e-3)


# --- gains --------------------------------------------------------------------------------------


def test_gains_are_those_of_an_angular_acceleration_per_error() -> None:
    lines = gain_lines([20.0, 20.0, 8.0], [0.1, 0.1, 0.1], [427.0, 297.0, 24.4])
    values = dict(re.findall(r"set (\w+) = (\d+)", "\n".join(lines)))
    # motor share = P * 0.032029 / 1000 for each deg/s (Betaflight's pid.h and mixer.c)
    for axis, kp, authority in (("roll", 20.0, 427.0), ("pitch", 20.0, 297.0), ("yaw", 8.0, 24.4)):
        share = int(values[f"p_{axis}"]) * 0.032029 / 1000.0 * math.degrees(1.0)
        assert share * authority == pytest.approx(kp, rel=0.03)
        assert values[f"i_{axis}"] == values[f"f_{axis}"] == "0"
    assert int(values["d_roll"]) == 8
    assert "set p_yaw = 250" in gain_lines([1e3] * 3, [0.0] * 3, [10.0] * 3)  # Betaflight's most


def test_the_authority_is_the_engines_own_angular_acceleration(racer: Vehicle) -> None:
    share, step = 0.6, 0.01
    found = authority_of(racer, share)
    simulation = Simulation("racing", control="rotor_speed", seed=101)
    rotors = simulation.compiled.rotors
    signs = np.array(
        [[np.sign(r.position[1]), -np.sign(r.position[0]), -np.sign(r.direction)] for r in rotors]
    )
    for axis in range(3):
        turns = []
        for way in (1.0, -1.0):
            simulation.reset(101)
            speeds = 2246.0 * (share + way * step * signs[:, axis])
            simulation.command(speeds)
            simulation.advance(400)  # rotors are there
            before = simulation.base().angular_velocity[axis]
            simulation.advance(1)
            turns.append((simulation.base().angular_velocity[axis] - before) / 1e-3)
        assert 0.5 * (turns[0] - turns[1]) == pytest.approx(step * found[axis], rel=0.05)


def test_inertia_and_gains_are_the_scenarios(racer: Vehicle) -> None:
    assert inertia_of(racer) == pytest.approx([0.0144, 0.0166, 0.0288], rel=0.1)
    assert rate_gains(CompiledScenario("racing")).tolist() == [[20, 20, 8], [0.1, 0.1, 0.1]]
    gains = "robots.quad.controllers=[{plugin: ctbr, parameters: {kp: [9, 8, 7]}}]"
    assert rate_gains(CompiledScenario("racing", [gains]))[0].tolist() == [9, 8, 7]


# --- commands and observations ------------------------------------------------------------------


def test_actions_mean_what_the_scenario_says() -> None:
    low, high = command_range(CompiledScenario("racing"), "quad")
    assert low[0] == 0.0
    assert low[1:].tolist() == [-10, -10, -5]
    assert high[1:].tolist() == [10, 10, 5]
    assert high[0] == pytest.approx(4 * 1.9533e-6 * 2246**2)


def test_another_command_is_refused() -> None:
    thrusts = CompiledScenario("racing", ["robots.quad.controllers=[{plugin: srt}]"])
    with pytest.raises(ValueError, match=r"--pilot policy needs one robot with `ctbr`"):
        command_range(thrusts, "quad")


def test_the_last_action_stands_in_its_columns(racer: Vehicle) -> None:
    row = racer.simulation.observation
    action = np.array([0.1, 0.2, 0.3, 0.4], np.float32)
    changed = with_action(racer.compiled, row.copy(), action)
    assert changed[21:].tolist() == action.tolist()
    assert changed[:21].tolist() == row[:21].tolist()
    assert with_action(racer.compiled, row.copy(), action[:0]).tolist() == row.tolist()


def test_the_start_is_that_of_the_same_seed_in_process(racer: Vehicle) -> None:
    simulation = Simulation("racing", seed=101)
    simulation.reset(101)
    assert racer.simulation.observation.tolist() == simulation.observation.tolist()


def test_it_waits_until_the_motors_turn_as_in_a_hover(racer: Vehicle) -> None:
    pilot = PolicyPilot(racer, "shipped")
    assert pilot.waits
    still, turning = np.zeros(4), np.full(4, 0.6)
    assert pilot.prepare(1.0, still)[2] == pilot.prepare(1.0, still)[4] == 1000
    on = pilot.prepare(5.5 + 0.5, still)
    assert (on[2], on[4]) == (1000, 2000)  # armed at a low throttle
    assert pilot.prepare(5.5 + 0.9, still)[2] == throttle_stick(hover_share(racer))
    for k in range(60):
        assert pilot.prepare(7.0 + 0.004 * k, turning)[4] == 2000
    assert not pilot.waits
    assert not pilot.ended


class Waiting:
    """A pilot that is ready after five packets, and ends the flight after three more."""

    radio_period = 0.004

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle = vehicle
        self.held: list[float] = []  # times of the vehicle
        self.flown: list[float] = []

    @property
    def waits(self) -> bool:
        return len(self.held) < 5

    @property
    def ended(self) -> bool:
        return len(self.flown) == 3

    def prepare(self, time: float, throttles: Array) -> list[float]:
        del time, throttles
        self.held.append(self.vehicle.time)
        return [1500.0] * 4

    def channels(self, reading: Reading, motors_turn: bool) -> list[float]:
        del motors_turn
        self.flown.append(reading.time)
        return [1500.0] * 4


def test_the_vehicle_is_held_until_the_pilot_is_ready(monkeypatch: pytest.MonkeyPatch) -> None:
    flying = Vehicle("betaflight", Setup("racing", frame="x-reversed", on_ground=False))
    pilot = Waiting(flying)
    with fake(monkeypatch):
        BetaflightLink(flying, pilot, 1e3, Kept()).serve(1.0, None)
    assert pilot.held == [0.0] * 5
    assert pilot.flown == pytest.approx([0.0, 0.004, 0.008])
    assert flying.time == pytest.approx(0.009)


class NoLink:
    """A link that flies no step."""

    def __init__(self, *arguments: object) -> None:
        del arguments

    def serve(self, seconds: float, program: object) -> None:
        del seconds
        assert program is None


def test_infos_are_printed_after_a_flight_without_a_program(
    racer: Vehicle, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("skybody.sitl.__main__.BetaflightLink", NoLink)
    said = Kept()
    serve_betaflight(racer, said, parser().parse_args(["betaflight", "racing", "--pilot=policy"]))
    names = [channel.name for channel in racer.compiled.info_channels]
    assert names
    assert [line.split()[:2] for line in said.lines] == [["info", name] for name in names]


def test_the_ground_is_no_start_for_a_policy(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["betaflight", "racing", "--pilot", "policy", "--start", "ground"])
    assert "begins in the air" in capsys.readouterr().err


# --- the real one -------------------------------------------------------------------------------


@pytest.mark.skipif(not FIRMWARE, reason="set SKYBODY_BETAFLIGHT to Betaflight's SITL to fly it")
@pytest.mark.skipif(shutil.which("unshare") is None, reason="needs unshare")
def test_a_policy_races_through_betaflight_itself(tmp_path: Path) -> None:
    """`scripts/build_betaflight.sh` builds it."""
    command = [sys.executable, "-m", "research", "run", "betaflight_race", "--quick"]
    done = subprocess.run(
        [*command, "--firmware", FIRMWARE, "--out", str(tmp_path)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    race = json.loads((tmp_path / "data/betaflight_race.json").read_text())["races"][0]
    assert race["in_process"]["gates"] == 15
    assert race["betaflight"]["gates"] >= 5  # a lap; its clock is that of the wall
