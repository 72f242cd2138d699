"""Observation, reward and ends of the pendulum against NumPy, over 10^4 random states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from swinging import ENVS, TOLERANCE, Motion, Observed, Reals, fly, tilt, yaw

TARGET = np.array([0.3, -0.2, 2.4])
DT = 1e-3  # an action is one physics step, so the state before it is the last one seen
HISTORY = 10
CENTER = (0.0, 0.0, 1.07)  # of the bob in the rod's frame [m]
WILD = [
    "stepping.action_repeat=1",
    "stepping.horizon=37",
    f"task.parameters.target=[{', '.join(map(str, TARGET))}]",
    "task.parameters.yaw_max=2.5",
    "task.parameters.success_distance=1.5",
    "randomization=[{plugin: vehicle_constants, parameters: {mass: [0.9, 1.1], tau_up: [0.9, 1.1], "
    "tau_down: [0.9, 1.1]}}, {plugin: start, parameters: {position_min: [-10.5, -10.5, 0.2], "
    "position_max: [10.5, 10.5, 3], yaw_min: -3, yaw_max: 3, tilt_max: 1.7, velocity_max: 3, "
    "rate_max: 6}}, {plugin: draw, name: lean, parameters: {what: "
    "['robots.quad.start.joints.rod_joint.position[*]'], range: [-1.2, 1.2]}}]",
]


class Oracle:
    """Expected outputs of a pendulum task."""

    def __init__(self) -> None:
        self.past: dict[str, Reals] = {}
        self.before: tuple[Motion, Motion] | None = None
        self.distance = np.zeros(ENVS)
        self.states = 0

    def quantities(self, envs: Any, action: Reals | None) -> dict[str, Reals]:
        """The present entry of each history."""
        base, bob = Motion(envs, 0), Motion(envs, 1, CENTER)
        entries = {
            "bob_error": bob.p - TARGET,
            "bob_offset": bob.p - base.p,
            "bob_velocity": bob.v,
            "bob_angular_velocity": bob.w,
            "velocity": base.v,
            "attitude": base.q,
            "angular_velocity": base.w,
            "actions": np.full((ENVS, 4), -1.0) if action is None else action,
        }
        old = self.before if action is not None else None
        for name, now, k in (("base", base, 0), ("bob", bob, 1)):
            change = [(now.v - old[k].v) / DT, (now.w - old[k].w) / DT] if old else [0 * now.v] * 2
            entries[f"{name}_derivative"] = np.hstack(
                [now.v, change[0], quaternion_rate(now.q, now.w), change[1]]
            )
        self.now = (base, bob)
        return entries

    def constants(self, envs: Any) -> Reals:
        link = "robots.quad.links.base_link"
        mass = envs.state(f"{link}.mass")
        inertia = np.column_stack([envs.state(f"{link}.inertia[{k}]") for k in range(3)])
        lags = [
            np.mean([envs.state(f"robots.quad.rotors[{k}].tau_{way}") for k in range(4)], axis=0)
            for way in ("up", "down")
        ]
        return np.column_stack([mass, inertia, *lags])

    def compare(self, envs: Any, seen: Observed, infos: dict[str, Any], mask: Any) -> None:
        privileged = [self.past["base_derivative"], self.past["bob_derivative"]]
        expected = np.hstack([*(p.reshape(ENVS, -1) for p in privileged), self.constants(envs)])
        np.testing.assert_allclose(infos["privileged"][mask], expected[mask], **TOLERANCE)
        for name, values in seen.items():
            past = self.past[name].reshape(ENVS, -1)
            np.testing.assert_allclose(values[mask], past[mask], **TOLERANCE, err_msg=name)
        self.states += int(mask.sum())

    def at_reset(self, envs: Any, seen: Observed, infos: dict[str, Any], mask: Any) -> None:
        for name, entry in self.quantities(envs, None).items():
            fresh = np.repeat(entry[:, None, :], HISTORY, axis=1)
            self.past[name] = np.where(mask[:, None, None], fresh, self.past.get(name, fresh))
        self.before = self.now
        bob = self.now[1]
        self.distance = np.where(mask, np.linalg.norm(bob.p - TARGET, axis=1), self.distance)
        self.compare(envs, seen, infos, mask)

    def at_step(
        self, envs: Any, seen: Observed, infos: dict[str, Any], action: Any, reward: Any, ended: Any
    ) -> None:
        for name, entry in self.quantities(envs, action).items():
            self.past[name] = np.concatenate([entry[:, None, :], self.past[name][:, :-1]], axis=1)
        self.before = self.now
        self.compare(envs, seen, infos, np.ones(ENVS, np.bool_))

        base, bob = self.now
        distance = np.linalg.norm(bob.p - TARGET, axis=1)
        up = (bob.p - base.p)[:, 2] / np.linalg.norm(bob.p - base.p, axis=1)
        failed = {
            "tilt": tilt(base.q) > 1.57,
            "heading": np.abs(yaw(base.q)) > 2.5,
            "bound": np.abs(base.p).max(axis=1) > 10.0,
            "low": base.p[:, 2] < 0.3,
            "fallen": up < 0.2,
        }
        count = np.sum(list(failed.values()), axis=0)
        expected = 2.0 * (self.distance - distance) + 0.01 + up - 5.0 * count
        self.distance = distance
        np.testing.assert_allclose(reward, expected, **TOLERANCE)
        np.testing.assert_array_equal(ended, count > 0)
        for name, mask in failed.items():
            np.testing.assert_array_equal(infos[f"failed.{name}"], mask, err_msg=name)
        np.testing.assert_array_equal(infos["success"], (distance < 1.5) & (count == 0))
        for name, value in (("position_error", distance), ("upright", up), ("tilt", tilt(base.q))):
            np.testing.assert_allclose(infos[name], value, **TOLERANCE, err_msg=name)


def quaternion_rate(q: Reals, w: Reals) -> Reals:
    """dq/dt = 1/2 q (0, w), w in the body's axes."""
    scalar = -np.sum(q[:, 1:] * w, axis=1)
    return 0.5 * np.column_stack([scalar, q[:, :1] * w + np.cross(q[:, 1:], w)])


@pytest.fixture(scope="module")
def flown() -> tuple[Oracle, dict[str, int]]:
    oracle = Oracle()
    return oracle, fly("pendulum", WILD, oracle.at_reset, oracle.at_step)


def test_observation_reward_and_ends_equal_numpy(flown: tuple[Oracle, dict[str, int]]) -> None:
    assert flown[0].states >= 10_000


def test_every_end_and_success_were_among_the_states(
    flown: tuple[Oracle, dict[str, int]],
) -> None:
    ends = ("failed.tilt", "failed.heading", "failed.bound", "failed.low", "failed.fallen")
    assert set(flown[1]) == {*ends, "success"}
    assert min(flown[1].values()) >= 10
