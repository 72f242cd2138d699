"""Flights of a policy in a world, and their errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from research.transfer.raptor_policies import Pilot, Target
from research.transfer.raptor_vehicles import Motion, Reals
from research.transfer.raptor_worlds import World

CENTER = (0.0, 0.0, 3.0)  # of both courses [m]
AMPLITUDES, TURN = (1.0, 0.5), 10.0  # of the figure of eight [m], time of one round [s]
NEAR = 0.3  # [m]
FAR, TILT = 5.0, 0.0  # a flight fails beyond this distance [m], or with this cosine of its tilt
SAMPLES, SEED = 1000, 7  # of the bootstrap


@dataclass(frozen=True)
class Course:
    """A path over time, and the part of its flight that counts."""

    name: str
    seconds: float
    counted: float  # at the end [s]
    target: Callable[[float], Target]


def standing(_: float) -> Target:
    """The middle, at rest."""
    return Target(np.array(CENTER), np.zeros(3))


def eight(t: float) -> Target:
    """A horizontal figure of eight: peak speed 0.89 m/s."""
    w, (x, y) = 2.0 * np.pi / TURN, AMPLITUDES
    return Target(
        np.add(CENTER, [x * np.sin(w * t), y * np.sin(2.0 * w * t), 0.0]),
        np.array([x * w * np.cos(w * t), 2.0 * y * w * np.cos(2.0 * w * t), 0.0]),
    )


HOVER = Course("hover", 10.0, 1.0, standing)
EIGHT = Course("figure of eight", 2.0 * TURN, TURN, eight)


@dataclass(frozen=True)
class Flown:
    """Errors of n flights."""

    error: Reals  # (n) hover: mean distance of the last second; eight: RMS of the last round [m]
    failed: NDArray[np.bool_]  # (n)


def fly(world: World, pilot: Pilot, course: Course, seconds: float | None = None) -> Flown:
    """Flies a course. The error of a failed flight is `FAR`."""
    steps = round((seconds or course.seconds) / world.period)
    counted = min(steps, round(course.counted / world.period))
    n = len(world.motion().position)
    squares, sums, failed = np.zeros(n), np.zeros(n), np.zeros(n, bool)
    for step in range(steps):
        world.step(pilot(world.motion(), course.target(step * world.period)))
        now = world.motion()
        away = now.position - course.target((step + 1) * world.period).position
        distance = np.linalg.norm(away, axis=1)
        failed |= ~(distance < FAR) | ~(now.rotation[:, 2, 2] > TILT)
        if step >= steps - counted:
            sums += np.nan_to_num(distance, nan=FAR)
            squares += np.nan_to_num(distance, nan=FAR) ** 2
    error = sums / counted if course is HOVER else np.sqrt(squares / counted)
    return Flown(np.where(failed, FAR, np.minimum(error, FAR)), failed)


def summary(flown: Flown) -> dict[str, Any]:
    """Median error and share of flights within `NEAR`, with 95 % intervals."""
    n = len(flown.error)
    near = int((flown.error < NEAR).sum())
    rng = np.random.default_rng(SEED)
    medians = np.median(flown.error[rng.integers(0, n, (SAMPLES, n))], axis=1)
    return {
        "flights": n,
        "median": float(np.median(flown.error)),
        "median_interval": np.percentile(medians, [2.5, 97.5]).tolist(),
        "near": near / n,
        "near_interval": list(wilson(near, n)),
        "failed": int(flown.failed.sum()),
    }


def wilson(successes: int, n: int) -> tuple[float, float]:
    """The 95 % interval of a share (E. B. Wilson 1927)."""
    z, p = 1.96, successes / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, float(middle - half)), min(1.0, float(middle + half))


def median_gap(one: Motion, other: Motion, flying: NDArray[np.bool_]) -> float:
    """Median distance of the same vehicles in two worlds [m], of those that fly; nan: none does."""
    apart = np.linalg.norm(one.position - other.position, axis=1)[flying]
    return float(np.median(apart)) if len(apart) else float("nan")
