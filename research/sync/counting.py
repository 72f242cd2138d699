"""Latencies, delays, intervening steps and spreads from the notes of simulator and policy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from research.sync.work import DT, WRENCHES, Reals

MOST_STEPS = 10**6  # of a trial; makes one number of a trial and a step


@dataclass(frozen=True)
class Counted:
    """The trials of one way of stepping."""

    latency: Reals  # of each action, from sending it to the first physics step under it [s]
    delay: Reals  # of each odometry, from the end of its physics step to the policy [s]
    intervening: Reals  # of each action: physics steps from its odometry to its first own step
    position: Reals  # (trials, WRENCHES, 3): where each action begins [m]; NaN: it never does
    pace: float  # simulated time over that on the wall
    rate: float  # actions per second on the wall

    @property
    def lost(self) -> int:
        """Actions that no physics step has obeyed."""
        return int(np.isnan(self.position[..., 0]).sum())


def counted(rows: Reals, actions: Reals, came: Reals, repeat: int) -> Counted:
    """Brings the notes together.

    Args:
        rows: of the simulator, as recorded.COLUMNS, in the order of time.
        actions: of the policy: trial, action, step of its odometry, time sent [s].
        came: of the policy: trial, step, time [s] of each odometry.
        repeat: physics steps of a row.
    """
    rows = rows[rows[:, 0] >= 0]  # before trial 0 the two only meet
    place, first = matched(rows[:, 0] * MOST_STEPS + rows[:, 1], key_of(actions))
    obeyed = rows[first]
    sent = actions[place]
    end, source = matched(rows[:, 0] * MOST_STEPS + rows[:, 2] + repeat, key_of(came))
    trials = int(actions[:, 0].max()) + 1
    position = np.full((trials, WRENCHES, 3), np.nan)
    position[sent[:, 0].astype(int), sent[:, 1].astype(int)] = obeyed[:, 5:8]
    return Counted(
        obeyed[:, 3] - sent[:, 3],
        came[end][:, 2] - rows[source][:, 4],
        obeyed[:, 2] - sent[:, 2],
        position,
        pace_of(rows, repeat),
        (WRENCHES - 1) * trials / sum(np.ptp(sent[sent[:, 0] == k, 3]) for k in range(trials)),
    )


def key_of(table: Reals) -> Reals:
    """One number for the first two columns."""
    return np.asarray(table[:, 0] * MOST_STEPS + table[:, 1])


def matched(where: Reals, wanted: Reals) -> tuple[Reals, Reals]:
    """Places in `wanted` that `where` has, and the first place in `where` of each."""
    found, first = np.unique(where, return_index=True)
    place = np.searchsorted(found, wanted).clip(max=len(found) - 1)
    there = found[place] == wanted
    return np.flatnonzero(there), first[place[there]]


def pace_of(rows: Reals, repeat: int) -> float:
    """Simulated time over that on the wall, of all trials together."""
    simulated = wall = 0.0
    for trial in np.unique(rows[:, 0]):
        of = rows[rows[:, 0] == trial]
        simulated += DT * repeat * len(of)
        wall += of[-1, 4] - of[0, 3]
    return simulated / wall


def spread(position: Reals) -> Reals:
    """Root mean square distance from the mean of all trials, of each action [m]."""
    near = position - np.nanmin(position, axis=0)  # all 0 if all trials are the same bits
    away = np.linalg.norm(near - np.nanmean(near, axis=0), axis=2)
    return np.asarray(np.sqrt(np.nanmean(away**2, axis=0)))


def errors(position: Reals, reference: Reals) -> Reals:
    """Root mean square distance of each trial from a reference (WRENCHES, 3) [m]."""
    away = np.linalg.norm(position - reference, axis=2)
    return np.asarray(np.sqrt(np.nanmean(away**2, axis=1)))
