"""Observation, reward and ends of the landing against NumPy and SciPy, over 10^4 random states."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import skybody
from scipy.spatial.transform import Rotation
from swinging import TOLERANCE, count_equal

Reals = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

ENVS, STEPS = 300, 40
STEP_TIME = 0.02  # s
# Limits that wild starts about the deck often exceed; touchdown limits are loose and contact is
# rare.
LIMITS = {
    "touch_height": 0.15,
    "rest_speed": 0.9,
    "rest_tilt": 0.5,
    "inset": 0.2,
    "crash_speed": 1.3,
    "crash_tilt": 0.7,
    "distance_max": 1.6,
    "time_max": 0.18,
    "tilt_max": 1.2,
    "yaw_max": 2.9,
    "bound": 1.25,
}
WEIGHTS = {
    "progress_reward": 3.0,
    "approach_rate": 0.7,
    "speed_cost": 0.2,
    "rate_cost": 0.01,
    "landing_reward": 7.0,
    "failure_reward": -4.0,
}
OVERRIDES = [
    "stepping.horizon=11",
    "randomization=[{plugin: start, name: quads, parameters: {robot: quad, "
    "position_min: [-1.3, -1.3, 0.45], position_max: [1.3, 1.3, 1.3], yaw_min: -3.1, yaw_max: 3.1, "
    "tilt_max: 0.9, velocity_max: 1.6, rate_max: 3}}, {plugin: start, name: pads, parameters: "
    "{robot: pad, relative: true, position_min: [-0.1, -0.1, -0.1], position_max: [0.1, 0.1, 0.1], "
    "yaw_min: -1, yaw_max: 1}}]",
    *(f"task.parameters.{name}={value}" for name, value in {**LIMITS, **WEIGHTS}.items()),
]
# Shapes of the model's URDF: a box of 0.3 x 0.35 x 0.05 m, 5 mm above the frame, and four feet.
BOX = np.array([(x, y, z) for x in (-0.15, 0.15) for y in (-0.175, 0.175) for z in (-0.02, 0.03)])
FEET = np.array([(x, y, -0.05) for x in (-0.1016, 0.1016) for y in (-0.127, 0.127)])
FOOT_RADIUS = 0.01
DECK_HALF, DECK_TOP = 0.6, 0.03


def matrices(q: Reals) -> Reals:
    found: Reals = Rotation.from_quat(q[:, [1, 2, 3, 0]]).as_matrix()
    return found


class Moment:
    """Present state of robot and deck, in deck axes unless stated otherwise."""

    def __init__(self, envs: Any) -> None:
        q = envs.state("bodies.rotation")
        p, v = envs.state("bodies.position"), envs.state("bodies.velocity")
        w = envs.state("bodies.angular_velocity")
        base, deck = matrices(q[:, 0]), matrices(q[:, 1])
        self.world, self.world_position, self.rates = base, p[:, 0], w[:, 0]
        top = p[:, 1] + DECK_TOP * deck[:, :, 2]
        self.position = np.einsum("nji,nj->ni", deck, p[:, 0] - top)
        turning = np.cross(np.einsum("nij,nj->ni", deck, w[:, 1]), p[:, 0] - p[:, 1])
        self.velocity = np.einsum("nji,nj->ni", deck, v[:, 0] - v[:, 1] - turning)
        self.rotation = np.einsum("nji,njk->nik", deck, base)
        corners = np.einsum("nk,ck->nc", self.rotation[:, 2], BOX)
        feet = np.einsum("nk,ck->nc", self.rotation[:, 2], FEET) - FOOT_RADIUS
        self.height = self.position[:, 2] + np.concatenate([corners, feet], axis=1).min(axis=1)
        self.speed = np.linalg.norm(self.velocity, axis=1)
        lowest = np.column_stack([self.position[:, :2], np.maximum(self.height, 0.0)])
        self.distance = np.linalg.norm(lowest, axis=1)
        self.tilt = np.arccos(np.clip(self.rotation[:, 2, 2], -1.0, 1.0))

    def over_deck(self, inset: float) -> Bools:
        inside: Bools = (np.abs(self.position[:, :2]) <= DECK_HALF - inset).all(axis=1)
        return inside

    def observation(self, action: Reals) -> dict[str, Reals]:
        attitude = Rotation.from_matrix(self.rotation).as_quat(canonical=True)[:, [3, 0, 1, 2]]
        return {
            "position_error": -np.column_stack([self.position[:, :2], self.height]),
            "velocity": self.velocity,
            "yaw_error": -np.arctan2(self.rotation[:, 1, 0], self.rotation[:, 0, 0])[:, None],
            "attitude": attitude,
            "angular_velocity": self.rates,
            "action": action,
        }


def failures(now: Moment, before: Moment, time: Reals) -> tuple[dict[str, Bools], Bools]:
    """End conditions by name, including a landing."""
    world = now.world
    touches = (now.height < LIMITS["touch_height"]) & now.over_deck(0.0)
    hard = (before.speed > LIMITS["crash_speed"]) | (now.tilt > LIMITS["crash_tilt"])
    found = {
        "tilt": np.arccos(np.clip(world[:, 2, 2], -1, 1)) > LIMITS["tilt_max"],
        "heading": np.abs(np.arctan2(world[:, 1, 0], world[:, 0, 0])) > LIMITS["yaw_max"],
        "bound": np.abs(now.world_position).max(axis=1) > LIMITS["bound"],
        "crash": touches & hard,
        "outside": (now.position[:, 2] < 0)
        | (np.linalg.norm(now.position, axis=1) > LIMITS["distance_max"]),
    }
    rests = (now.speed <= LIMITS["rest_speed"]) & (now.tilt <= LIMITS["rest_tilt"])
    failed = np.any(list(found.values()), axis=0)
    landed = touches & rests & now.over_deck(LIMITS["inset"]) & ~failed
    found["time"] = (time >= LIMITS["time_max"] - 1e-9) & ~landed
    return found, landed


def reward(now: Moment, before: Moment, landed: Bools, failed: Bools) -> Reals:
    allowed = LIMITS["rest_speed"] + WEIGHTS["approach_rate"] * now.distance
    value: Reals = (
        WEIGHTS["progress_reward"] * (before.distance - now.distance)
        - WEIGHTS["speed_cost"] * np.maximum(now.speed - allowed, 0.0)
        - WEIGHTS["rate_cost"] * np.sum(now.rates**2, axis=1)
        + WEIGHTS["landing_reward"] * landed
        + WEIGHTS["failure_reward"] * failed
    )
    return value


def test_observation_reward_and_ends_equal_numpy() -> None:
    envs = skybody.make_vec(
        "landing",
        ENVS,
        seed=3,
        num_threads=1,
        overrides=OVERRIDES,
        dict_observations=True,
        autoreset="disabled",
    )
    random = np.random.default_rng(5)
    everywhere = np.ones(ENVS, np.bool_)
    seen, infos = envs.reset()
    before = Moment(envs)
    states = count_equal(before.observation(np.full((ENVS, 4), -1.0)), seen, everywhere)
    steps = np.zeros(ENVS)
    counts: dict[str, int] = {}
    for _ in range(STEPS):
        action = random.uniform(-1.2, 1.2, envs.action_space.shape).astype(np.float32)
        seen, rewards, terminated, truncated, infos = envs.step(action)
        steps += 1
        now = Moment(envs)
        clipped = np.clip(action, -1.0, 1.0).astype(np.float64)
        states += count_equal(now.observation(clipped), seen, everywhere)
        found, landed = failures(now, before, steps * STEP_TIME)
        failed = np.any(list(found.values()), axis=0)
        expected = reward(now, before, landed, failed)
        np.testing.assert_allclose(rewards, expected, rtol=2e-6, atol=1e-5)
        for name, mask in {**found, "success": landed}.items():
            info = "success" if name == "success" else f"failed.{name}"
            np.testing.assert_array_equal(infos[info], mask, err_msg=name)
            counts[name] = counts.get(name, 0) + int(mask.sum())
        np.testing.assert_array_equal(terminated, failed | landed)
        np.testing.assert_allclose(infos["position_error"], now.distance, **TOLERANCE)
        np.testing.assert_allclose(infos["speed"], now.speed, **TOLERANCE)
        ended = terminated | truncated
        if ended.any():
            seen, infos = envs.reset(options={"reset_mask": ended})
            steps[ended] = 0
            now = Moment(envs)
            states += count_equal(now.observation(np.full((ENVS, 4), -1.0)), seen, ended)
        before = now
    envs.close()
    assert states >= 10_000
    assert min(counts.values()) >= 10, counts
