"""Parts of experiments/integrator_audit.py that need no flight, and one scenario's audit."""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def audit():
    sys.path.insert(0, str(ROOT / "experiments"))
    try:
        yield importlib.import_module("integrator_audit")
    finally:
        sys.path.remove(str(ROOT / "experiments"))


@pytest.fixture(scope="module")
def report(audit):
    return importlib.import_module("integrator_report")


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
    assert error["rk4"] < 1e-6  # of fourth order; the reference's own error is some 1e-8 m
    assert error["rk4"] < error["midpoint"] < 1e-4  # of second order, at 1 ms
    assert error["midpoint"] < error["semi_implicit_euler"] < 5e-3  # of first order


def test_an_unknown_scenario_is_refused(audit, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["integrator_audit.py", "--only", "nothing"])
    with pytest.raises(SystemExit) as refused:
        audit.main()
    assert refused.value.code == 2 and "invalid choice: 'nothing'" in capsys.readouterr().err


def test_skybody_check_warns_beyond_what_the_audit_found(audit):
    found = json.loads((ROOT / "docs/results/data/integrator_audit.json").read_text())
    mild = [row for row in found["results"] if row["scenario"] not in ("boom", "hard_landing")]
    # What core/io/scenario_reader.cpp says of the largest steps that it does not warn of.
    for name, dt, position, angle in (
        ("semi_implicit_euler", 1e-3, 4e-3, 0.25),
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
