"""The race of scenario `racing` in MuJoCo, with gates that can be touched.

The course and the rows are built from scenarios/racing/racing.yaml and tasks/racing/README.md.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from research.transfer.conditions import Condition, Truth
from research.transfer.estimator import Estimator
from research.transfer.inner_loop import by_rates
from research.transfer.observation import Motion
from research.transfer.quadrotor import GRAVITY, Quadrotor

Reals = NDArray[np.float64]
SCENARIO = Path(__file__).resolve().parents[2] / "scenarios/racing/racing.yaml"
DT, REPEAT = 0.002, 10  # a physics step [s], steps of an action
LAPS = 3
SHIFT = 0.2  # of each gate, each coordinate [m]
SPREAD, SHARE = 0.2, (0.3, 0.7)  # of the start: each coordinate [m], on the line between gates
MOST_RATES = np.array([10.0, 10.0, 5.0])  # of an action of 1 [rad/s]
GATE = re.compile(r"gate: \[([^\]]*)\], position: \[([^\]]*)\], rpy: \[0, 0, ([\d.]+)\]")


@dataclass(frozen=True)
class Course:
    """Gates of N races: centres (N, G, 3) [m], yaws (G) [rad], opening and bars (3) [m]."""

    centres: Reals
    yaws: Reals
    size: Reals

    @property
    def normals(self) -> Reals:
        """Unit vectors through the gates (G, 3)."""
        return np.stack([np.cos(self.yaws), np.sin(self.yaws), 0.0 * self.yaws], 1)

    def across(self, gate: NDArray[np.int_]) -> tuple[Reals, Reals]:
        """Normal and sideways direction of each race's gate (N, 3)."""
        normal = self.normals[gate]
        return normal, np.stack([-normal[:, 1], normal[:, 0], 0.0 * normal[:, 0]], 1)

    def mjcf(self, race: int) -> str:
        """The gates of a race as boxes."""
        width, height, bar = self.size
        side, top = 0.5 * (width + bar), 0.5 * (height + bar)
        bars = [(0.0, y, 0.0, 0.5 * bar, 0.5 * height + bar) for y in (-side, side)]
        boxes = [f"{x} {y} {z}|{0.5 * bar} {a} {b}" for x, y, z, a, b in bars]
        boxes += [f"0 0 {z}|{0.5 * bar} {0.5 * width} {0.5 * bar}" for z in (-top, top)]
        geoms = "".join(
            '<geom type="box" pos="{}" size="{}"/>'.format(*box.split("|")) for box in boxes
        )
        return "".join(
            f'<body pos="{x} {y} {z}" euler="0 0 {np.degrees(yaw)}">{geoms}</body>'
            for (x, y, z), yaw in zip(self.centres[race], self.yaws, strict=True)
        )


def draw(races: int, seed: int) -> tuple[Course, Reals, Reals]:
    """Courses, and the racers' first positions (N, 3) [m] and headings (N) [rad]."""
    found = GATE.findall(SCENARIO.read_text(encoding="utf-8"))
    size, places = (np.array([row[k].split(",") for row in found], float) for k in (0, 1))
    yaws = np.array([row[2] for row in found], float)
    random = np.random.default_rng([seed, 3])
    centres = places + SHIFT * random.uniform(-1.0, 1.0, (races, *places.shape))
    way = centres[:, 0] - centres[:, -1]
    share = random.uniform(*SHARE, (races, 1))
    start = centres[:, -1] + share * way + SPREAD * random.uniform(-1.0, 1.0, (races, 3))
    return Course(centres, yaws, size[0]), start, np.arctan2(way[:, 1], way[:, 0])


def row(course: Course, gate: NDArray[np.int_], motion: Motion, action: Reals) -> Reals:
    """Observations of task `racing` (N, 25)."""
    everyone, count = np.arange(len(gate)), len(course.yaws)
    parts = []
    for number in (gate % count, (gate + 1) % count):
        parts += [course.centres[everyone, number] - motion.position, course.normals[number]]
    up = np.broadcast_to([0.0, 0.0, 1.0], motion.velocity.shape)
    seen = np.stack([*parts, motion.velocity, up], 1)
    in_body = np.einsum("nji,nkj->nki", motion.attitude, seen).reshape(len(gate), -1)
    return np.hstack([in_body, motion.rates, action])


@dataclass
class Result:
    """Outcomes of N races."""

    passed: NDArray[np.int_]  # gates, before a gate was missed
    touched: NDArray[np.bool_]  # a gate, or the ground
    missed: NDArray[np.bool_]  # a gate's plane was crossed beside its opening
    seconds: Reals  # of the whole race; NaN: not ended
    paths: Reals  # (N, M, 3) [m]


def advance(course: Course, gate: NDArray[np.int_], before: Reals, after: Reals) -> tuple[Any, Any]:
    """Whether a motion passes each race's next gate, and whether it crosses beside it (N)."""
    number = gate % len(course.yaws)
    centre = course.centres[np.arange(len(gate)), number]
    normal, side = course.across(number)
    x0, x1 = (((p - centre) * normal).sum(axis=1) for p in (before, after))
    crosses = (x0 < 0.0) & (x1 >= 0.0)
    share = np.where(crosses, -x0 / np.where(crosses, x1 - x0, 1.0), 0.0)[:, None]
    place = before + share * (after - before) - centre
    width, height, _ = course.size
    inside = (np.abs((place * side).sum(axis=1)) < 0.5 * width) & (
        np.abs(place[:, 2]) < 0.5 * height
    )
    return crosses & inside, crosses & ~inside


def fly(
    engine: Any,
    quad: Quadrotor,
    policy: Callable[[Reals], Reals],
    races: tuple[Course, Reals, Reals],
    truth: Truth,
    condition: Condition,
    seconds: float,
    seed: int,
) -> Result:
    """Flies all races at once; each counts until a touch, a miss or its end."""
    course, start, yaw = races
    engine.start(start, yaw)
    count, goal = len(start), LAPS * len(course.yaws)
    estimator = Estimator(condition, engine.motion, DT, seed)
    gate = np.zeros(count, int)
    touched, missed = np.zeros(count, bool), np.zeros(count, bool)
    ended = np.full(count, np.nan)
    action, thrust = np.full((count, 4), -1.0), np.full(count, GRAVITY)
    full = 4.0 * quad.thrust * quad.max_speed**2
    before, path = start, [start]
    for k in range(round(seconds / DT)):
        time = k * DT
        estimator.update(time, engine.motion)
        if k % REPEAT == 0:
            racing = ~(touched | missed | (gate >= goal))
            passes, misses = advance(course, gate, before, engine.motion.position)
            gate, missed = gate + (racing & passes), missed | (racing & misses)
            ended = np.where(racing & (gate >= goal), time, ended)
            before = engine.motion.position.copy()
            path.append(before)
            known = estimator.estimate(time, thrust)
            action = policy(row(course, gate, known, action))
            force, rates = 0.5 * (action[:, 0] + 1.0) * full, action[:, 1:] * MOST_RATES
            thrust = force / quad.mass
        engine.step(by_rates(quad, force, rates, estimator.attitude()[1]), truth.air(time))
        touched |= engine.touching() & ~missed & (gate < goal)
    return Result(gate, touched, missed, ended, np.stack(path, 1))
