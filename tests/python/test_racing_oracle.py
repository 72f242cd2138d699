"""Observation, reward and ends of the race against NumPy and SciPy, over 10^4 random states."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import skybody
from scipy.spatial.transform import Rotation

Reals = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

ENVS, STEPS = 250, 48
STEP_TIME = 0.02  # s
PARAMETERS = {"radius": 0.15, "height_min": 0.9, "bound": 3.9, "tilt_max": 1.4, "yaw_max": 2.9}
# Observations are float32 (6e-8 of a value), and so are the gates' poses that the oracle reads:
# sums of a few of them, of up to about 10.
TOLERANCE: dict[str, Any] = {"rtol": 2e-6, "atol": 5e-6}
NAMES = [
    f"obstacles.gate_{g}.{value}[{k}]"
    for g in range(1, 6)
    for value, size in (("position", 3), ("rotation", 4), ("size", 3))
    for k in range(size)
]


def overrides(width: float, robots: list[str], gates: int) -> list[str]:
    """Wild, fast starts about the first gate; its index is random."""
    starts = [
        f"{{plugin: start, name: start_{robot}, parameters: {{robot: {robot}, position_min: "
        f"[2.0, -0.9, 0.8], position_max: [4.0, 0.5, 2.3], yaw_min: -3.1, yaw_max: 3.1, "
        f"tilt_max: 1.0, velocity_max: 8, rate_max: 3}}}}"
        for robot in robots
    ]
    places = (
        '{plugin: draw, name: places, parameters: {what: ["obstacles.gate_*.position[*]"], '
        "range: [-0.2, 0.2], form: shift}}"
    )
    first = (
        "{plugin: draw, name: first, parameters: {what: [task.first_gate], distribution: choice, "
        f"values: [0, 0, 0, {gates - 1}]}}}}"
    )
    return [
        "stepping.horizon=8",
        "contact.redraws=100",
        f"randomization=[{places}, {first}, {', '.join(starts)}]",
        f"infos=[{', '.join(map(repr, [*NAMES, 'task.first_gate']))}]",
        *(f"obstacles.gate_{g}.gate=[{width}, 1.4, 0.1]" for g in range(1, 6)),
        *(f"task.parameters.{name}={value}" for name, value in PARAMETERS.items()),
        f"task.parameters.gates=[{', '.join(f'gate_{g}' for g in range(1, gates + 1))}]",
        "task.parameters.laps=1",
        "task.parameters.rate_cost=0.002",
    ]


class Racer:
    """The oracle's memory of one robot in all environments."""

    def __init__(self) -> None:
        self.gates = np.zeros(ENVS)
        self.position = np.zeros((ENVS, 3))
        self.lap_time, self.lap_start = np.zeros(ENVS), np.zeros(ENVS)

    def begin(self, position: Reals, mask: Bools) -> None:
        for values in (self.gates, self.lap_time, self.lap_start):
            values[mask] = 0.0
        self.position[mask] = position[mask]


class Oracle:
    """Expected outputs of the task in a flight."""

    def __init__(self, envs: Any, robots: list[str], gates: int, rivalry: float) -> None:
        self.envs, self.robots, self.gates, self.rivalry = envs, robots, gates, rivalry
        self.racers = [Racer() for _ in robots]
        self.poses, self.first = np.zeros((ENVS, gates, 10)), np.zeros(ENVS, int)
        self.steps = np.zeros(ENVS)
        self.states = 0
        self.seen: dict[str, int] = {}

    def read(self, infos: dict[str, Any], mask: Bools) -> None:
        """Poses of gates and robots; infos give them for the environments of `mask`."""
        told = np.stack([np.ravel(infos[name]) for name in NAMES], axis=1).astype(np.float64)
        self.poses[mask] = told.reshape(ENVS, 5, 10)[mask, : self.gates]
        self.first[mask] = np.ravel(infos["task.first_gate"]).astype(int)[mask]
        self.centres, self.sizes = self.poses[:, :, :3], self.poses[:, :, 7:]
        turns = self.poses[:, :, [4, 5, 6, 3]]  # SciPy's order
        self.turns = Rotation.from_quat(turns.reshape(-1, 4)).as_matrix()
        self.turns = self.turns.reshape(ENVS, self.gates, 3, 3)
        state = self.envs.state
        q = state("bodies.rotation")
        self.p, self.v = state("bodies.position"), state("bodies.velocity")
        self.w = state("bodies.angular_velocity")
        self.q = q

    def rotation(self, i: int) -> Reals:
        matrices: Reals = Rotation.from_quat(self.q[:, i][:, [1, 2, 3, 0]]).as_matrix()
        return matrices

    def gate(self, i: int, ahead: int = 0) -> tuple[Reals, Reals, Reals]:
        index = (self.first + self.racers[i].gates.astype(int) + ahead) % self.gates
        rows = np.arange(ENVS)
        return self.centres[rows, index], self.turns[rows, index], self.sizes[rows, index]

    def observation(self, i: int, action: Reals) -> dict[str, Reals]:
        """Values of robot i, in its own axes."""
        rotation = self.rotation(i)

        def own(v: Reals) -> Reals:
            return np.einsum("nji,nj->ni", rotation, v)

        values: dict[str, Reals] = {}
        for ahead, name in enumerate(("gate", "following")):
            centre, turn, _ = self.gate(i, ahead)
            values[name if ahead == 0 else "following_gate"] = own(centre - self.p[:, i])
            values[name + "_normal"] = own(turn[:, :, 0])
        values["velocity"] = own(self.v[:, i])
        values["up"] = own(np.tile([0.0, 0.0, 1.0], (ENVS, 1)))
        values["angular_velocity"] = self.w[:, i]
        values["action"] = action[:, 4 * i : 4 * i + 4]
        for j, other in enumerate(self.robots):
            if j == i:
                continue
            values[other + "_offset"] = own(self.p[:, j] - self.p[:, i])
            values[other + "_velocity"] = own(self.v[:, j] - self.v[:, i])
            values[other + "_lead"] = (self.racers[j].gates - self.racers[i].gates)[:, None]
        return values

    def compare(self, seen: dict[str, Any], action: Reals, mask: Bools) -> None:
        names = set()
        for i, robot in enumerate(self.robots):
            prefix = robot + "_" if len(self.robots) > 1 else ""
            for name, values in self.observation(i, action).items():
                names.add(prefix + name)
                got = np.asarray(seen[prefix + name]).reshape(ENVS, -1)
                np.testing.assert_allclose(
                    got[mask], values[mask], **TOLERANCE, err_msg=prefix + name
                )
        assert names == set(seen)
        self.states += int(mask.sum()) * len(self.robots)

    def at_reset(self, seen: dict[str, Any], infos: dict[str, Any], mask: Bools) -> None:
        self.read(infos, mask)
        self.steps[mask] = 0
        for i, racer in enumerate(self.racers):
            racer.begin(self.p[:, i], mask)
        action = np.full((ENVS, 4 * len(self.robots)), -1.0)
        self.compare(seen, action, mask)

    def advance(self, i: int) -> tuple[Reals, Bools, Bools]:
        """Progress reward, and flags: robot i has passed or missed its gate."""
        racer = self.racers[i]
        centre, turn, size = self.gate(i)
        before = np.einsum("nji,nj->ni", turn, racer.position - centre)
        now = np.einsum("nji,nj->ni", turn, self.p[:, i] - centre)
        gain = np.linalg.norm(racer.position - centre, axis=1)
        gain = gain - np.linalg.norm(self.p[:, i] - centre, axis=1)
        crossed = (before[:, 0] < 0) & (now[:, 0] >= 0)
        share = np.zeros(ENVS)
        np.divide(before[:, 0], before[:, 0] - now[:, 0], out=share, where=crossed)
        place = (1 - share)[:, None] * before + share[:, None] * now
        opens = (np.abs(place[:, 1:]) <= size[:, :2] / 2).all(axis=1)
        racer.position = self.p[:, i].copy()
        racer.gates = racer.gates + (crossed & opens)
        lapped = crossed & opens & (racer.gates % self.gates == 0)
        time = self.steps * STEP_TIME
        racer.lap_time = np.where(lapped, time - racer.lap_start, racer.lap_time)
        racer.lap_start = np.where(lapped, time, racer.lap_start)
        return gain, crossed & opens, crossed & ~opens

    def frame_distance(self, p: Reals) -> Reals:
        """Distance to the nearest bar: the minimum over 4 boxes of each gate."""
        nearest = np.full(ENVS, np.inf)
        for g in range(self.gates):
            local = np.einsum("nji,nj->ni", self.turns[:, g], p - self.centres[:, g])
            width, height, bar = self.sizes[:, g].T
            for side in (-1, 1):
                upright = (side * (width + bar) / 2, 0 * width, bar, height + 2 * bar)
                level = (0 * width, side * (height + bar) / 2, width + 2 * bar, bar)
                for y, z, wide, high in (upright, level):
                    middle = np.stack([0 * y, y, z], axis=1)
                    half = np.stack([bar, wide, high], axis=1) / 2
                    beyond = np.maximum(np.abs(local - middle) - half, 0.0)
                    nearest = np.minimum(nearest, np.linalg.norm(beyond, axis=1))
        return nearest

    def at_step(
        self, seen: dict[str, Any], infos: dict[str, Any], action: Reals, reward: Any, ended: Any
    ) -> None:
        self.read(infos, np.ones(ENVS, np.bool_))
        self.steps += 1
        moves = [self.advance(i) for i in range(len(self.robots))]
        self.compare(seen, action, np.ones(ENVS, np.bool_))
        gains = np.array([gain for gain, _, _ in moves])
        failed = {
            name: np.zeros(ENVS, np.bool_)
            for name in ("tilt", "heading", "bound", "missed", "collision", "ground")
        }
        total = np.zeros(ENVS)
        for i, (gain, passed, missed) in enumerate(moves):
            p, rotation = self.p[:, i], self.rotation(i)
            others = [j for j in range(len(self.robots)) if j != i]
            own = {
                "tilt": np.arccos(np.clip(rotation[:, 2, 2], -1, 1)) > PARAMETERS["tilt_max"],
                "heading": np.abs(np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0]))
                > PARAMETERS["yaw_max"],
                "bound": np.abs(p).max(axis=1) > PARAMETERS["bound"],
                "missed": missed,
                "collision": self.frame_distance(p) < PARAMETERS["radius"],
                "ground": p[:, 2] < PARAMETERS["height_min"],
            }
            for j in others:
                apart = np.linalg.norm(self.p[:, j] - p, axis=1)
                own["collision"] = own["collision"] | (apart < 2 * PARAMETERS["radius"])
            earned = gain + passed - 0.002 * np.sum(self.w[:, i] ** 2, axis=1)
            earned = earned - 10.0 * np.any(list(own.values()), axis=0)
            if others:
                earned = earned - self.rivalry * gains[others].mean(axis=0)
            total += earned / len(self.robots)
            failed = {name: failed[name] | own[name] for name in failed}
            prefix = self.robots[i] + "." if others else ""
            np.testing.assert_array_equal(infos[prefix + "gates_passed"], self.racers[i].gates)
            np.testing.assert_allclose(
                infos[prefix + "lap_time"], self.racers[i].lap_time, **TOLERANCE
            )
            speed = np.linalg.norm(self.v[:, i], axis=1)
            np.testing.assert_allclose(infos[prefix + "speed"], speed, **TOLERANCE)
            self.count("passed", passed)
        any_failed = np.any(list(failed.values()), axis=0)
        arrived = np.max([r.gates for r in self.racers], axis=0) >= self.gates
        np.testing.assert_allclose(reward, total, rtol=2e-6, atol=2e-5)
        for name, mask in failed.items():
            np.testing.assert_array_equal(infos[f"failed.{name}"], mask, err_msg=name)
            self.count(name, mask)
        np.testing.assert_array_equal(infos["success"], arrived & ~any_failed)
        self.count("success", arrived & ~any_failed)
        np.testing.assert_array_equal(ended, any_failed | arrived)

    def count(self, name: str, mask: Bools) -> None:
        self.seen[name] = self.seen.get(name, 0) + int(mask.sum())


@pytest.mark.parametrize(
    ("scenario", "robots", "gates", "width"),
    [
        ("racing", ["quad"], 5, 1.4),
        ("racing", ["quad"], 1, 1.4),  # a race of one gate, so that some end
        ("racing_duel", ["red", "blue"], 5, 2.4),
        ("racing_duel", ["red", "blue"], 1, 2.4),
    ],
)
def test_observation_reward_and_ends_equal_numpy(
    scenario: str, robots: list[str], gates: int, width: float
) -> None:
    envs = skybody.make_vec(
        scenario,
        ENVS,
        seed=3,
        num_threads=1,
        overrides=overrides(width, robots, gates),
        dict_observations=True,
        autoreset="disabled",
    )
    oracle = Oracle(envs, robots, gates, 0.5 if len(robots) > 1 else 0.0)
    random = np.random.default_rng(5)
    seen, infos = envs.reset()
    oracle.at_reset(seen, infos, np.ones(ENVS, np.bool_))
    for _ in range(STEPS):
        action = random.uniform(-1.2, 1.2, envs.action_space.shape).astype(np.float32)
        seen, reward, terminated, truncated, infos = envs.step(action)
        clipped = np.clip(action, -1.0, 1.0).reshape(ENVS, -1).astype(np.float64)
        oracle.at_step(seen, infos, clipped, reward, terminated)
        ended = terminated | truncated
        if ended.any():
            seen, infos = envs.reset(options={"reset_mask": ended})
            oracle.at_reset(seen, infos, ended)
    envs.close()
    assert oracle.states >= 10_000
    rare = {"success"} if gates > 1 else set()  # five gates take longer than these flights
    assert min(n for name, n in oracle.seen.items() if name not in rare) >= 5, oracle.seen
