"""Observation, rewards and ends of a shared load against NumPy and SciPy, over 10^4 random states.

The rods are removed, so that load and robots can have any positions and rotations.
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
ROBOTS = ("alpha", "bravo", "charlie")
LIMITS = {
    "tilt_max": 0.55,
    "load_tilt_max": 0.55,
    "bound": 2.8,
    "separation_min": 0.6,
    "height_min": 1.1,
    "success_distance": 0.8,
    "success_yaw": 0.5,
}
WEIGHTS = {
    "load_precision_reward": 3.0,
    "approach_reward": 0.7,
    "precision_reward": 2.0,
    "heading_reward": 0.4,
    "tilt_cost": 0.3,
    "failure_reward": -6.0,
}
OVERRIDES = [
    "couplings=[]",
    "stepping.horizon=12",
    "randomization=[{plugin: start, parameters: {relative: true, position_min: [-0.35, -0.35, -0.3]"
    ", position_max: [0.35, 0.35, 0.3], yaw_min: -3, yaw_max: 3, tilt_max: 0.5, velocity_max: 1.5,"
    " rate_max: 3}}]",
    "task.parameters.target_yaw=2.5",
    "task.parameters.target_min=[-1, -1, 1.2]",
    *(f"task.parameters.{name}={value}" for name, value in {**LIMITS, **WEIGHTS}.items()),
]
# The scenario's robot positions around the load, and the rods' attachment points.
PLACES = np.array([(0.55, 0, 1.1), (-0.275, 0.476, 1.1), (-0.275, -0.476, 1.1)])
ATTACHMENTS = np.array([(0.38, 0, 0.05), (-0.19, 0.33, 0.05), (-0.19, -0.33, 0.05)])


def wrapped(angle: Reals) -> Reals:
    return np.arctan2(np.sin(angle), np.cos(angle))


def near(x: Reals, weight: float) -> Reals:
    return 1.0 / (1.0 + weight * x)


class Moment:
    """Present state of robots and load."""

    def __init__(self, envs: Any) -> None:
        q = envs.state("bodies.rotation")
        self.q = np.where(q[..., :1] < 0, -q, q)
        flat = Rotation.from_quat(q.reshape(-1, 4)[:, [1, 2, 3, 0]]).as_matrix()
        self.matrices = flat.reshape(*q.shape[:2], 3, 3)
        self.p, self.v = envs.state("bodies.position"), envs.state("bodies.velocity")
        self.w = envs.state("bodies.angular_velocity")
        target = np.column_stack([envs.state(f"task.target[{k}]") for k in range(4)])
        self.tilt = np.arccos(np.clip(self.matrices[..., 2, 2], -1.0, 1.0))
        self.yaw = np.arctan2(self.matrices[..., 1, 0], self.matrices[..., 0, 0])
        self.load_error = target[:, :3] - self.p[:, 3]
        self.yaw_error = wrapped(target[:, 3] - self.yaw[:, 3])
        turned = Rotation.from_euler("z", target[:, 3:]).as_matrix()
        places = target[:, None, :3] + np.einsum("nij,kj->nki", turned, PLACES)
        self.place_error = places - self.p[:, :3]
        held = self.p[:, 3, None] + np.einsum("nij,kj->nki", self.matrices[:, 3], ATTACHMENTS)
        self.attachment = held - self.p[:, :3]
        pairs = self.p[:, None, :3] - self.p[:, :3, None]  # [n, seer, seen]
        self.offsets = pairs
        distances = np.linalg.norm(pairs, axis=-1) + np.where(np.eye(3, dtype=bool), np.inf, 0.0)
        self.nearest = distances.min(axis=2)

    def observation(self) -> dict[str, Reals]:
        seen: dict[str, Reals] = {}
        for i, robot in enumerate(ROBOTS):
            own = {
                "place_error": self.place_error[:, i],
                "velocity": self.v[:, i],
                "attitude": self.q[:, i],
                "angular_velocity": self.w[:, i],
                "load_position_error": self.load_error,
                "load_yaw_error": self.yaw_error[:, None],
                "load_velocity": self.v[:, 3],
                "load_attitude": self.q[:, 3],
                "load_angular_velocity": self.w[:, 3],
                "attachment": self.attachment[:, i],
            }
            for j, other in enumerate(ROBOTS):
                if i == j:
                    continue
                own[f"{other}.offset"] = self.offsets[:, i, j]
                own[f"{other}.velocity"] = self.v[:, j]
            seen.update({f"{robot}.{name}".replace(".", "_"): v for name, v in own.items()})
        return seen

    def failures(self) -> dict[str, Bools]:
        return {
            "tilt": (self.tilt[:, :3] > LIMITS["tilt_max"]).any(axis=1),
            "load_tilt": self.tilt[:, 3] > LIMITS["load_tilt_max"],
            "bound": np.abs(self.p).max(axis=(1, 2)) > LIMITS["bound"],
            "separation": self.nearest.min(axis=1) < LIMITS["separation_min"],
            "dropped": self.p[:, 3, 2] < LIMITS["height_min"],
        }

    def rewards(self) -> Reals:
        """For each robot, (n, 3)."""
        far = np.linalg.norm(self.load_error, axis=1)
        load = near(far**2 + self.yaw_error**2, 2.56)
        load = load + WEIGHTS["load_precision_reward"] * near(far, 5.0)
        place = np.linalg.norm(self.place_error, axis=2)
        own = 0.5 * near(place**2, 2.56) + 0.01 * near(np.sum(self.w[:, :3] ** 2, axis=2), 1.0)
        own = own + WEIGHTS["approach_reward"] * np.maximum(0.0, 1.0 - place / 10.0)
        own = own + WEIGHTS["precision_reward"] * near(place, 5.0)
        own = own + WEIGHTS["heading_reward"] * near(self.yaw[:, :3] ** 2, 4.0)
        own -= WEIGHTS["tilt_cost"] * (1.0 / np.maximum(np.cos(self.tilt[:, :3]), 0.1) - 1.0)
        outside = np.abs(self.p) > LIMITS["bound"]
        by_load = (self.tilt[:, 3] > LIMITS["load_tilt_max"]) | outside[:, 3].any(axis=1)
        by_load |= self.p[:, 3, 2] < LIMITS["height_min"]
        failed = by_load[:, None] | (self.tilt[:, :3] > LIMITS["tilt_max"])
        failed |= outside[:, :3].any(axis=2) | (self.nearest < LIMITS["separation_min"])
        return load[:, None] + own + WEIGHTS["failure_reward"] * failed


def test_observation_rewards_and_ends_equal_numpy() -> None:
    envs = skybody.make_vec(
        "cooperative_payload",
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
        found = now.failures()
        failed = np.any(list(found.values()), axis=0)
        distance = np.linalg.norm(now.load_error, axis=1)
        found["success"] = (
            (distance < LIMITS["success_distance"])
            & (np.abs(now.yaw_error) < LIMITS["success_yaw"])
            & ~failed
        )
        for name, mask in found.items():
            info = "success" if name == "success" else f"failed.{name}"
            np.testing.assert_array_equal(infos[info], mask, err_msg=name)
            counts[name] = counts.get(name, 0) + int(mask.sum())
        np.testing.assert_array_equal(terminated, failed)
        own = now.rewards()
        np.testing.assert_allclose(rewards, own.mean(axis=1), rtol=2e-6, atol=1e-5)
        np.testing.assert_allclose(infos["agent_reward"], own, rtol=2e-6, atol=1e-5)
        np.testing.assert_allclose(infos["payload_error"], distance, **TOLERANCE)
        np.testing.assert_allclose(infos["payload_yaw_error"], np.abs(now.yaw_error), **TOLERANCE)
        place = np.linalg.norm(now.place_error, axis=2).max(axis=1)
        np.testing.assert_allclose(infos["place_error"], place, **TOLERANCE)
        np.testing.assert_allclose(infos["nearest_distance"], now.nearest.min(axis=1), **TOLERANCE)
        ended = terminated | truncated
        if ended.any():
            seen, infos = envs.reset(options={"reset_mask": ended})
            states += count_equal(Moment(envs).observation(), seen, ended)
    envs.close()
    assert states >= 10_000
    assert min(counts.values()) >= 10, counts
