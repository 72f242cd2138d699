"""Helpers for oracles of tasks with a vehicle and a bob: quaternions, wild starts, test flights."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import skybody

Reals = npt.NDArray[np.float64]
ENVS = 100
STEPS = 101  # and as many resets as episode ends: more than 10^4 states
# Observations are float32 (6e-8 of a value) of sums of terms up to about 10.
TOLERANCE: dict[str, Any] = {"rtol": 1e-6, "atol": 2e-6}


def rotate(q: Reals, v: Reals) -> Reals:
    """Rotates v by the rotation matrix of q (w x y z), row by row."""
    w, x, y, z = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    matrix = np.moveaxis(np.array(rows), -1, 0)
    return np.einsum("nij,nj->ni", matrix, np.broadcast_to(v, (len(q), 3)))


def tilt(q: Reals) -> Reals:
    """Angle between the body's z axis and the world's [rad]."""
    return np.arccos(np.clip(rotate(q, np.array([0.0, 0.0, 1.0]))[:, 2], -1.0, 1.0))


def yaw(q: Reals) -> Reals:
    """Heading of the body's x axis in the plane [rad]."""
    nose = rotate(q, np.array([1.0, 0.0, 0.0]))
    return np.arctan2(nose[:, 1], nose[:, 0])


def count_equal(expected: dict[str, Reals], seen: dict[str, Any], mask: Any) -> int:
    """Compares an observation's parts where `mask` holds; returns the number of environments."""
    assert set(seen) == set(expected)
    for name, values in expected.items():
        got = np.asarray(seen[name]).reshape(len(mask), -1)
        np.testing.assert_allclose(got[mask], values[mask], **TOLERANCE, err_msg=name)
    return int(mask.sum())


class Motion:
    """Position, attitude (w >= 0), velocity and angular velocity of a point of a body."""

    def __init__(self, envs: Any, body: int, point: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        q = envs.state("bodies.rotation")[:, body]
        self.w = envs.state("bodies.angular_velocity")[:, body]
        arm = np.array(point)
        self.p = envs.state("bodies.position")[:, body] + rotate(q, arm)
        self.v = envs.state("bodies.velocity")[:, body] + rotate(q, np.cross(self.w, arm))
        self.q = np.where(q[:, :1] < 0.0, -q, q)


Observed = dict[str, npt.NDArray[Any]]
Step = Callable[[Any, Observed, dict[str, Any], npt.NDArray[np.float32] | None], None]


def fly(
    scenario: str,
    overrides: Sequence[str],
    at_reset: Callable[[Any, Observed, dict[str, Any], npt.NDArray[np.bool_]], None],
    at_step: Callable[..., None],
) -> dict[str, int]:
    """Flies random episodes and calls back.

    Arguments of the callback: (envs, observation, infos, mask) after resets, and (envs,
    observation, infos, action, reward, terminated) after steps. Returns how often each failure
    info, and success, was 1.
    """
    options = {"overrides": list(overrides), "dict_observations": True, "autoreset": "disabled"}
    envs = skybody.make_vec(scenario, ENVS, seed=3, num_threads=1, **options)
    random = np.random.default_rng(5)
    seen: dict[str, int] = {}
    observation, infos = envs.reset()
    at_reset(envs, observation, infos, np.ones(ENVS, np.bool_))
    for _ in range(STEPS):
        action = random.uniform(-1.2, 1.2, envs.action_space.shape).astype(np.float32)
        observation, reward, terminated, truncated, infos = envs.step(action)
        assert not infos["fault"].any()
        at_step(envs, observation, infos, np.clip(action, -1.0, 1.0), reward, terminated)
        for name in infos:
            if name.startswith("failed.") or name == "success":
                seen[name] = seen.get(name, 0) + int(infos[name].sum())
        ended = terminated | truncated
        if ended.any():
            observation, infos = envs.reset(options={"reset_mask": ended})
            at_reset(envs, observation, infos, ended)
    envs.close()
    return seen
