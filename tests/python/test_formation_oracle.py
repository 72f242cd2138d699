"""Observation, rewards and ends of a formation among obstacles against NumPy and SciPy.

Covers over 10^4 random states.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import skybody
from scipy.spatial.transform import Rotation
from swinging import TOLERANCE, count_equal

Reals = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

ENVS, STEPS = 300, 30
ROBOTS = ("quad1", "quad2", "quad3")
SIGHT, SEEN = 1.3, 3
LIMITS = {"tilt_max": 0.9, "distance_max": 4.2, "separation_min": 0.6, "success_error": 1.0}
WEIGHTS = {
    "approach_reward": 0.7,
    "precision_reward": 2.0,
    "heading_reward": 0.4,
    "tilt_cost": 0.3,
    "failure_reward": -6.0,
}
# A rotated box, a lying capsule, a sphere, and cylinders; one of the cylinders is often absent.
OBSTACLES = (
    "obstacles=[{name: box, box: [0.8, 0.4, 0.5], position: [0.2, 0.9, 1.6], rpy: [0.4, -0.3, 0.8]}"
    ", {name: capsule, capsule: [0.2, 1.1], position: [-0.9, -0.6, 1.5], rpy: [1.5, 0.2, 0]},"
    " {name: ball, sphere: 0.35, position: [0.9, -0.5, 1.2]},"
    " {name: post, cylinder: [0.15, 1.2], position: [-0.4, 0.3, 2.4]},"
    " {name: stump, cylinder: [0.4, 0.5], position: [0.1, 0.1, 0.5], rpy: [0.5, 0, 0]}]"
)
OVERRIDES = [
    OBSTACLES,
    "stepping.horizon=12",
    "randomization=[{plugin: draw, name: there, parameters: {what: [obstacles.post.present],"
    " distribution: choice, values: [0, 1]}}, {plugin: start, parameters:"
    " {position_min: [-1.6, -1.6, 0.6], position_max: [1.6, 1.6, 2.8], yaw_min: -3, yaw_max: 3,"
    " tilt_max: 0.7, velocity_max: 2, rate_max: 3}}]",
    f"task.parameters.obstacle_sight={SIGHT}",
    *(f"task.parameters.{name}={value}" for name, value in {**LIMITS, **WEIGHTS}.items()),
]
ANGLES = 2.0 * np.pi * np.arange(3) / 3.0
PLACES = np.column_stack([np.cos(ANGLES), np.sin(ANGLES), np.zeros(3)])


def near(x: Reals, weight: float) -> Reals:
    return 1.0 / (1.0 + weight * x)


def nearest_point(name: str, size: Reals, p: Reals) -> Reals:
    """Offsets of a shape centred at the origin, (n, 3); by projection onto it."""
    found = p.copy()
    if name == "box":
        return np.clip(p, -size / 2, size / 2)
    if name == "ball":
        radius = np.linalg.norm(p, axis=1)
        return p * np.minimum(1.0, size[:, 0] / radius)[:, None]
    half = size[:, 1] / 2
    if name == "capsule":
        found[:, 2] = np.clip(p[:, 2], -half, half)
        axis = found * np.array([0.0, 0.0, 1.0])
        away = p - axis
        radius = np.linalg.norm(away, axis=1)
        return axis + away * np.minimum(1.0, size[:, 0] / radius)[:, None]
    radius = np.hypot(p[:, 0], p[:, 1])
    found[:, :2] *= np.minimum(1.0, size[:, 0] / radius)[:, None]
    found[:, 2] = np.clip(p[:, 2], -half, half)
    return found


def vector(envs: Any, path: str, size: int) -> Reals:
    return np.column_stack([envs.state(f"{path}[{k}]") for k in range(size)])


class Moment:
    """Present state of robots and obstacles."""

    def __init__(self, envs: Any) -> None:
        q = envs.state("bodies.rotation")
        flat = Rotation.from_quat(q.reshape(-1, 4)[:, [1, 2, 3, 0]]).as_matrix()
        self.matrices = flat.reshape(*q.shape[:2], 3, 3)
        self.p, self.v = envs.state("bodies.position"), envs.state("bodies.velocity")
        self.w = envs.state("bodies.angular_velocity")
        self.target = vector(envs, "task.target", 3)
        self.tilt = np.arccos(np.clip(self.matrices[..., 2, 2], -1.0, 1.0))
        self.offsets = self.p[:, None] - self.p[:, :, None]  # [n, seer, seen]
        self.distances = np.linalg.norm(self.offsets, axis=-1)
        alone = np.where(np.eye(3, dtype=bool), np.inf, self.distances)
        self.nearest = alone.min(axis=2)
        touching = [envs.state(f"robots.{r}.links.base_link.contact.touching") for r in ROBOTS]
        self.touching = np.column_stack(touching) > 0.5
        self.ways = np.stack([self.ways_of(envs, i) for i in range(3)], axis=1)  # [n, i, k, 3]
        self.clear = np.nan_to_num(np.linalg.norm(self.ways, axis=-1), nan=np.inf)

    def ways_of(self, envs: Any, i: int) -> Reals:
        """Offsets to all obstacles, the nearest first; nan for absent ones."""
        ways = []
        for name in ("box", "capsule", "ball", "post", "stump"):
            place = vector(envs, f"obstacles.{name}.position", 3)
            q = vector(envs, f"obstacles.{name}.rotation", 4)
            size = vector(envs, f"obstacles.{name}.size", {"box": 3, "ball": 1}.get(name, 2))
            turn = Rotation.from_quat(q[:, [1, 2, 3, 0]])
            local = turn.inv().apply(self.p[:, i] - place)
            way = turn.apply(nearest_point(name, size, local) - local)
            way[envs.state(f"obstacles.{name}.present") < 0.5] = np.nan
            ways.append(way)
        stacked = np.stack(ways, axis=1)
        order = np.argsort(np.linalg.norm(stacked, axis=-1), axis=1)  # nan comes last
        return np.take_along_axis(stacked, order[..., None], axis=1)

    def observation(self) -> dict[str, Reals]:
        seen: dict[str, Reals] = {}
        for i, robot in enumerate(ROBOTS):
            own = {
                "target_error": self.target - self.p[:, i],
                "velocity": self.v[:, i],
                "rotation": self.matrices[:, i].reshape(-1, 9),
                "angular_velocity": self.w[:, i],
                "place_error": self.target + PLACES[i] - self.p[:, i],
            }
            for j, other in enumerate(ROBOTS):
                if i == j:
                    continue
                own[f"{other}.offset"] = self.offsets[:, i, j]
                own[f"{other}.distance"] = self.distances[:, i, j, None]
                own[f"{other}.velocity"] = self.v[:, j]
                own[f"{other}.rotation"] = self.matrices[:, j].reshape(-1, 9)
            for k in range(SEEN):
                far = self.clear[:, i, k, None]
                cut = np.nan_to_num(self.ways[:, i, k]) * np.minimum(1.0, SIGHT / far)
                own[f"obstacle_{k + 1}.offset"] = cut
                own[f"obstacle_{k + 1}.distance"] = np.minimum(far, SIGHT)
            seen.update({f"{robot}.{name}".replace(".", "_"): v for name, v in own.items()})
        return seen

    def own_failures(self) -> dict[str, Bools]:
        """For each robot, (n, 3)."""
        away = np.linalg.norm(self.p - self.target[:, None], axis=2)
        return {
            "tilt": self.tilt > LIMITS["tilt_max"],
            "distance": away > LIMITS["distance_max"],
            "separation": self.nearest < LIMITS["separation_min"],
            "collision": self.touching,
        }

    def formation_error(self) -> Reals:
        about = self.p - self.p.mean(axis=1, keepdims=True)
        table = np.linalg.norm(about[:, :, None] - PLACES[None, None], axis=-1)
        return np.maximum(table.min(axis=2).max(axis=1), table.min(axis=1).max(axis=1))

    def rewards(self) -> tuple[Reals, Reals]:
        """The team's, (n), and each robot's own, (n, 3)."""
        centroid = self.p.mean(axis=1)
        g = np.exp(-np.linalg.norm(centroid - self.target, axis=1))
        forward = self.matrices[..., 0, 0]
        clear = np.minimum(self.nearest, self.clear[:, :, 0])

        def paper(d: Reals, error: Reals, g: Reals, h: Reals) -> Reals:
            f = near(error**2, 2.56)
            return np.minimum((d / 0.5) ** 2, 1.0) * (f + f * (g + h) + 0.4 * g)

        place = np.linalg.norm(self.target[:, None] + PLACES - self.p, axis=2)
        yaw = np.arctan2(self.matrices[..., 1, 0], self.matrices[..., 0, 0])
        terms = WEIGHTS["approach_reward"] * np.maximum(0.0, 1.0 - place / 10.0)
        terms = terms + WEIGHTS["precision_reward"] * near(place, 5.0)
        terms += WEIGHTS["heading_reward"] * near(yaw**2, 4.0)
        terms -= WEIGHTS["tilt_cost"] * (1.0 / np.maximum(np.cos(self.tilt), 0.1) - 1.0)
        failed = np.any(list(self.own_failures().values()), axis=0)
        terms += WEIGHTS["failure_reward"] * failed
        own_error = np.linalg.norm(self.p - centroid[:, None] - PLACES, axis=2)
        own = paper(clear, own_error, g[:, None], forward) + terms
        team = paper(clear.min(axis=1), self.formation_error(), g, forward.mean(axis=1))
        return team + terms.mean(axis=1), own


def test_observation_rewards_and_ends_equal_numpy() -> None:
    envs = skybody.make_vec(
        "formation_obstacles",
        ENVS,
        seed=3,
        num_threads=1,
        overrides=OVERRIDES,
        dict_observations=True,
        autoreset="disabled",
    )
    random = np.random.default_rng(5)
    seen, infos = envs.reset()
    states = count_equal(Moment(envs).observation(), seen, np.ones(ENVS, np.bool_))
    counts: dict[str, int] = {}
    for _ in range(STEPS):
        action = random.uniform(-1.0, 1.0, envs.action_space.shape).astype(np.float32)
        seen, rewards, terminated, truncated, infos = envs.step(action)
        now = Moment(envs)
        states += count_equal(now.observation(), seen, np.ones(ENVS, np.bool_))
        found = {name: mask.any(axis=1) for name, mask in now.own_failures().items()}
        failed = np.any(list(found.values()), axis=0)
        found["success"] = (now.formation_error() < LIMITS["success_error"]) & ~failed
        for name, mask in found.items():
            info = "success" if name == "success" else f"failed.{name}"
            np.testing.assert_array_equal(infos[info], mask, err_msg=name)
            counts[name] = counts.get(name, 0) + int(mask.sum())
        np.testing.assert_array_equal(terminated, failed)
        team, own = now.rewards()
        np.testing.assert_allclose(rewards, team, rtol=2e-6, atol=1e-5)
        np.testing.assert_allclose(infos["agent_reward"], own, rtol=2e-6, atol=1e-5)
        np.testing.assert_allclose(infos["formation_error"], now.formation_error(), **TOLERANCE)
        nearest = now.nearest.min(axis=1)
        np.testing.assert_allclose(infos["nearest_distance"], nearest, **TOLERANCE)
        ended = terminated | truncated
        if ended.any():
            seen, infos = envs.reset(options={"reset_mask": ended})
            states += count_equal(Moment(envs).observation(), seen, ended)
    envs.close()
    assert states >= 10_000
    assert min(counts.values()) >= 10, counts
