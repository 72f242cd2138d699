"""Observation, reward, ends and infos of task `trajectory` against NumPy, field by field.

The oracle is written from the equations of tasks/trajectory/README.md and
controllers/reference/README.md. Skybody flies random actions, and robots teleported to random
states.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from skybody.simulation import Simulation

Rows = NDArray[np.float64]
STATES = 10_000  # compared states of each scenario
LONGEST = 150  # steps of an episode here
GRAVITY = 9.81
# Observations, infos and rewards are float32: half an ulp of values of this size, and again as much
# for different round-off in the oracle and the task.
RELATIVE, ABSOLUTE = 1.3e-7, 2e-7


@dataclass
class Task:
    """The scenario's parameters of the task."""

    actions: int = 4
    history: int = 20
    window: int = 20
    spacing: float = 0.01
    matrices: bool = True
    body_axes: bool = False
    ramp: float = 2.0
    height_min: float = 0.1
    precision_reward: float = 2.0
    success_distance: float = 0.1
    settle: float = 3.0
    overrides: tuple[str, ...] = ()


SETTLED_SOON = ("task.parameters.settle=0.2",)
TASKS = {
    "trajectory": Task(settle=0.2, overrides=SETTLED_SOON),
    "trajectory_modular": Task(actions=3, settle=0.2, overrides=SETTLED_SOON),
    "trajectory_compact": Task(
        history=1,
        window=3,
        spacing=0.1,
        matrices=False,
        body_axes=True,
        success_distance=0.05,
        settle=0.2,
        overrides=SETTLED_SOON,
    ),
    "trajectory_paper": Task(height_min=0.0, precision_reward=0.0),
    "trajectory_modular_paper": Task(actions=3, height_min=0.0, precision_reward=0.0),
}
DIMENSIONS = {
    "trajectory": (700, 4),
    "trajectory_ctbr": (700, 4),
    "trajectory_modular": (680, 3),
    "trajectory_compact": (33, 4),
    "vehicles_trajectory": (33, 4),
    "trajectory_paper": (700, 4),
    "trajectory_modular_paper": (680, 3),
}


# --- flying -------------------------------------------------------------------------------------


@dataclass
class Episode:
    """Values after the reset and after every step, one row each."""

    task: Task
    path: dict[str, Any]  # the numbers of the path
    time: Rows
    position: Rows
    rotation: Rows
    velocity: Rows
    rates: Rows
    action: Rows  # 0 at the reset
    observation: Rows
    reward: Rows
    terminated: NDArray[np.bool_]
    info: Rows


def vector(sim: Simulation, name: str) -> Rows:
    return np.array([sim.param(f"task.{name}[{k}]") for k in range(3)])


def path_of(sim: Simulation) -> dict[str, Any]:
    numbers: dict[str, Any] = {
        name: vector(sim, name) for name in ("centre", "amplitude", "cycles", "phase")
    }
    return numbers | {name: sim.param(f"task.{name}") for name in ("peak_speed", "along")}


def put_somewhere(sim: Simulation, random: np.random.Generator) -> None:
    """Random states in and slightly outside the box of failures, with attitude, velocity, spin."""
    low, high = np.array([-9.3, -9.3, -0.1]), np.array([9.3, 9.3, 10.3])
    sim.teleport(
        position=random.uniform(low, high),
        rotation=random.normal(size=4),
        velocity=random.normal(size=3) * 2.0,
        angular_velocity=random.normal(size=3) * 4.0,
    )


def fly(task: Task, sim: Simulation, random: np.random.Generator) -> Episode:
    rows: dict[str, list[Any]] = {}

    def note(action: Rows) -> None:
        base = sim.base()
        for name, value in {
            "time": sim.time,
            "position": base.position,
            "rotation": base.rotation,
            "velocity": base.velocity,
            "rates": base.angular_velocity,
            "action": action,
            "observation": sim.observation,
            "reward": sim.reward,
            "terminated": sim.terminated,
            "info": sim.info,
        }.items():
            rows.setdefault(name, []).append(value)

    sim.reset()
    path = path_of(sim)
    note(np.zeros(task.actions))
    hover = np.full(task.actions, 0.24 if task.actions == 4 else 0.0)
    for _ in range(LONGEST):
        if random.random() < 0.03:
            put_somewhere(sim, random)
        action = (hover + random.normal(size=task.actions) * 0.05).astype(np.float32)
        sim.step(action)
        note(action.astype(np.float64))
        if sim.terminated:
            break
    made = {name: np.array(values) for name, values in rows.items()}
    return Episode(task=task, path=path, **made)


# --- the oracle ---------------------------------------------------------------------------------


def matrix(q: Rows) -> Rows:
    """(n, 3, 3) W from B of quaternions w x y z."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def turn_about(axis: int, angle: Rows) -> Rows:
    q = np.zeros((*np.shape(angle), 4))
    q[..., 0], q[..., 1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return q


def shortest_turn(up: Rows) -> Rows:
    """Matrices of the shortest rotation of e_z to unit vectors (Rodrigues' formula)."""
    axis = np.cross(np.array([0.0, 0.0, 1.0]), up)
    cross = np.zeros((*up.shape[:-1], 3, 3))
    cross[..., 0, 1], cross[..., 0, 2] = -axis[..., 2], axis[..., 1]
    cross[..., 1, 0], cross[..., 1, 2] = axis[..., 2], -axis[..., 0]
    cross[..., 2, 0], cross[..., 2, 1] = -axis[..., 1], axis[..., 0]
    return np.eye(3) + cross + cross @ cross / (1 + up[..., 2])[..., None, None]


class Reference:
    """A random Lissajous figure over time."""

    def __init__(self, path: dict[str, Any], ramp: float) -> None:
        self.path, self.ramp = path, ramp
        angles = 2 * math.pi / 256 * np.arange(256)[:, None]
        slope = path["amplitude"] * path["cycles"] * np.cos(path["cycles"] * angles + path["phase"])
        self.rate = path["peak_speed"] / np.linalg.norm(slope, axis=1).max()

    def clock(self, t: Rows) -> tuple[Rows, Rows, Rows]:
        """Path time, its rate, and the derivative of the rate."""
        x = np.clip(t / self.ramp, 0.0, 1.0)
        pace = 35 * x**4 - 84 * x**5 + 70 * x**6 - 20 * x**7
        change = (140 * x**3 - 420 * x**4 + 420 * x**5 - 140 * x**6) / self.ramp
        rising = self.ramp * (7 * x**5 - 14 * x**6 + 10 * x**7 - 2.5 * x**8)
        return np.where(t < self.ramp, rising, t - self.ramp / 2), pace, change

    def at(self, t: Rows) -> tuple[Rows, Rows, Rows, Rows]:
        """Position, velocity, acceleration (..., 3), yaw (...)."""
        s, pace, change = (part[..., None] for part in self.clock(t))
        w = self.path["cycles"] * self.rate
        angle = w * s + self.path["phase"]
        swing = self.path["amplitude"]
        p, dp, ddp = swing * np.sin(angle), swing * w * np.cos(angle), -swing * w**2 * np.sin(angle)
        yaw = np.arctan2(dp[..., 1], dp[..., 0]) * (self.path["along"] >= 0.5)
        return self.path["centre"] + p, dp * pace, ddp * pace**2 + dp * change, yaw


def wrapped(angle: Rows) -> Rows:
    return (angle + math.pi) % (2 * math.pi) - math.pi


def expected(e: Episode) -> dict[str, Rows]:
    """Every field of an episode, by its name."""
    task, n = e.task, len(e.time)
    out: dict[str, Rows] = {}
    rotation = matrix(e.rotation)
    into = np.swapaxes(rotation, 1, 2) if task.body_axes else np.broadcast_to(np.eye(3), (n, 3, 3))

    # The past: entry `age` of step i is that of step i - age; before the reset, that of the reset.
    ages = np.maximum(np.arange(n)[:, None] - np.arange(task.history), 0)
    velocity = np.einsum("nij,nj->ni", into, e.velocity)
    seen_action = e.action.copy()
    seen_action[0] = -1.0
    out["height"] = e.position[ages, 2]
    out["velocity"] = velocity[ages].reshape(n, -1)
    out["angular_velocity"] = e.rates[ages].reshape(n, -1)
    out["actions"] = seen_action[ages].reshape(n, -1)

    # The window.
    reference = Reference(e.path, task.ramp)
    ahead = e.time[:, None] + task.spacing * np.arange(task.window)
    r, dr, ddr, yaw = reference.at(ahead)
    errors = r - e.position[:, None], dr - e.velocity[:, None]
    for name, values in zip(("position_error", "velocity_error"), errors, strict=True):
        out[name] = np.einsum("nij,nwj->nwi", into, values).reshape(n, -1)

    heading = 2 * np.arctan2(e.rotation[:, 3], e.rotation[:, 0])
    yaw_error = wrapped(yaw[:, 0] - heading)
    if task.matrices:
        push = ddr + np.array([0.0, 0.0, GRAVITY])
        lean = shortest_turn(push / np.linalg.norm(push, axis=-1, keepdims=True))
        out["attitude"] = rotation.reshape(n, 9)[ages].reshape(n, -1)
        out["reference_attitude"] = (lean @ matrix(turn_about(2, yaw))).reshape(n, -1)
    else:
        out["up"] = rotation[:, 2, :]
        out["yaw_error"] = yaw_error[:, None]

    # Reward and ends.
    error, slip = errors[0][:, 0], errors[1][:, 0]
    distance = np.linalg.norm(error, axis=1)
    cost = error**2 @ [0.1, 0.1, 2.0] + slip**2 @ [0.002, 0.002, 0.04]
    cost += 0.01 * (e.rates**2).sum(1) + 0.01 * (e.action**2).sum(1)
    x, y, z = e.position.T
    ends = {
        "side": np.maximum(abs(x), abs(y)) > 9.0,
        "height": (z < task.height_min) | (z > 10.0),
        "tilt": np.arccos(np.clip(rotation[:, 2, 2], -1, 1)) > math.radians(157.5),
        "rate": np.linalg.norm(e.rates, axis=1) > 10.0,
    }
    failed = np.any(list(ends.values()), axis=0)
    reward = 1 / (1 + cost) + task.precision_reward / (1 + distance / 0.2)
    out["reward"] = np.where(failed, -50.0, reward)
    out["terminated"] = failed
    counts = e.time > task.settle
    sums, numbers = np.cumsum(distance * counts), np.cumsum(counts)
    mean = np.where(numbers > 0, sums / np.maximum(numbers, 1), distance)
    success = (numbers > 0) & (mean < task.success_distance) & ~failed
    speed = np.linalg.norm(e.velocity, axis=1)
    infos = [distance, abs(yaw_error), speed, mean, *ends.values(), success]
    out["info"] = np.stack(infos, axis=1)
    return out


# --- comparing ----------------------------------------------------------------------------------


def observed(e: Episode, columns: list[Any], info_count: int) -> dict[str, Rows]:
    """The same fields as given by the task; its infos precede those of controllers."""
    info = e.info[:, :info_count]
    out: dict[str, Rows] = {"reward": e.reward, "terminated": e.terminated, "info": info}
    first = 0
    for column in columns:
        size = math.prod(column.shape)
        out[column.name] = e.observation[:, first : first + size]
        first += size
    return out


def without_seams(name: str, got: Rows, want: Rows) -> Rows:
    """Angles near +-pi may have either sign."""
    if name != "yaw_error":
        return want
    return np.where(abs(got - want) > math.pi, want + 2 * math.pi * np.sign(got - want), want)


@pytest.mark.parametrize("name", TASKS)
def test_every_field_is_what_numpy_makes_of_the_flown_states(name: str) -> None:
    task = TASKS[name]
    random = np.random.default_rng(3)
    compared = 0
    reasons = np.zeros(4)
    while compared < STATES:
        sim = Simulation(name, seed=5, env_id=compared, overrides=list(task.overrides))
        columns = sim.compiled.observation_columns
        e = fly(task, sim, random)
        want = expected(e)
        got = observed(e, columns, want["info"].shape[1])
        assert want.keys() == got.keys()
        # Reward and end of a reset are ignored and therefore not compared.
        for field in want:
            first = 1 if field in ("reward", "terminated") else 0
            near = without_seams(field, got[field], want[field])
            np.testing.assert_allclose(
                got[field][first:],
                near[first:],
                rtol=RELATIVE,
                atol=ABSOLUTE * max(1.0, float(abs(near).max())),
                err_msg=f"{field}, environment {compared}",
            )
        compared += len(e.time) - 1
        reasons += e.info[:, 4:8].sum(axis=0)
    assert (reasons > 0).all(), "each end was among them"


@pytest.mark.parametrize("name", DIMENSIONS)
def test_scenarios_have_these_dimensions_rates_and_lengths(name: str) -> None:
    compiled = Simulation(name).compiled
    assert (compiled.observation_size, compiled.action_size) == DIMENSIONS[name]
    assert (compiled.dt, compiled.action_repeat, compiled.horizon) == (0.001, 10, 3000)


@pytest.mark.parametrize("name", DIMENSIONS)
def test_a_flight_goes_on_from_what_was_saved_in_its_midst(name: str) -> None:
    sim, other = (Simulation(name, seed=2, env_id=i) for i in (0, 1))
    action = np.zeros(DIMENSIONS[name][1], np.float32)
    sim.reset()
    for _ in range(30):
        sim.step(action)
    saved = sim.save()
    ends = []
    for one in (sim, other):
        one.restore(saved)
        for _ in range(30):
            one.step(action)
        ends.append((one.hash(), one.observation.tobytes(), one.info.tobytes()))
    assert ends[0] == ends[1]
