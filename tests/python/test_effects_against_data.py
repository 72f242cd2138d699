"""Effects beside flights: forces from logs, fits, and the engine's values, on synthetic logs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from measurements import module, run
from numpy.typing import NDArray
from skybody import InputError

Reals = NDArray[np.float64]
MASS, VOLTAGE, GRAVITY = 0.033, 3.8, 9.81
COLUMNS = 30  # of a log


def share_of(grams: Reals) -> Reals:
    """Shares of PWM at which a rotor has a thrust at VOLTAGE."""
    cases = module("effect_cases")
    shares = np.linspace(0.3, 1.0, 2001)
    return np.interp(grams, cases.thrust(shares, np.full(2001, VOLTAGE / 4.2)), shares)


def write(file: Path, position: Reals, force: Reals, gain: Reals) -> None:
    """A log of a vehicle that does not accelerate: thrust times gain and force carry the weight."""
    rows = np.zeros((len(position), COLUMNS))
    rows[:, 0] = 1e4 * np.arange(len(position))
    rows[:, 1:4], rows[:, 9], rows[:, 13] = position, GRAVITY, 1.0
    grams = 1000.0 * (MASS * GRAVITY - force) / gain / GRAVITY / 4.0
    rows[:, 18:22], rows[:, 22] = share_of(grams)[:, None], VOLTAGE
    file.parent.mkdir(parents=True, exist_ok=True)
    np.savetxt(file, rows, delimiter=",", header="names", comments="")


def jet(distance: Reals, height: Reals) -> Reals:
    """A downwash of form gzdrl [N]."""
    shape = np.exp(-0.5 * (distance**2 / (0.004 * height + 0.003)) ** 2)
    return np.where(height > 0.0, -0.08 * shape, 0.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Swaps of two vehicles with a known jet, and a climb with a known gain near the ground."""
    cases = module("effect_cases")
    made = tmp_path_factory.mktemp("neural_swarm")
    rows = 2400
    phase = np.linspace(0.0, 1.0, rows)
    for number, height in enumerate((0.22, 0.24, 0.27, 0.29, 0.32, 0.34, 0.36, 0.38)):
        low = np.stack([np.full(rows, 0.0), np.zeros(rows), np.full(rows, 1.0)], axis=1)
        high = low + np.stack([1.2 * phase - 0.6, 0.0 * phase, np.full(rows, height)], axis=1)
        relative = high - low
        force = jet(np.abs(relative[:, 0]), relative[:, 2])
        ones = np.ones(rows)
        write(made / cases.SWAPS / f"cf50_{number:02d}.csv", low, force, ones)
        write(made / cases.SWAPS / f"cf51_{number:02d}.csv", high, 0.0 * force, ones)
    climb = np.zeros((rows, 3))
    climb[:, 2] = 0.05 + 0.6 * np.maximum(phase - 0.05, 0.0)
    hub = climb[:, 2] - 0.05 + cases.HUB_AT_REST
    gain = 1.0 / (1.0 - (0.05 / (4.0 * hub)) ** 2)
    write(made / cases.TAKEOFFS[0] / "cf50_00.csv", climb, np.zeros(rows), gain)
    return made


def test_the_force_of_a_known_jet_is_found_and_fitted(folder: Path) -> None:
    cases = module("effect_cases")
    samples = cases.downwash_samples(folder, 1)
    inside = (samples[:, 1] < 0.03) & (samples[:, 0] > 0.0)
    expected = jet(samples[inside, 1], samples[inside, 0]) * cases.GRAMS
    assert np.abs(samples[inside, 2] - expected).mean() < 0.3  # of 8 g; the lag of thrust is known
    fitted = cases.fitted_downwash(samples)
    for distance, height in ((0.015, 0.3), (0.08, 0.3)):
        wanted = float(jet(np.array(distance), np.array(height))) * cases.GRAMS
        # By form gzdrl the engine's force follows the upper one's thrust over its weight: 1 here.
        assert cases.downwash_force(fitted, distance, height) == pytest.approx(wanted, abs=0.6)


def test_the_gain_near_the_ground_is_that_of_its_radius(folder: Path) -> None:
    cases = module("effect_cases")
    heights, gains = cases.ground_samples(folder)
    at, measured, _ = cases.binned(heights, gains, cases.HUB_HEIGHTS)
    # Means over bins of a curve differ from the curve at their means; far away the gain is not 1.
    assert measured == pytest.approx(cases.ground_gain(at, 0.05), abs=0.006)


def test_bins_with_few_samples_are_left_out() -> None:
    at, values, counts = module("effect_cases").binned(
        np.array([0.5] * 20 + [1.5]), np.ones(21), np.array([0.0, 1.0, 2.0])
    )
    assert (at.tolist(), values.tolist(), counts.tolist()) == ([0.5], [1.0], [20.0])


def test_a_folder_without_the_logs_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has no flights"):
        module("effect_cases").downwash_samples(tmp_path, 0)
    with pytest.raises(InputError, match="has no flights"):
        module("effect_cases").ground_samples(tmp_path)


def test_the_pack_that_is_fitted_on_other_flights_has_their_resistance() -> None:
    case, engine = module("battery_case"), module("recorded_flights")
    time = np.arange(0.0, 6.0, 0.01)
    pwm = np.where((time > 1.0) & (time < 5.5), 50000.0, 0.0)[:, None] * np.ones(4)

    def flight(name: str, voltage: Reals) -> object:
        empty = np.zeros((len(time), 13))
        return engine.Recorded(name, time, empty, pwm, voltage, empty[:, :3], None)

    resting = flight("a", np.full(len(time), 4.1))
    candidate = int(np.argmin(np.abs(case.RESISTANCES - 0.3)))
    own = case.replay(resting, case.RESISTANCES)
    sagged = np.interp(time, own.time, own.ours[:, candidate])
    sagged[time < own.time[0] - 0.1] = 4.1
    found = case.cases([flight("a", sagged), flight("b", sagged)])
    assert [made.resistance for made in found] == pytest.approx([0.3, 0.3], abs=0.011)
    assert max(made.error for made in found) < 0.01


def test_the_command_writes_a_page_without_any_flights(tmp_path: Path) -> None:
    none = str(tmp_path / "none")
    done = run("effects_against_data", "--quick", "--flights", none, "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert "Left out: no flights were given." in (tmp_path / "effects_against_data.md").read_text()


def test_the_command_writes_all_curves(folder: Path, tmp_path: Path) -> None:
    words = ("--neural-swarm", str(folder), "--flights", str(tmp_path / "none"))
    done = run("effects_against_data", "--quick", *words, "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "data/effects_against_data.json").read_text())
    assert len(found["downwash"]) == 3
    assert found["ground"]["measured"][0] > 1.05
