"""`skybody identify`: a simulated vehicle is found, and bad logs are named with a remedy."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import skybody
import yaml
from skybody import InputError
from skybody.identify.__main__ import main
from skybody.identify.attitude import attitudes
from skybody.identify.fit import bounded_step
from skybody.identify.reading import Log
from skybody.identify.record import CommandLaw, Mean, Record
from skybody.identify.replay import spun
from skybody.identify.rotation import into_body, of_vector, vector_of
from skybody.identify.vehicle import Vehicle
from skybody.imports.channels import Samples

from research.real.simulated_flights import Truth, drawn, write_flights

SHARED = Path(__file__).resolve().parents[3] / "shared/data/flights"
SECONDS, WINDOWS = 7.0, 40


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return Vehicle("crazyflie")


@pytest.fixture(scope="module")
def flown(vehicle: Vehicle, tmp_path_factory: pytest.TempPathFactory) -> tuple[Truth, Path]:
    """Two flights of a drawn vehicle in a folder with their map."""
    folder, rng = tmp_path_factory.mktemp("flights"), np.random.default_rng(1003)
    truth = drawn(vehicle, rng)
    write_flights(folder, vehicle, truth, SECONDS, rng)
    return truth, folder


@pytest.fixture(scope="module")
def result(flown: tuple[Truth, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of an identification."""
    folder, out = flown[1], tmp_path_factory.mktemp("out") / "found"
    logs = [str(folder / "flight_1.csv"), str(folder / "flight_2.csv")]
    options = ["--map", str(folder / "map.yaml"), "--model", "crazyflie"]
    assert main([*logs, *options, "--windows", str(WINDOWS), "--out", str(out)]) == 0
    return out


def test_true_values_lie_in_their_intervals(flown: tuple[Truth, Path], result: Path) -> None:
    report = json.loads((result / "report.json").read_text())
    truth = flown[0]
    true = truth.values | truth.command(report["mean_command"], report["mean_voltage"])
    missed = {}
    for name, found in report["parameters"].items():
        low, high = found["interval"]
        half = 0.5 * (high - low)
        if not low - half <= true[name] <= high + half:  # twice the interval of 95 %
            missed[name] = (true[name], found)
    # Of 30 intervals of 95 % one or two are missed by chance, by twice their width hardly any.
    assert len(missed) <= 1, missed


def test_inertia_and_lag_are_close(flown: tuple[Truth, Path], result: Path) -> None:
    found = json.loads((result / "report.json").read_text())["parameters"]
    for name in ("inertia.x", "inertia.y", "tau_up", "tau_down"):
        # 8 s of flight tell them to about 1 %; nominal values are off by 10 to 200 %.
        assert found[name]["value"] == pytest.approx(flown[0].values[name], rel=0.05), name


def test_identified_vehicle_predicts_better_than_the_nominal_one(result: Path) -> None:
    errors = json.loads((result / "report.json").read_text())["errors"]
    for kind in ("position", "attitude", "rate"):
        assert errors["identified"][kind]["0.5"] < 0.3 * errors["nominal"][kind]["0.5"], kind


@pytest.mark.parametrize("name", ["train_hover", "train_trajectory", "hover_commands"])
def test_scenarios_load_and_step(result: Path, name: str) -> None:
    envs = skybody.make_vec(str(result / f"{name}.yaml"), num_envs=2, seed=1)
    envs.reset()
    _, rewards, *_ = envs.step(np.zeros(envs.action_space.shape or (), np.float32))
    assert np.isfinite(rewards).all()
    envs.close()


def test_files_hold_the_identified_constants(result: Path) -> None:
    found = json.loads((result / "report.json").read_text())["parameters"]
    rotor = yaml.safe_load((result / "rotors.yaml").read_text())["rotors"][0]
    assert rotor["tau_up"] == pytest.approx(found["tau_up"]["value"], rel=1e-5)
    again = Vehicle(str(result / "vehicle.urdf"))
    inertia = again.nominal[again.path("inertia[0]")]
    assert inertia == pytest.approx(found["inertia.x"]["value"], rel=1e-5)


def test_without_poses_the_drag_s_moment_is_not_taken_for_that_of_the_rotors(
    flown: tuple[Truth, Path], tmp_path: Path
) -> None:
    folder, lines = flown[1], (flown[1] / "map.yaml").read_text().splitlines(keepends=True)
    poses = ("    position:", "    quaternion:")
    (tmp_path / "map.yaml").write_text("".join(s for s in lines if not s.startswith(poses)))
    logs = [str(folder / "flight_1.csv"), str(folder / "flight_2.csv")]
    options = ["--map", str(tmp_path / "map.yaml"), "--model", "crazyflie", "--windows", "40"]
    assert main([*logs, *options, "--out", str(tmp_path / "out")]) == 0
    report = json.loads((tmp_path / "out/report.json").read_text())
    found, true = report["parameters"], flown[0].values
    for name in ("inertia.x", "inertia.y", "tau_up", "tau_down"):
        # Velocities by the drag alone: about three times the error with poses, 5 %.
        assert found[name]["value"] == pytest.approx(true[name], rel=0.15), name
    # The body's quadratic drag counts as drag of the rotors here, at a speed of about 2 m/s.
    model = Vehicle("crazyflie")
    felt = true["drag.rotor"] + 2.0 * true["drag.quadratic_xy"] / (4.0 * model.hover_speed)
    assert found["drag.rotor"]["value"] == pytest.approx(felt, rel=0.4)
    errors = report["errors"]
    assert errors["identified"]["attitude"]["0.5"] < 0.5 * errors["nominal"]["attitude"]["0.5"]


# --- bad input ----------------------------------------------------------------------------------


def changed(flown: tuple[Truth, Path], folder: Path, change: dict[str, object]) -> list[str]:
    """Arguments for a copy of a flight whose columns were changed."""
    source = flown[1] / "flight_1.csv"
    names = source.read_text().partition("\n")[0].split(",")
    rows = np.loadtxt(source, delimiter=",", skiprows=1)
    for name, law in change.items():
        rows[:, names.index(name)] = law(rows[:, names.index(name)])  # type: ignore[operator]
    file = folder / "changed.csv"
    np.savetxt(file, rows, "%.7g", ",", header=",".join(names), comments="")
    (folder / "map.yaml").write_text((flown[1] / "map.yaml").read_text())
    options = ["--map", str(folder / "map.yaml"), "--model", "crazyflie"]
    return [str(file), *options, "--out", str(folder / "out")]


def frozen(values: np.ndarray) -> np.ndarray:
    made = values.copy()
    made[len(made) // 20 :] = made[len(made) // 20]
    return made


WRONG = {
    "gyroscope in deg/s": ({n: np.rad2deg for n in ("gx", "gy", "gz")}, "--unit gyro=deg/s"),
    "accelerometer in g": (
        {n: lambda v: v / 9.81 for n in ("ax", "ay", "az")}, "--unit accelerometer=g",
    ),
    "voltage in mV": ({"vbat": lambda v: 1e3 * v}, "--unit voltage=mV"),
    "commands as shares": (
        {f"m_{n}": lambda v: v / 65535.0
         for n in ("front_left", "front_right", "back_left", "back_right")},
        "correct `range`",
    ),
    "frozen positions": ({n: frozen for n in ("px", "py", "pz")}, "frozen position"),
    "positions in mm": ({n: lambda v: 1e3 * v for n in ("px", "py", "pz")}, "in mm"),
    "time that goes back": ({"t": lambda v: v[::-1]}, "goes back"),
    "time in ms": ({"t": lambda v: 1e3 * v}, "seem to be in ms"),
    "motors that never run": (
        {f"m_{n}": lambda v: 0.0 * v
         for n in ("front_left", "front_right", "back_left", "back_right")},
        "never run",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_log_is_one_error_with_the_remedy(
    case: str, flown: tuple[Truth, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change, remedy = WRONG[case]
    assert main(changed(flown, tmp_path, change)) == 2  # type: ignore[arg-type]
    said = capsys.readouterr().err
    assert said.startswith("error: ") and remedy in said, said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (["--unit", "gyros=deg/s"], "no sensor `gyros`"),
        (["--unit", "gyro=deg"], "allowed units"),
        (["--model", "none.urdf"], "no such file"),
        (["--fix", "tau"], "no parameter"),
    ],
)
def test_a_wrong_option_is_one_error(
    options: list[str],
    problem: str,
    flown: tuple[Truth, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main([*changed(flown, tmp_path, {}), *options]) == 2
    assert problem in capsys.readouterr().err


def test_parts_of_a_log_are_read_from_its_name() -> None:
    assert Log.of("a.csv@3:8") == Log(Path("a.csv"), 3.0, 8.0)
    assert Log.of("a.csv@3:").first == 3.0
    with pytest.raises(InputError, match="FROM below UNTIL"):
        Log.of("a.csv@8:3")


# --- parts --------------------------------------------------------------------------------------


def test_means_of_samples_are_exact_integrals() -> None:
    time = np.array([0.0, 1.0, 3.0])
    samples = Samples(time, np.array([[0.0], [2.0], [0.0]]))
    # Areas of triangles by hand; held values count until the next row.
    assert Mean(samples)(np.array(0.0), 3.0)[0] == pytest.approx(1.0)
    assert Mean(samples, held=True)(np.array(0.5), 1.5)[0] == pytest.approx(2.0 / 1.5)


def test_rotors_spin_up_by_the_engine_s_lag() -> None:
    commands = np.concatenate([np.zeros((1, 1, 1)), np.full((1, 8, 1), 100.0)], axis=1)
    found = spun(commands, np.array([[0.02]]), np.array([[9.0]]))
    assert found[0, 0] == pytest.approx(100.0 * (1.0 - np.exp(-8 * 0.0025 / 0.02)))


def test_attitudes_without_poses_are_levelled_by_the_mean_force() -> None:
    time = np.arange(0.0, 20.0, 0.01)
    tilt, still = np.array([0.0, 0.3, 0.0]), np.zeros((len(time), 3))
    # A vehicle that leans by 0.3 rad about y, hangs still, and is shaken at 0.5 Hz.
    up = into_body(of_vector(tilt), np.array([0.0, 0.0, 9.81])) * np.ones((len(time), 1))
    up[:, 0] += np.sin(np.pi * time)
    record = Record(
        Path("shaken.csv"), CommandLaw("speed"), Samples(time, still), gyro=Samples(time, still),
        force=Samples(time, up),
    )  # fmt: skip
    found = vector_of(attitudes(record).values[500:1500])
    # A whole number of shakes within the mean: only the steps of time are left.
    assert found == pytest.approx(np.tile(tilt, (1000, 1)), abs=1e-3)


def test_a_step_stays_within_bounds_and_is_best_there() -> None:
    matrix = np.array([[2.0, 1.0], [1.0, 2.0]])
    step = bounded_step(matrix, np.array([-4.0, 0.0]), np.full(2, -9.0), np.array([1.0, 9.0]))
    assert step == pytest.approx([1.0, -0.5])  # the second follows the bound of the first


# --- recorded flights ---------------------------------------------------------------------------


@pytest.mark.skipif(not SHARED.exists(), reason="the recorded flights are not here")
def test_recorded_flight_with_an_impossible_end_is_used_up_to_it(vehicle: Vehicle) -> None:
    from skybody.identify.reading import read
    from skybody.identify.screening import lengths, screen

    file = SHARED / "nanobench/B9_trefoil_fast_rep10.csv.gz"
    left_out = lengths(screen(read(Log(file), vehicle, "nanobench", {}), vehicle).record)
    # The onboard log ends after 19 of 42 s; the file goes on with straight lines.
    assert left_out["commands beyond 0 ... 65535"] == pytest.approx(22.9, abs=0.3)
