"""The paper's throughput tables: the calculations from measurements, not the measurements."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from measurements import module, run


@pytest.fixture
def load():
    """Imports a module of research/."""
    return module


def scalability_content() -> dict[str, Any]:
    """Data in the format of scalability.py, with rates that are easy to check."""

    def mean(rate: float) -> dict[str, float]:
        return {"rate": rate, "interval": 100.0, "cpu_use": 0.5, "receives": 10.0, "steps": 320.0}

    pool = [
        {"dynamics": dynamics, "action": action, "envs": envs, "batch": batch, "threads": 2}
        | {"mean": mean(scale * (envs + batch))}
        for dynamics, scale, most in (("tree", 1e4, 1_024), ("simbody", 1e2, 128))
        for envs in (4, 128, 1_024)
        for batch in (envs // 3, envs)
        for action in ("zero", "hold")
        if envs <= most
    ]
    ways = ("vec", "pool", "processes", "threads", "loop")
    baselines = [
        {"way": way, "envs": envs, "mean": mean(1e3 * (k + 1) / envs)}
        for k, way in enumerate(ways)
        for envs in (4, 128)
    ]
    length = {"trials": 5, "warm_up": 1_000, "receives": 10_000, "seconds": 1.0}
    return {
        "facts": module("machine").facts(),
        "length": length | {"simbody_most": 1.0},
        "pool": pool,
        "baselines": baselines,
        "reset_share": {"zero": 5e-5, "hold": 5e-5},
        "reset_share_envs": 64,
    }


def multi_agent_content(cost_of_20: float) -> dict[str, Any]:
    """Data as in multi_agent.py: 12 million steps a second for one robot, 12 / N for N."""
    counts = (1, 2, 5, 10, 20)

    def result(robots: int, batch: int, action: str) -> dict[str, Any]:
        mean = {"rate": 12e6 / robots, "interval": 1.0, "cpu_use": 0.9}
        return {"robots": robots, "action": action, "batch": batch} | {
            "mean": mean | {"receives": 1e4, "steps": 1e4 * batch},
            "near_share": 1.0,
        }

    costs = [{"robots": n, "whole": 50.0 + n, "rest": 40.0, "physics": 30.0} for n in counts]
    costs[-1]["rest"] = cost_of_20
    length = {"trials": 5, "warm_up": 1_000, "receives": 10_000, "seconds": 1.0, "most": 5.0}
    return {
        "facts": module("machine").facts(),
        "length": length,
        "python": [
            result(n, batch, action)
            for n in counts
            for action in ("hold", "zero")
            for batch in (11, 32)
        ],
        "cpp": [result(n, 32, action) for n in counts for action in ("hold", "zero")],
        "costs": costs,
    }


@pytest.mark.parametrize(
    "rates, half",
    [
        ([1.0, 3.0], 12.706),  # one degree of freedom, standard error 1
        ([1.0, 2.0, 3.0, 4.0, 5.0], 2.776 * math.sqrt(2.5 / 5.0)),
        ([7.0, 7.0, 7.0], 0.0),
    ],
)
def test_the_interval_is_that_of_students_t(load, rates: list[float], half: float):
    assert load("trials").interval(rates) == pytest.approx(half)


def test_a_summary_is_the_mean_of_the_trials(load):
    throughput = load("throughput")
    trials = [throughput.Trial(10, 420, 1.0, 0.5), throughput.Trial(30, 1260, 2.0, 0.7)]
    found = throughput.summary(trials)
    assert found.rate == pytest.approx((420.0 + 630.0) / 2.0)
    assert found.interval == pytest.approx(12.706 * 105.0)
    assert (found.cpu_use, found.receives, found.steps) == (pytest.approx(0.6), 20, 840)


def test_a_trial_counts_receives_and_their_rows(load):
    throughput = load("throughput")
    length = throughput.Length(trials=2, warm_up=10, receives=25, seconds=0.0)
    for batch in (2, 6):
        for trial in throughput.measure(throughput.Case("hover", 6, batch, "zero"), length):
            assert (trial.receives, trial.steps) == (30, 30 * batch)  # whole bursts
            assert trial.rate > 0.0
            assert trial.cpu_use >= 0.0


def test_measuring_ends_at_the_most_seconds(load):
    throughput = load("throughput")
    calls: list[None] = []
    done, taken = throughput._receive_for(lambda: calls.append(None), 10**12, 0.0, 0.01)
    assert done == len(calls) < 10**12
    assert taken >= 0.01


def test_batches_and_threads_are_the_papers(load):
    scalability = load("scalability")
    assert [scalability.batches(n) for n in (1, 4, 32)] == [(1,), (1, 4), (10, 32)]
    cases = scalability.cases((1, 128, 1_024))
    assert max(case.envs for dynamics, case in cases if dynamics == "simbody") == 128
    assert max(case.envs for dynamics, case in cases if dynamics == "tree") == 1_024
    assert len(cases) == 10 + 6
    for _, case in cases:
        assert case.threads == min(case.envs, load("machine").processors())


def test_peaks_stand_beside_the_papers_own(load):
    report = load("scalability_report")
    rows = report.peak_rows(scalability_content())
    assert {len(row) for row in rows} == {12}
    by_name = {row[0]: row for row in rows}
    zero = by_name["`make_pool`, zero"]
    assert zero[1:6] == ["2,560 ± 0", "128", "128", "50", "GzDRL (GazeboPool)"]
    assert zero[6:9] == ["78.58 ± 2.08", "128", "78.1"]
    assert zero[9:] == ["43.38 ± 0.56", "32", "82.7"]
    assert by_name["`make_pool`, zero, any N_E"][2] == "1,024"
    assert by_name["a Python loop, zero"][2] == "4"
    assert [row[5] for row in rows].count("Aerial Gym") == 1


def test_the_page_on_scalability_has_all_tables(load, tmp_path: Path):
    report = load("scalability_report")
    content = scalability_content()
    page = report.markdown(content)
    assert "24 cores (AMD Ryzen Threadripper 3960X)" in page
    assert "1,000 and 10,000 receives, or 1 s of measurement" in " ".join(page.split())
    sizes = report.rate_rows(content["pool"])
    assert sizes[-1][:4] == ["1,024", "1,024", "2", "20,480 ± 0"]
    assert sizes[-1][7:] == [""] * 4  # no values for Simbody
    assert report.measured_rows(content["pool"])[1][:4] == ["4", "1", "0.0", "0.3"]
    report.draw(content, tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000


def test_ratios_to_the_workstation_are_judged_by_their_goals(load):
    report = load("multi_agent_report")
    content = multi_agent_content(40.0)
    rows = report.goal_rows(content)
    assert rows[1] == ["goal", ">= 300", ">= 250", ">= 200", ">= 150"]
    # 6, 2.4, 1.2 and 0.6 million by 35.52, 17.82, 8.1 and 3.18 thousand
    assert rows[2][1:] == ["169 missed", "135 missed", "148 missed", "189 met"]
    assert len(rows) == 2 + 6


@pytest.mark.parametrize("cost, word", [(49.0, "met"), (51.0, "missed")])
def test_a_cost_is_flat_within_a_quarter(load, cost: float, word: str):
    report = load("multi_agent_report")
    content = multi_agent_content(cost)
    assert report.verdict(content) == f"met by physics alone, {word} by the rest of the step"
    assert report.cost_rows(content)[2][-1] == f"{cost / 40.0:.2f}"


def test_the_page_on_robots_has_the_papers_rows_and_ours(load, tmp_path: Path):
    report = load("multi_agent_report")
    content = multi_agent_content(40.0)
    rows = {row[0]: row[1:] for row in report.rate_rows(content)}
    assert rows["C++, N_B = 32, hold"][1] == "6,000 ± 0"
    assert rows["the paper's laptop: Aerial Gym"] == ["", "15.24", "14.88", "14.04", "11.44"]
    assert "{" not in report.markdown(content)
    report.draw(content, tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000


def test_costs_come_from_what_bench_prints(load):
    multi_agent = load("multi_agent")
    run = {"env_steps_per_second_per_thread": 2e6, "physics_share": 0.25}
    assert multi_agent.step_cost(run, 5) == pytest.approx(100.0)
    assert multi_agent.physics_cost(run, 5) == pytest.approx(25.0)
    assert multi_agent.in_flight(2) == (
        "stepping.horizon=1000",
        "robots.quad1.controllers.motors.parameters.max_speed=2782",
        "robots.quad2.controllers.motors.parameters.max_speed=2782",
    )


@pytest.mark.parametrize("script", ["scalability", "multi_agent"])
def test_a_bad_command_line_is_one_message(script: str, tmp_path: Path):
    (tmp_path / "file").write_text("")
    done = run(script, "--out", str(tmp_path / "file"))
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines()[-1].startswith(
        f"python -m research run {script}: error: cannot write to "
    )
