"""`python -m research run synchronization`: its counts, and steps in and between processes.

The programs of the two processes are research/sync/server.py and research/sync/agent.py.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from measurements import module

counting, work = module("counting"), module("work")
runs, summary, figures = module("two_processes"), module("summary"), module("figures")
RunError = module("programs").RunError

# Two actions of one trial, free-running: a row of the simulator is a physics step of 1 ms.
# trial, action, steps before, begin [s], end [s], x, y, z [m]
ROWS = np.array(
    [
        [-1, 0, 0, 0.0, 0.001, 9, 9, 9],  # the processes meet
        [0, 0, 0, 1.000, 1.0001, 0, 0, 1],
        [0, 0, 1, 1.001, 1.0011, 0, 0, 2],
        [0, 0, 2, 1.002, 1.0021, 0, 0, 3],
        [0, 2, 3, 1.004, 1.0045, 0, 0, 4],  # action 1 was replaced before this step
    ],
    float,
)
# trial, action, step of its odometry, sent [s]
ACTIONS = np.array([[0, 0, 0, 0.9995], [0, 1, 1, 1.0022], [0, 2, 1, 1.0035]], float)
# trial, step, came [s]
CAME = np.array([[0, 0, 0.99], [0, 1, 1.0004], [0, 3, 1.0031], [0, 4, 1.0050]], float)


def test_an_action_counts_from_when_it_is_sent_to_its_first_step() -> None:
    found = counting.counted(ROWS, ACTIONS, CAME, repeat=1)
    np.testing.assert_allclose(found.latency, [0.0005, 0.0005])
    np.testing.assert_array_equal(found.intervening, [0, 2])  # steps 1 and 2 came between


def test_an_action_that_no_step_obeys_is_lost() -> None:
    found = counting.counted(ROWS, ACTIONS, CAME, repeat=1)
    position = found.position[0, :3, 2]
    np.testing.assert_array_equal(position, [1.0, np.nan, 4.0])
    assert found.lost == work.WRENCHES - 2


def test_an_odometry_counts_from_the_end_of_the_step_that_made_it() -> None:
    found = counting.counted(ROWS, ACTIONS, CAME, repeat=1)
    np.testing.assert_allclose(found.delay, [0.0003, 0.0010, 0.0005])  # none made that of step 0


def test_the_pace_is_simulated_time_over_that_on_the_wall() -> None:
    found = counting.counted(ROWS, ACTIONS, CAME, repeat=1)
    assert found.pace == pytest.approx(0.004 / 0.0045)


def test_spread_and_errors_are_root_mean_squares() -> None:
    reference = np.zeros((work.WRENCHES, 3))
    flights = np.stack([reference, reference])
    flights[0, :, 0], flights[1, :, 1] = 0.003, -0.004
    np.testing.assert_allclose(counting.errors(flights, reference), [0.003, 0.004])
    np.testing.assert_allclose(counting.spread(flights), 0.0025)
    flights[0, 5] = np.nan  # a lost action counts in no mean
    assert counting.spread(flights)[5] == 0.0


@pytest.mark.parametrize("loop", work.LOOPS)
def test_in_process_no_step_is_between_and_all_flights_are_one(loop: str) -> None:
    found = runs.flown_in_process(loop, 3)
    assert not found.intervening.any()
    assert found.lost == 0
    assert (found.latency > 0.0).all()
    np.testing.assert_array_equal(found.position, found.position[:1].repeat(3, axis=0))
    assert not counting.spread(found.position).any()


def test_the_closed_loop_flies_to_its_goal() -> None:
    way = runs.flown_in_process("closed", 1).position[0]
    # The slower of its two modes has 5/s, so e^-10 of 1 m is left after 2 s.
    np.testing.assert_allclose(way[-1] - way[0], work.ASIDE, atol=5e-3)


def test_steps_between_in_lockstep_are_an_error() -> None:
    good = runs.flown_in_process("open", 1)
    reference = good.position[0]
    assert summary.summary("x", "lockstep", "open", good, reference)["error_mm"][-1] == 0.0
    late = counting.Counted(
        good.latency, good.delay, good.intervening + 1, good.position, good.pace, good.rate
    )
    with pytest.raises(RunError, match="physics steps between an odometry and its action"):
        summary.summary("x", "lockstep", "open", late, reference)
    with pytest.raises(RunError, match="another flight than in process"):
        summary.summary("x", "lockstep", "open", good, reference + 1e-12)
    assert summary.summary("x", "free-running", "open", late, reference)["intervening_mean"] == 1


def test_pictures_have_a_row_for_each_way(tmp_path: Path) -> None:
    rows: list[dict[str, Any]] = []
    for loop in work.LOOPS:
        found = runs.flown_in_process(loop, 2)
        for way in ("in process", *(way.title for way in runs.MIDDLEWARES)):
            for stepping in ("lockstep", "free-running"):
                rows.append(summary.summary(way, stepping, loop, found, found.position[0]))
    figures.draw_timing(tmp_path / "timing.png", summary.rows_of(rows, "open"))
    figures.draw_spread(tmp_path / "spread.png", rows)
    assert {path.name for path in tmp_path.iterdir()} == {"timing.png", "spread.png"}


@pytest.mark.parametrize("way", runs.MIDDLEWARES, ids=lambda way: way.agent)
def test_in_lockstep_a_middleware_flies_the_bits_of_one_process(way: Any) -> None:
    if not way.is_there:
        pytest.skip(f"{way.title} is not installed here: ./dev ros installs it")
    found = runs.flown(way, "closed", 1, is_free=False)
    reference = runs.flown_in_process("closed", 1).position[0]
    summary.check(way.title, "closed", found, reference)
