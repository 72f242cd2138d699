"""Observation, rewards of all robots and ends of the chase against NumPy, over 10^4 states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from skybody.multi_agent import ParallelEnv
from swinging import ENVS, TOLERANCE, Motion, Observed, Reals, fly, tilt, yaw

PURSUERS = ("hawk", "kite", "owl")
ROBOTS = (*PURSUERS, "evader")
WEIGHTS = (
    "bound: 2.2, pen: 2, capture_radius: 0.6, separation_min: 0.5, safe_distance: 1.1, "
    "height_min: 0.4, "
    "tilt_max: 1.0, yaw_max: 2.8, progress_reward: 1.5, capture_reward: 3, time_cost: 0.04, "
    "crowd_cost: 0.7, rate_cost: 0.002, failure_reward: -4"
)
WILD = [
    "stepping.horizon=29",
    "stepping.action_repeat=5",
    "contact={redraws: 0}",
    "randomization=[{plugin: start, parameters: {position_min: [-2.1, -2.1, 0.4], "
    "position_max: [2.1, 2.1, 2.1], yaw_min: -2.8, yaw_max: 2.8, tilt_max: 1.15, "
    "velocity_max: 3, rate_max: 4}}]",
    f"task.parameters={{{WEIGHTS}}}",
]


class Oracle:
    """Expected outputs of the chase for a team whose last robot is the evader."""

    def __init__(self, agents: tuple[str, ...]) -> None:
        self.agents = agents
        self.states = 0
        self.distances = np.zeros((ENVS, len(PURSUERS)))

    def compare(self, envs: Any, seen: Observed, mask: Any) -> None:
        self.motion = {name: Motion(envs, k) for k, name in enumerate(ROBOTS)}
        expected: dict[str, Reals] = {}
        for name in self.agents:
            own = self.motion[name]
            expected |= {
                f"{name}_position": own.p,
                f"{name}_velocity": own.v,
                f"{name}_attitude": own.q,
                f"{name}_angular_velocity": own.w,
            }
            if "evader" in self.agents:
                expected[f"{name}_evades"] = np.full((ENVS, 1), float(name == "evader"))
            for other in ROBOTS:
                if other == name:
                    continue
                expected[f"{name}_{other}_offset"] = self.motion[other].p - own.p
                expected[f"{name}_{other}_velocity"] = self.motion[other].v - own.v
        assert set(seen) == set(expected)
        for key, values in expected.items():
            got = np.asarray(seen[key]).reshape(ENVS, -1)
            np.testing.assert_allclose(got[mask], values[mask], **TOLERANCE, err_msg=key)
        self.states += int(mask.sum())

    def now(self) -> Reals:
        p = np.stack([self.motion[name].p for name in PURSUERS], axis=1)
        return np.linalg.norm(p - self.motion["evader"].p[:, None], axis=2)

    def at_reset(self, envs: Any, seen: Observed, infos: dict[str, Any], mask: Any) -> None:
        self.compare(envs, seen, mask)
        self.distances = np.where(mask[:, None], self.now(), self.distances)

    def limits(self, name: str) -> dict[str, Any]:
        body = self.motion[name]
        return {
            "tilt": tilt(body.q) > 1.0,
            "heading": np.abs(yaw(body.q)) > 2.8,
            "bound": np.abs(body.p).max(axis=1) > 2.2,
            "ground": body.p[:, 2] < 0.4,
        }

    def at_step(
        self, envs: Any, seen: Observed, infos: dict[str, Any], action: Any, reward: Any, ended: Any
    ) -> None:
        self.compare(envs, seen, np.ones(ENVS, np.bool_))
        distances, apart = self.now(), np.full((ENVS, len(PURSUERS)), np.inf)
        for i, a in enumerate(PURSUERS):
            for j, b in enumerate(PURSUERS):
                if i == j:
                    continue
                apart[:, i] = np.minimum(
                    apart[:, i], np.linalg.norm(self.motion[a].p - self.motion[b].p, axis=1)
                )
        caught = distances.min(axis=1) < 0.6
        rewards = []
        for i, name in enumerate(PURSUERS):
            fails = np.any(list(self.limits(name).values()), axis=0) | (apart[:, i] < 0.5)
            own = 1.5 * (self.distances[:, i] - distances[:, i]) - 0.04
            own -= 0.7 * np.clip(1.0 - apart[:, i] / 1.1, 0.0, None) ** 2
            own -= 0.002 * np.sum(self.motion[name].w ** 2, axis=1)
            rewards.append(own + np.where(fails, -4.0, np.where(caught, 3.0, 0.0)))
        np.testing.assert_allclose(reward, np.mean(rewards, axis=0), **TOLERANCE)
        if "evader" in self.agents:
            fails = np.any(list(self.limits("evader").values()), axis=0)
            own = 0.04 - 1.5 * (self.distances.min(axis=1) - distances.min(axis=1))
            own -= 0.002 * np.sum(self.motion["evader"].w ** 2, axis=1)
            rewards.append(own + np.where(fails, -4.0, np.where(caught, -3.0, 0.0)))
        np.testing.assert_allclose(infos["agent_reward"], np.transpose(rewards), **TOLERANCE)
        self.distances = distances
        found = {
            limit: np.any([self.limits(name)[limit] for name in PURSUERS], axis=0)
            for limit in ("tilt", "heading", "bound", "ground")
        }
        found["separation"] = apart.min(axis=1) < 0.5
        if "evader" in self.agents:
            found["evader"] = np.any(list(self.limits("evader").values()), axis=0)
        fails = np.any(list(found.values()), axis=0)
        for name, mask in found.items():
            np.testing.assert_array_equal(infos[f"failed.{name}"], mask, err_msg=name)
        np.testing.assert_array_equal(infos["success"], caught & ~fails)
        np.testing.assert_array_equal(ended, caught | fails)
        np.testing.assert_allclose(infos["evader_distance"], distances.min(axis=1), **TOLERANCE)
        np.testing.assert_allclose(infos["pursuers_distance"], apart.min(axis=1), **TOLERANCE)


@pytest.mark.parametrize(("scenario", "agents"), [("chase", PURSUERS), ("chase_agents", ROBOTS)])
def test_observation_reward_and_ends_equal_numpy(scenario: str, agents: tuple[str, ...]) -> None:
    oracle = Oracle(agents)
    counts = fly(scenario, WILD, oracle.at_reset, oracle.at_step)
    assert oracle.states >= 10_000
    assert min(counts.values()) >= 10, counts
    assert ("failed.evader" in counts) == ("evader" in agents)


@pytest.mark.parametrize(("scenario", "agents"), [("chase", PURSUERS), ("chase_agents", ROBOTS)])
def test_agents_are_the_robots_that_act(scenario: str, agents: tuple[str, ...]) -> None:
    env = ParallelEnv(scenario, overrides=("stepping.horizon=40",), seed=4)
    seen, _ = env.reset()
    assert tuple(env.agents) == agents == tuple(seen)
    actions = {a: np.zeros(env.action_space(a).shape, np.float32) for a in env.agents}
    seen, rewards, *_ = env.step(actions)
    assert tuple(seen) == tuple(rewards) == agents
