"""Paths of least snap against the quadratic program that defines them, by NumPy.

The oracle minimises the integral of squared snap over the coefficients of all pieces, in powers of
time, with positions, ends at rest and continuity up to jerk as linear constraints: one dense
Karush-Kuhn-Tucker system. It does not use derivatives at the knots, from which Skybody solves it.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
import skybody

ORDER = 7  # degree of the pieces


def powers(t: float, derivative: int) -> np.ndarray:
    """The derivative of 1, t, t^2, ... at t."""
    row = np.zeros(ORDER + 1)
    for k in range(derivative, ORDER + 1):
        row[k] = math.factorial(k) / math.factorial(k - derivative) * t ** (k - derivative)
    return row


def snap_cost(h: float) -> np.ndarray:
    """The matrix of the integral of squared snap over a piece of duration h."""
    cost = np.zeros((ORDER + 1, ORDER + 1))
    for i in range(4, ORDER + 1):
        for j in range(4, ORDER + 1):
            a = (
                math.factorial(i)
                / math.factorial(i - 4)
                * math.factorial(j)
                / math.factorial(j - 4)
            )
            cost[i, j] = a * h ** (i + j - 7) / (i + j - 7)
    return cost


def least_snap(times: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Coefficients of the least-snap path from rest to rest along one axis, one row per piece."""
    pieces, n = len(times) - 1, ORDER + 1
    cost = np.zeros((pieces * n, pieces * n))
    rows, right = [], []

    def constrain(piece: int, row: np.ndarray, value: float, minus: int | None = None) -> None:
        full = np.zeros(pieces * n)
        full[piece * n : (piece + 1) * n] = row
        if minus is not None:
            full[minus * n : (minus + 1) * n] -= powers(0.0, int(value))
        rows.append(full)
        right.append(0.0 if minus is not None else value)

    for k in range(pieces):
        h = times[k + 1] - times[k]
        cost[k * n : (k + 1) * n, k * n : (k + 1) * n] = snap_cost(h)
        constrain(k, powers(0.0, 0), places[k])
        constrain(k, powers(h, 0), places[k + 1])
        for d in (1, 2, 3):
            if k == 0:
                constrain(k, powers(0.0, d), 0.0)
            if k + 1 == pieces:
                constrain(k, powers(h, d), 0.0)
            else:
                constrain(k, powers(h, d), d, minus=k + 1)
    a, b = np.array(rows), np.array(right)
    system = np.block([[cost, a.T], [a, np.zeros((len(b), len(b)))]])
    solution = np.linalg.lstsq(system, np.concatenate([np.zeros(pieces * n), b]), rcond=None)[0]
    return solution[: pieces * n].reshape(pieces, n)


@pytest.mark.parametrize("seed", range(3))
def test_waypoints_are_flown_by_the_path_of_least_snap(seed: int) -> None:
    random = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.cumsum(random.uniform(1.0, 2.5, 5))])
    places = random.uniform(-2.0, 2.0, (6, 3)) + np.array([0.0, 0.0, 3.0])
    given = ", ".join(f"{x!r}" for x in places.ravel().tolist())
    when = ", ".join(f"{t!r}" for t in times.tolist())
    parameters = f"kind: waypoints, waypoints: [{given}], times: [{when}], check: false"
    chain = (
        f"[{{plugin: reference, parameters: {{{parameters}, gives: position}}}}, "
        "{plugin: position}, {plugin: attitude}, {plugin: ctbr}]"
    )
    simulation = skybody.Simulation(
        "hover",
        overrides=[
            f"robots.quad.controllers={chain}",
            "randomization=[]",
            "task={plugin: watch, parameters: {robot: quad, link: base_link}}",
            "stepping.horizon=0",
        ],
    )
    simulation.reset()
    oracle = [least_snap(times, places[:, axis]) for axis in range(3)]
    for step in range(1, int(1000 * times[-1])):
        simulation.step(np.zeros(0, dtype=np.float32))
        if step % 97 != 0:
            continue
        t = step * 1e-3
        piece = int(np.searchsorted(times, t, side="right") - 1)
        expected = [powers(t - times[piece], 0) @ oracle[axis][piece] for axis in range(3)]
        # Infos are floats, 24 bits of up to 5 m; the dense system is solved to 1e-9.
        np.testing.assert_allclose(simulation.info[:3], expected, atol=1e-6)
