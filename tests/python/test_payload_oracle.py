"""Observation, reward and ends of the payload task against NumPy, over 10^4 random states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from swinging import ENVS, TOLERANCE, Motion, Observed, fly, tilt, yaw

TARGET = np.array([0.3, -0.2, 0.8])
CENTER = (0.0, 0.0, -0.07)  # of the bob in its frame [m]
WILD = [
    "stepping.horizon=23",
    f"task.parameters.target=[{', '.join(map(str, TARGET))}]",
    "task.parameters.success_distance=1.5",
    "randomization[1].parameters={robot: quad, position_min: [-7.2, -7.2, 1.3], "
    "position_max: [7.2, 7.2, 4], yaw_min: -2, yaw_max: 2, tilt_max: 1.7, velocity_max: 2, "
    "rate_max: 4}",
]


class Oracle:
    """Expected outputs of a payload task."""

    def __init__(self) -> None:
        self.states = 0

    def compare(self, envs: Any, seen: Observed, action: Any, mask: Any) -> None:
        base, bob = Motion(envs, 0), Motion(envs, 2, CENTER)
        expected = {
            "payload_error": bob.p - TARGET,
            "payload_offset": bob.p - base.p,
            "attitude": base.q,
            "velocity": base.v,
            "angular_velocity": base.w,
            "payload_velocity": bob.v,
            "payload_angular_velocity": bob.w,
            "action": action,
        }
        assert set(seen) == set(expected)
        for name, values in expected.items():
            np.testing.assert_allclose(seen[name][mask], values[mask], **TOLERANCE, err_msg=name)
        self.now = (base, bob)
        self.states += int(mask.sum())

    def at_reset(self, envs: Any, seen: Observed, infos: dict[str, Any], mask: Any) -> None:
        self.compare(envs, seen, np.full(envs.action_space.shape, -1.0), mask)

    def at_step(
        self, envs: Any, seen: Observed, infos: dict[str, Any], action: Any, reward: Any, ended: Any
    ) -> None:
        self.compare(envs, seen, action, np.ones(ENVS, np.bool_))
        base, bob = self.now
        failed = {
            "tilt": tilt(base.q) > 1.57,
            "heading": np.abs(yaw(base.q)) > 1.57,
            "bound": np.abs(base.p).max(axis=1) > 7.0,
        }
        any_failed = np.any(list(failed.values()), axis=0)
        distance = np.linalg.norm(bob.p - TARGET, axis=1)
        turning = np.sum(base.w**2, axis=1) + np.sum(bob.w**2, axis=1)
        flown = 1.0 / (1.0 + 1.6 * distance**2) + 0.1 / (1.0 + turning)
        np.testing.assert_allclose(reward, np.where(any_failed, -50.0, flown), **TOLERANCE)
        np.testing.assert_array_equal(ended, any_failed)
        for name, mask in failed.items():
            np.testing.assert_array_equal(infos[f"failed.{name}"], mask, err_msg=name)
        np.testing.assert_array_equal(infos["success"], (distance < 1.5) & ~any_failed)
        np.testing.assert_allclose(infos["payload_error"], distance, **TOLERANCE)


@pytest.mark.parametrize("scenario", ["payload", "payload_modular"])
def test_observation_reward_and_ends_equal_numpy(scenario: str) -> None:
    oracle = Oracle()
    seen = fly(scenario, WILD, oracle.at_reset, oracle.at_step)
    assert oracle.states >= 10_000
    assert set(seen) == {"failed.tilt", "failed.heading", "failed.bound", "success"}
    assert min(seen.values()) >= 10
