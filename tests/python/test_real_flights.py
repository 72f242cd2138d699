"""Replays of recorded flights: reading, screening, errors, and the command, on a synthetic flight.

The flight is the shipped model's own: a replay of it must give its states again.
"""

from __future__ import annotations

import csv
import json
import shutil
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from measurements import module, run
from numpy.typing import NDArray
from skybody import InputError, SimulationPool

Reals = NDArray[np.float64]
SECONDS, ROW = 3.0, 0.01
SHARE = 0.95  # of the speed of hover, at which the curve of PWM has ended: it falls
COLUMNS = (
    *("t", "px", "py", "pz", "qx", "qy", "qz", "qw", "vx", "vy", "vz"),
    *(f"imu_gyro_{axis}" for axis in "xyz"),
    *(f"imu_acc_{axis}" for axis in "xyz"),
    *(f"motor_motor_m{k}" for k in (1, 2, 3, 4)),
    *(f"sp_ctrltarget_{name}" for name in ("x", "y", "z", "yaw")),
    *("pid_controller_roll", "pid_controller_pitch", "pid_controller_yaw"),
    *("pid_controller_cmd_thrust", "pwr_pm_vbat"),
)
VOLTAGE = 3.7
SHIPPED = Path(__file__).resolve().parents[2] / "scenarios/models/crazyflie"
SLOPE, OFFSET = 0.028117, 426.24  # of the curve of speeds


def flown() -> tuple[Reals, Reals]:
    """States (rows, 13) and PWM (rows, 4) of the shipped model; commands change linearly."""
    engine = module("engine")
    shipped = engine.Shipped()
    rows = round(SECONDS / ROW)
    hover = float(np.sqrt(9.81 / shipped.thrusts_of(np.ones((1, 4)))[0].sum()))
    waves = np.sin(0.35 * np.arange(rows)[:, None] + np.array([0.0, 1.6, 3.1, 4.7]))
    speeds = SHARE * hover * (1.0 + 0.004 * waves)
    order = engine.order_of(shipped.compiled)
    pool = SimulationPool(shipped.compiled, 1)
    pool.reset()
    states = []
    for k in range(rows):
        states.append(engine.now(pool)[0])
        after = speeds[min(k + 1, rows - 1)]
        for part in (np.arange(5) + 0.5) / 5.0:
            pool.command(((1.0 - part) * speeds[k] + part * after)[order])
            pool.advance(2)
    return np.array(states), (speeds - OFFSET) / SLOPE


def write(file: Path, states: Reals, pwm: Reals) -> Path:
    """The flight in the columns of nanobench."""
    with file.open("w", newline="") as out:
        table = csv.writer(out)
        table.writerow(COLUMNS)
        for k, (state, motors) in enumerate(zip(states, pwm, strict=True)):
            quaternion = (*state[4:7], state[3])
            setpoint = (1.0, -2.0, 0.0, 40000.0, VOLTAGE)
            row = (1e9 + ROW * k, *state[:3], *quaternion, *state[7:], 0.0, 0.0, 1.0)
            table.writerow([repr(float(x)) for x in (*row, *motors, 0, 0, 1, 0, *setpoint)])
    return file


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The synthetic flight; its first row is far below the others, as on the ground."""
    states, pwm = flown()
    states[0, 2] -= 20.0
    return write(tmp_path_factory.mktemp("flight") / "own.csv", states, pwm)


def read(file: Path) -> Any:
    return module("recorded_flights").read(file, "nanobench")


def test_a_replay_of_the_models_own_flight_gives_its_states_again(file: Path) -> None:
    windows, models = module("windows"), module("models")
    own = windows.windows_of(read(file))
    found = models.predicted(module("engine").Shipped(), [own], [np.ones(4)])
    recorded = np.stack([own.states(h) for h in windows.HORIZONS], axis=1)
    errors = module("errors").errors(found, recorded)
    assert len(own.starts) > 10
    # Limits: the warm-up forgets the rotors' state but for exp(-0.3 / 0.025), and starts between
    # rows are interpolated.
    assert (errors.max(axis=(0, 1)) < [0.1, 0.2, 0.01, 0.05]).all(), errors.max(axis=(0, 1))


def test_a_wrong_factor_on_one_rotor_is_seen(file: Path) -> None:
    windows, models = module("windows"), module("models")
    own = windows.windows_of(read(file), 0.5)
    found = models.predicted(module("engine").Shipped(), [own], [np.array([1.05, 1, 1, 1])])
    recorded = np.stack([own.states(h) for h in windows.HORIZONS], axis=1)
    assert np.median(module("errors").errors(found, recorded)[:, 2, 1]) > 10.0  # degrees


def test_trimmed_rotors_carry_the_measured_force(file: Path) -> None:
    flight = read(file)
    heavier = replace(flight, specific_force=1.2 * flight.specific_force)
    factors = module("models").trim(module("engine").Shipped(), [heavier])
    # The thrust is SHARE^2 of the weight, the accelerometer says 1 g. Four sines have other means.
    assert factors == pytest.approx(np.full(4, 1.2 / SHARE**2), rel=2e-3)


def test_setpoints_have_pitch_positive_nose_down(file: Path) -> None:
    expected = [*np.radians([1.0, 2.0, 0.0]), 40000.0 / 65535.0]
    assert read(file).setpoint[7] == pytest.approx(expected)


def test_constant_rates_turn_about_the_bodys_axes() -> None:
    models = module("models")
    start = np.zeros((1, 13))
    start[0, 3] = 1.0
    start[0, 7:] = [1.0, 0.0, 0.0, 0.0, 0.0, np.pi]
    later = models.moved(start, 0.5)[0]
    assert later[:3] == pytest.approx([0.5, 0.0, 0.0])
    assert later[3:7] == pytest.approx([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])


def faulty(file: Path, **changes: Reals) -> Counter[str]:
    """Reasons against the windows of a changed flight."""
    found: Counter[str] = module("windows").windows_of(replace(read(file), **changes)).rejected
    return found


def test_impossible_saturated_and_extrapolated_commands_are_left_out(file: Path) -> None:
    flight = read(file)
    beyond, full, line = (flight.pwm.copy() for _ in range(3))
    beyond[150, 2], full[150, 1] = -1.0, 65535.0
    line[150:] = line[150] - 10.0 * np.arange(len(line) - 150)[:, None]
    assert faulty(file)["impossible"] == faulty(file)["saturated"] == faulty(file)["gap"] == 0
    assert faulty(file, pwm=beyond)["impossible"] > 5
    assert faulty(file, pwm=full)["saturated"] > 5
    assert faulty(file, pwm=line)["gap"] > 5


def test_a_pause_of_the_poses_is_a_gap(file: Path) -> None:
    flight = read(file)
    assert faulty(file, time=flight.time + 0.05 * (np.arange(len(flight.time)) > 150))["gap"] > 5


def test_windows_near_the_ground_are_left_out(file: Path) -> None:
    flight = read(file)
    low = flight.states.copy()
    low[200:, 2] = low[0, 2] + 0.1
    assert faulty(file, states=low)["ground"] > faulty(file)["ground"] + 5


def test_the_share_of_thrust_is_the_inverse_of_the_firmwares_table() -> None:
    curves = module("curves")
    for share in (0.1, 0.5, 0.9):
        grams = 60.0 * share
        volts = 0.088 * grams - 0.0006239 * grams**2  # as in motors.c
        pwm = np.array([65535.0 * volts / VOLTAGE])
        assert curves.share(pwm, np.array(VOLTAGE)) == pytest.approx(share)


def test_the_interval_has_no_width_if_all_windows_are_equal() -> None:
    errors = module("errors")
    found = errors.figures([np.full((30, 1), 2.0), np.full((50, 1), 2.0)], np.median)
    assert found.ravel().tolist() == [2.0, 2.0, 2.0]


def test_the_interval_is_that_between_flights_if_these_differ() -> None:
    errors = module("errors")
    found = errors.figures([np.full((40, 1), 1.0), np.full((40, 1), 3.0)], np.mean)
    assert found.ravel().tolist() == [2.0, 1.0, 3.0]


@pytest.fixture(scope="module")
def vehicle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as `skybody identify` writes it: the shipped model, the curve of its commands."""
    folder = tmp_path_factory.mktemp("identified")
    for name, copy in (("crazyflie.urdf", "vehicle.urdf"), ("rotors.yaml", "rotors.yaml")):
        shutil.copyfile(SHIPPED / name, folder / copy)
    (folder / "effects.yaml").write_text("effects: []\n")
    mean = 0.9
    speed = OFFSET + SLOPE * 65535.0 * mean
    values = {"command.speed": speed, "command.slope": 1.0 - OFFSET / speed, "command.curve": 0.0}
    report = {
        "model": "models/crazyflie/crazyflie.urdf",
        "flights": ["flights/other.csv"],
        "mean_command": mean,
        "mean_voltage": None,
        "parameters": {name: {"value": value} for name, value in values.items()},
    }
    (folder / "report.json").write_text(json.dumps(report))
    return folder


def test_an_identified_vehicle_flies_as_its_files_say(file: Path, vehicle: Path) -> None:
    windows, models = module("windows"), module("models")
    own = windows.windows_of(read(file), 0.5)
    ones = [np.ones(4)]
    found = models.predicted(module("identified").Identified(vehicle), [own], ones)
    shipped = models.predicted(module("engine").Shipped(), [own], ones)
    assert module("errors").errors(found, shipped).max() < 1e-3


def test_the_body_is_tilted_against_the_motion_capture_and_told_as_that_sees_it(
    file: Path, vehicle: Path, tmp_path: Path
) -> None:
    tilted = shutil.copytree(vehicle, tmp_path / "tilted")
    report = json.loads((tilted / "report.json").read_text())
    report["parameters"]["pose.tilt_x"] = {"value": 0.1}
    (tilted / "report.json").write_text(json.dumps(report))
    identified, start = module("identified"), np.zeros((1, 13))
    start[0, 3] = 1.0
    speeds = np.full((1, 400, 4), 2000.0)
    states = identified.Identified(tilted).fly(start, speeds)
    # After 0.1 s. The body is tilted by -0.1 rad: its thrust points to +y. It is told as level.
    assert states[0, 0, 8] > 0.05
    assert np.abs(states[0, 0, 3]) == pytest.approx(1.0, abs=1e-3)


def test_no_flight_of_the_fit_is_judged(file: Path, vehicle: Path) -> None:
    identified = module("identified").Identified(vehicle)
    assert identified.takes(read(file))
    assert not identified.takes(replace(read(file), name="other"))


def test_damped_commands_lose_constant_differences_and_keep_their_mean(file: Path) -> None:
    flight = read(file)
    uneven = replace(flight, pwm=flight.pwm[:, :1] + [0.0, 100.0, 200.0, 300.0])
    found = module("log_detail").damped(uneven, 0.2).pwm
    assert np.ptp(found, axis=1).max() < 1e-6
    assert found.mean(axis=1) == pytest.approx(uneven.pwm.mean(axis=1))


def test_the_offset_of_clocks_is_found_and_removed(file: Path) -> None:
    clocks, flight = module("clocks"), read(file)
    late = clocks.aligned(flight, -0.02)  # the gyroscope shows the motion of 20 ms before
    assert clocks.offset(flight) == pytest.approx(0.0, abs=0.002)
    assert clocks.offset(late) == pytest.approx(0.02, abs=0.002)


def test_rates_are_integrated_to_attitudes() -> None:
    time = np.linspace(0.0, 1.0, 101)
    rates = np.tile([0.0, 0.0, np.pi], (101, 1))
    found = module("recorded_flights").turned(time, rates)
    assert np.abs(found[-1]) == pytest.approx([0.0, 0.0, 0.0, 1.0], abs=1e-9)


def test_the_command_judges_a_folder_of_flights(file: Path, vehicle: Path, tmp_path: Path) -> None:
    words = ("--flights", str(file.parent), "--vehicle", str(vehicle), "--out", str(tmp_path))
    done = run("real_flights", "--quick", *words)
    assert done.returncode == 0, done.stderr
    rows = json.loads((tmp_path / "data/real_flights.json").read_text())["rows"]["errors"]
    ours = next(row for row in rows if row["model"].startswith("Skybody"))
    assert ours["figures"]["position"]["0.5"]["median"]["value"] < 0.1  # cm
    assert [row["form"] for row in rows[:3]] == ["", "published", "identified"]
    assert (tmp_path / "images/real_flights.png").stat().st_size > 10_000


def test_a_folder_without_flights_is_one_error(tmp_path: Path) -> None:
    done = run("real_flights", "--quick", "--flights", str(tmp_path), "--out", str(tmp_path))
    assert done.returncode == 2
    assert "no flight; allowed: *.csv, *.csv.gz" in done.stderr
    with pytest.raises(InputError, match="no such file or folder"):
        module("recorded_flights").files_of([tmp_path / "none"])
