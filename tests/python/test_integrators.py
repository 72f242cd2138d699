"""Parts of research/physics/integrators.py that need no flight, and one scenario's audit."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from measurements import module

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def audit():
    return module("integrators")


@pytest.fixture(scope="module")
def report(audit):
    return module("integrator_report")


def test_angles_are_exact_for_small_turns_and_blind_to_the_quaternions_sign(audit):
    small = 1e-7
    a = np.array([[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]])
    turn = np.array([np.cos(small / 2), np.sin(small / 2), 0.0, 0.0])
    assert audit.turned(a, np.array([turn, -turn])) == pytest.approx([small, small], rel=1e-6)


def test_the_largest_exact_step_is_below_the_first_that_is_not(report):
    rows = [
        {"integrator": "rk4", "dt": dt, "is_good": good}
        for dt, good in ((0.00025, True), (0.0005, True), (0.001, False), (0.002, True))
    ]
    assert report.largest_exact_step(rows, "rk4") == "0.5"
    assert report.largest_exact_step(rows[2:], "rk4") == "none"


def test_a_flight_flown_again_ends_where_the_reference_does(audit):
    flight = audit.baseline("hover")
    results = audit.audit(flight, (1000,), trials=1)
    error = {result.integrator: result.position for result in results}
    assert len(error) == 7 and not any(result.fault for result in results)
    assert error["rk4"] < 1e-6  # fourth order; the reference's own error is some 1e-8 m
    assert error["rk4"] < error["midpoint"] < 1e-4  # second order, at 1 ms
    assert error["midpoint"] < error["semi_implicit_euler"] < 5e-3  # first order


def test_the_robots_of_the_collision_touch_within_the_audited_second(audit):
    flight = audit.baseline("collision")
    assert flight.start[0, 7] - flight.start[1, 7] > 2.0  # closing speed [m/s]
    assert 0.1 < audit.first_touch(flight) < 0.6
    replay = audit.Replay(flight, 1e-3, audit.fixed("midpoint").overrides)
    replay.fly()
    assert not replay.world.fault
    ends = audit.motion(replay.world)
    exact, _ = audit.end_of(flight, audit.references(flight)[0])
    # 0.7 s after a collision at 5 m/s, tumbling with the rotors on: 50 mm with every integrator.
    assert 1e-4 < np.linalg.norm(ends[:, :3] - exact[:, :3], axis=1).max() < 0.1


@pytest.mark.parametrize(
    "name", ["forest", "gates", "platform_landing", "cooperative_payload", "four_bar"]
)
def test_every_world_is_audited_whatever_its_robots_are_driven_by(audit, monkeypatch, name):
    assert name in audit.shipped()
    few = [audit.fixed(integrator) for integrator in ("semi_implicit_euler", "midpoint")]
    monkeypatch.setattr(audit, "INTEGRATORS", few)
    results = audit.audit(audit.baseline(name), (1000,), trials=1)
    error = {result.integrator: result.position for result in results}
    assert not any(result.fault for result in results)
    assert error["midpoint"] < 1e-3 and error["midpoint"] < error["semi_implicit_euler"]


def test_the_page_says_from_which_step_each_integrator_is_exact(report):
    rows = [
        {"scenario": "s", "integrator": name, "dt": dt, "is_good": dt < limit, "fault": False,
         "position": 0.0, "angle": 0.0, "energy": 0.0, "cost": 1.0}
        for name, limit in (("semi_implicit_euler", 4e-4), ("midpoint", 3e-3))
        for dt in (2.5e-4, 1e-3, 4e-3)
    ]  # fmt: skip
    flight = {
        "scenario": "s", "own": "midpoint", "own_dt": 1e-3, "interval": 4e-3,
        "reference_error": 0.0, "first_touch": 0.31,
    }  # fmt: skip
    facts = {"results": rows, "flights": [flight]}
    head, _, row = report.summary(facts).splitlines()
    assert head.split("|")[-3:-1] == [" semi_implicit_euler [ms] ", " midpoint [ms] "]
    assert row.split("|")[-3:-1] == [" 0.25 ", " 1 "]
    assert "touch from 0.31 s" in "\n".join(report.details(facts, flight))


def test_an_unknown_scenario_is_refused(audit, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["integrators", "--only", "nothing"])
    with pytest.raises(SystemExit) as refused:
        audit.main()
    assert refused.value.code == 2 and "invalid choice: 'nothing'" in capsys.readouterr().err


def test_skybody_check_warns_beyond_what_the_audit_found(audit):
    found = json.loads((ROOT / "docs/results/data/integrators.json").read_text())
    special = {"boom"}  # stiff
    special |= {f["scenario"] for f in found["flights"] if f.get("first_touch") is not None}
    mild = [row for row in found["results"] if row["scenario"] not in special]
    # Largest steps without a warning of core/io/yaml/scenario_reader.cpp, with its errors.
    for name, dt, position, angle in (
        ("semi_implicit_euler", 1e-3, 8e-3, 0.5),
        ("midpoint", 4e-3, 1e-3, 0.1),
        ("rk4", 4e-3, 1e-3, 0.1),
        ("cvode adams", 4e-3, 1e-3, 0.1),
        ("cvode bdf", 4e-3, 1e-3, 0.1),
        ("arkode erk", 4e-3, 1e-3, 0.1),
        ("arkode dirk", 4e-3, 1e-3, 0.1),
    ):
        rows = [r for r in mild if r["integrator"] == name and r["dt"] == pytest.approx(dt)]
        assert len(rows) == len({row["scenario"] for row in mild})
        assert max(row["position"] for row in rows) < position, name
        assert max(row["angle"] for row in rows) < np.radians(angle), name
