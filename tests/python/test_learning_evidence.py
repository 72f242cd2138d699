"""The page on learning: its runs start with the same bits, and its table matches the flights."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from measurements import module
from skybody._native import shipped_policies, shipped_scenarios
from skybody.train.presets import presets_file

ROOT = Path(__file__).resolve().parents[2]

learning = module("learning")
learning_courses = module("learning_courses")
learning_flight = module("learning_flight")
learning_report = module("learning_report")
page_data = module("page_data")
COURSES = {course.scenario: course for course in learning_courses.COURSES}
CONTENT = json.loads((ROOT / "docs/results/data/learning.json").read_text())
RUNS: list[dict[str, Any]] = CONTENT["runs"]
PAGE = (ROOT / "docs/results/learning.md").read_text()


def flights(succeeded: list[bool], failed: list[bool], error: list[float]) -> Any:
    """Flights with an info `error`, equal at the end and in the last second."""
    infos = {"error": np.array(error)}
    return learning_flight.Flights(np.array(succeeded), np.array(failed), infos, infos, infos)


# --- the runs -----------------------------------------------------------------------------------


@pytest.mark.parametrize("scenario", COURSES)
def test_runs_begin_with_the_bits_of_the_page(scenario: str) -> None:
    rows = [row for row in RUNS if row["scenario"] == scenario]
    for row in rows:
        again = learning.start(COURSES[scenario], row["seed"], row["total_steps"])
        if again != row["start"] and page_data.OLDER in PAGE:
            pytest.skip(f"seed {row['seed']} begins otherwise, as the page says of its data")
        assert again == row["start"], f"seed {row['seed']}"


def test_rows_are_of_the_scenarios_and_presets_of_today() -> None:
    kept = learning.kept(ROOT / "docs/results/data/learning.json", learning_courses.COURSES)
    assert kept == RUNS


def test_a_row_of_another_preset_goes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "learning.json"
    path.write_text(json.dumps({"runs": [{**RUNS[0], "total_steps": 1}, *RUNS[1:3]]}))
    assert learning.kept(path, learning_courses.COURSES) == RUNS[1:3]
    name = f"{RUNS[0]['scenario']}, seed {RUNS[0]['seed']}"
    assert f"{name}: is another run by now" in capsys.readouterr().out


def test_a_row_of_another_hash_stays_if_its_run_begins_with_the_same_bits(tmp_path: Path) -> None:
    row = next(row for row in RUNS if row["scenario"] == "obstacles")
    other = {**row, "scenario_hash": "0" * 16}
    path = tmp_path / "learning.json"
    path.write_text(json.dumps({"runs": [other, {**other, "start": {}}]}))
    assert learning.kept(path, learning_courses.COURSES) == [other]


def test_the_page_is_what_the_figures_make_of_it() -> None:
    text = learning_report.markdown(CONTENT, learning_courses.COURSES)
    assert text == page_data.body(PAGE)


def test_every_preset_has_a_course_and_every_course_a_policy() -> None:
    files = (presets_file(name) for name in shipped_scenarios())
    presets = {file.stem for file in files if file.is_file()}  # others include their scenario
    # learning_speed.md, recurrent_policy.md
    elsewhere = {"hover_learn", "vehicles", "vehicles_trajectory"}
    assert presets - elsewhere == set(COURSES)
    assert set(shipped_policies()) == set(COURSES)


def test_every_policy_that_is_shipped_is_one_of_the_page() -> None:
    assert {row["scenario"] for row in RUNS if row["is_shipped"]} == set(COURSES)
    for row in RUNS:
        if row["is_shipped"]:
            assert row["learned"], row["scenario"]


# --- the criteria --------------------------------------------------------------------------------


def test_a_share_counts_flights_that_are_near_and_have_not_failed() -> None:
    flown = flights([True, True, False, False], [False, False, True, False], [0.1, 0.3, 0.1, 0.1])
    assert learning_courses.Share(0.5).figure(flown) == 0.5
    assert learning_courses.Share(0.5, "error", 0.2).figure(flown) == 0.5
    assert learning_courses.Whole(0.5).figure(flown) == 0.75
    assert learning_courses.Share(0.5).is_met(0.5)
    assert not learning_courses.Share(0.51).is_met(0.5)


def test_a_mean_of_winners_leaves_others_out_and_is_met_by_nobody_without_one() -> None:
    lap = learning_courses.Mean("error", "lap", "s", most=2.0, of_winners=True)
    assert lap.figure(flights([True, False], [False, True], [1.0, 9.0])) == 1.0
    nobody = lap.figure(flights([False], [True], [1.0]))
    assert np.isnan(nobody)
    assert not lap.is_met(nobody)


def test_a_mean_of_whole_flights_is_the_path_over_the_time() -> None:
    flown = flights([True, True], [False, False], [9.0, 9.0])
    flown.whole_flight = {"speed": np.array([4.0, 7.0])}
    speed = learning_courses.MeanOfTheWhole("speed", "speed", "m/s", least=5.0)
    assert speed.figure(flown) == 5.5
    assert speed.shown(5.5) == "5.5 m/s"
    assert not speed.is_met(4.9)


def test_of_several_racers_the_one_with_most_gates_counts() -> None:
    infos = {
        "red.gates_passed": np.array([15.0, 3.0, 2.0]),
        "blue.gates_passed": np.array([9.0, 15.0, 4.0]),
        "red.lap_time": np.array([2.0, 7.0, 7.0]),
        "blue.lap_time": np.array([7.0, 4.0, 9.0]),
    }
    won = np.array([True, True, False])
    flown = learning_flight.Flights(won, ~won, infos, infos, infos)
    first, racers = learning_courses.MeanOfTheFirst, ("red", "blue")
    assert first("gates_passed", "gates", least=1, racers=racers).figure(flown) == 34.0 / 3.0
    assert first("lap_time", "lap", most=9, of_winners=True, racers=racers).figure(flown) == 3.0


def test_what_is_read_of_a_log_is_what_the_program_counts(tmp_path: Path) -> None:
    program = str(ROOT / "build/release/bin/skybody")
    command = [program, "run", "obstacles", "--policy", "random", "--no-picture"]
    command += ["--episodes", "6", "--out", str(tmp_path / "log")]
    subprocess.run(command, check=True, capture_output=True)
    lost = learning_flight.read_log(tmp_path / "log/flight.h5")
    reasons = [value for name, value in lost.at_the_end.items() if name.startswith("failed.")]
    assert lost.failed.any()
    assert (lost.failed == (np.array(reasons) > 0.5).any(axis=0)).all()
    assert not lost.succeeded.any()
    command[command.index("random")] = "shipped"
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    found = learning_flight.read_log(tmp_path / "log/flight.h5")
    assert f"success: {found.succeeded.sum()} of 6 episodes" in done.stdout
    assert not (found.succeeded & found.failed).any()
    again = learning_flight.from_json(json.loads(json.dumps(learning_flight.to_json(found))))
    assert (again.at_the_end["position_error"] == found.at_the_end["position_error"]).all()
