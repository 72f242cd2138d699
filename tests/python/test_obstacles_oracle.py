"""Observation, reward and ends of the forest, and ranges of rays, against NumPy.

Every episode has random positions, sizes and presence of a box, a cylinder, a sphere and a capsule.
The oracle finds nearest points by clipping and ranges by marching; the task uses neither.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from swinging import ENVS, TOLERANCE, Motion, Observed, Reals, fly, tilt, yaw

NAMES = ("box", "pole", "ball", "pill")
SEEN, VIEW, RADIUS, SAFE = 3, 1.2, 0.15, 0.4
SUCCESS, LOW = 0.4, 0.3
RAYS, MAX_RANGE = 7, 2.5
WILD = [
    "stepping.horizon=23",
    "stepping.dt=0.001",
    "stepping.action_repeat=5",
    "contact={redraws: 0}",
    "robots.quad.controllers=[{plugin: rotor_speed, parameters: {max_speed: 2300}}]",
    "obstacles=[{name: box, box: [0.5, 0.7, 0.9], position: [0.8, 0, 1], rpy: [0.3, -0.4, 1]}, "
    "{name: pole, cylinder: [0.2, 1.2], position: [-0.8, 0, 1], rpy: [0.7, 0.2, 0]}, "
    "{name: ball, sphere: 0.4, position: [0, 0.9, 1]}, "
    "{name: pill, capsule: [0.2, 0.8], position: [0, -0.9, 1], rpy: [-0.9, 0.3, 0]}]",
    "randomization=[{plugin: start, parameters: {position_min: [-1.8, -1.8, 0.25], "
    "position_max: [1.8, 1.8, 1.9], yaw_min: -3, yaw_max: 3, tilt_max: 1.6, velocity_max: 3, "
    "rate_max: 6}}, {plugin: draw, name: places, parameters: {what: ['obstacles.*.position[*]'], "
    "range: [-0.5, 0.5], form: shift}}, {plugin: draw, name: sizes, parameters: {what: "
    "['obstacles.box.size[*]', 'obstacles.pole.size[0]', 'obstacles.ball.size[0]', "
    "'obstacles.pill.size[0]'], range: [0.7, 1.3], form: scale}}, {plugin: draw, name: there, "
    "parameters: {what: ['obstacles.ball.present', 'obstacles.pill.present'], "
    "distribution: choice, values: [0, 1]}}]",
    f"sensors=[{{plugin: range_finder, name: rays, parameters: {{rays: {RAYS}, field_of_view: 4, "
    f"elevations: [-0.3, 0.2], max_range: {MAX_RANGE}, orientation: [0, 0.2, 0.1]}}}}]",
    "observe=[rays.range]",
    "task.parameters={target_min: [-1, -1, 0.5], target_max: [1, 1, 1.5], yaw_max: 2.5, "
    f"tilt_max: 1.5, bound: 1.7, nearest: {SEEN}, view: {VIEW}, radius: {RADIUS}, "
    f"safe_distance: {SAFE}, success_distance: {SUCCESS}, height_min: {LOW}, progress_reward: 2, "
    "clearance_cost: 0.5, rate_cost: 0.002, success_reward: 4, failure_reward: -3}",
]


class Solids:
    """The obstacles of all environments: positions, rotations, sizes."""

    def __init__(self, envs: Any) -> None:
        def values(path: str, counts: tuple[int, ...]) -> Reals:
            found = np.zeros((ENVS, len(NAMES), max(counts)))
            for i, (name, count) in enumerate(zip(NAMES, counts, strict=True)):
                for k in range(count):
                    found[:, i, k] = envs.state(f"obstacles.{name}.{path}[{k}]").reshape(ENVS)
            return found

        self.place, self.size = values("position", 4 * (3,)), values("size", (3, 2, 1, 2))
        turn = values("rotation", 4 * (4,))[..., [1, 2, 3, 0]]
        matrices = Rotation.from_quat(turn.reshape(-1, 4)).as_matrix()
        self.turn = matrices.reshape(*turn.shape[:2], 3, 3)
        there = [envs.state(f"obstacles.{n}.present").reshape(ENVS) for n in NAMES]
        self.there = np.column_stack(there) > 0.5

    def local(self, p: Reals, k: int) -> Reals:
        """Positions (n, m, 3) in W, transformed to the frame of shape k."""
        return np.einsum("nji,nmj->nmi", self.turn[:, k], p - self.place[:, None, k])

    def nearest(self, p: Reals, k: int) -> tuple[Reals, Reals]:
        """Signed distance (n, m) to the surface of shape k, and the offset to it in W."""
        x, size = self.local(p, k), self.size[:, None, k]
        way, inside = clip(NAMES[k], x, size)
        length = np.linalg.norm(way, axis=2)
        world = np.einsum("nij,nmj->nmi", self.turn[:, k], way)
        return np.where(inside, -length, length), world

    def gaps(self, p: Reals) -> Reals:
        """Distance (n, m) to the nearest surface."""
        every = [
            np.where(self.there[:, None, k], self.nearest(p, k)[0], np.inf)
            for k in range(len(NAMES))
        ]
        return np.min(every, axis=0)


def clip(name: str, x: Reals, size: Reals) -> tuple[Reals, Reals]:
    """The offset from x to the surface in the shape's frame, and a flag: x lies inside."""
    if name == "box":
        half = 0.5 * size
        outside = np.clip(x, -half, half) - x
        depth = half - np.abs(x)
        first = depth == depth.min(axis=2, keepdims=True)
        inside = (depth > 0).all(axis=2)
        inward = np.where(first, np.copysign(depth, x), 0.0)
        return np.where(inside[..., None], inward, outside), inside
    if name == "pole":
        flat = np.stack([np.linalg.norm(x[..., :2], axis=2), np.zeros(x.shape[:2]), x[..., 2]], 2)
        sizes = np.broadcast_to(
            np.concatenate(
                [2 * size[..., :1], np.full_like(size[..., :1], 1e6), size[..., 1:2]], 2
            ),
            flat.shape,
        )
        way, inside = clip("box", flat, sizes)
        outward = x[..., :2] / flat[..., :1]
        return np.concatenate([way[..., :1] * outward, way[..., 2:]], axis=2), inside
    axis = np.zeros_like(x)
    if name == "pill":
        half = 0.5 * size[..., 1]
        axis[..., 2] = np.clip(x[..., 2], -half, half)
    arm = x - axis
    length = np.linalg.norm(arm, axis=2, keepdims=True)
    return arm * (size[..., :1] / length - 1.0), (length < size[..., :1])[..., 0]


class Oracle:
    """Expected outputs of the task and the sensor."""

    def __init__(self) -> None:
        self.distance = np.zeros(ENVS)
        self.states = 0
        self.met = 0

    def look(self, envs: Any) -> None:
        self.solids, self.body = Solids(envs), Motion(envs, 0)
        target = np.column_stack([envs.state(f"task.target[{k}]") for k in range(3)])
        self.error = target - self.body.p
        found = [self.solids.nearest(self.body.p[:, None], k) for k in range(len(NAMES))]
        there = self.solids.there
        self.gap = np.where(there, np.column_stack([f[0][:, 0] for f in found]), np.inf)
        self.ways = np.stack([f[1][:, 0] for f in found], axis=1)

    def compare(self, seen: Observed, action: Reals, mask: Any) -> None:
        body = self.body
        expected = {
            "position_error": self.error,
            "velocity": body.v,
            "attitude": body.q,
            "angular_velocity": body.w,
            "action": action,
        }
        order = np.argsort(self.gap, axis=1)
        for i in range(SEEN):
            k = order[:, i : i + 1]
            near = np.take_along_axis(self.gap, k, 1) < VIEW
            gap = np.where(near, np.take_along_axis(self.gap, k, 1), VIEW)
            way = np.take_along_axis(self.ways, k[..., None], 1)[:, 0]
            size = np.take_along_axis(self.solids.size, k[..., None], 1)[:, 0]
            expected[f"nearest_{i + 1}_distance"] = gap
            expected[f"nearest_{i + 1}_way"] = np.where(near, way, 0.0)
            expected[f"nearest_{i + 1}_size"] = np.where(near, size, 0.0)
        assert set(seen) == {*expected, "rays_range"}
        for name, values in expected.items():
            got = np.asarray(seen[name]).reshape(ENVS, -1)
            np.testing.assert_allclose(got[mask], values[mask], **TOLERANCE, err_msg=name)
        self.states += int(mask.sum())
        self.compare_rays(np.asarray(seen["rays_range"], np.float64))

    def compare_rays(self, ranges: Reals) -> None:
        """Tests that each ray is free up to its range and meets a surface there."""
        rays = [
            (np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e))
            for e in (-0.3, 0.2)
            for a in np.linspace(-2.0, 2.0, RAYS)
        ]
        base = Rotation.from_quat(self.body.q[:, [1, 2, 3, 0]])
        axes = (base * Rotation.from_euler("xyz", [0.0, 0.2, 0.1])).as_matrix()
        along = np.einsum("nij,mj->nmi", axes, np.array(rays))

        def gap(share: float) -> Reals:
            p = self.body.p[:, None] + share * ranges[..., None] * along
            return np.minimum(self.solids.gaps(p), p[..., 2])

        # Ranges are float32: 1.5e-7 m of 2.5 m, twice with the arithmetic here.
        for share in (0.25, 0.5, 0.75, 0.95):
            assert (gap(share)[ranges > 1e-3] > -3e-7).all(), share
        ends = (ranges > 0.0) & (ranges < MAX_RANGE)
        assert np.abs(gap(1.0)[ends]).max() < 3e-7
        assert (gap(0.0)[ranges == 0.0] <= 0.0).all()
        self.met += int(ends.sum())

    def at_reset(self, envs: Any, seen: Observed, infos: dict[str, Any], mask: Any) -> None:
        self.look(envs)
        self.compare(seen, np.full((ENVS, 4), -1.0), mask)
        self.distance = np.where(mask, np.linalg.norm(self.error, axis=1), self.distance)

    def at_step(
        self, envs: Any, seen: Observed, infos: dict[str, Any], action: Any, reward: Any, ended: Any
    ) -> None:
        self.look(envs)
        self.compare(seen, action.astype(np.float64), np.ones(ENVS, np.bool_))
        body, distance = self.body, np.linalg.norm(self.error, axis=1)
        clearance = self.gap.min(axis=1) - RADIUS
        failed = {
            "tilt": tilt(body.q) > 1.5,
            "heading": np.abs(yaw(body.q)) > 2.5,
            "bound": np.abs(body.p).max(axis=1) > 1.7,
            "collision": clearance < 0.0,
            "ground": body.p[:, 2] < LOW,
        }
        fails = np.any(list(failed.values()), axis=0)
        arrived = distance < SUCCESS
        lack = np.clip(1.0 - np.maximum(clearance, 0.0) / SAFE, 0.0, 1.0)
        expected = 2.0 * (self.distance - distance) - 0.5 * lack**2
        expected += -0.002 * np.sum(body.w**2, axis=1)
        expected += np.where(fails, -3.0, np.where(arrived, 4.0, 0.0))
        self.distance = distance
        np.testing.assert_allclose(reward, expected, **TOLERANCE)
        np.testing.assert_array_equal(ended, fails | arrived)
        for name, mask in failed.items():
            np.testing.assert_array_equal(infos[f"failed.{name}"], mask, err_msg=name)
        np.testing.assert_array_equal(infos["success"], arrived & ~fails)
        np.testing.assert_allclose(infos["position_error"], distance, **TOLERANCE)
        np.testing.assert_allclose(infos["clearance"], clearance, **TOLERANCE)
        np.testing.assert_allclose(infos["speed"], np.linalg.norm(body.v, axis=1), **TOLERANCE)


@pytest.fixture(scope="module")
def flown() -> tuple[Oracle, dict[str, int]]:
    oracle = Oracle()
    return oracle, fly("obstacles", WILD, oracle.at_reset, oracle.at_step)


def test_observation_reward_ends_and_ranges_equal_numpy(
    flown: tuple[Oracle, dict[str, int]],
) -> None:
    assert flown[0].states >= 10_000
    assert flown[0].met >= 10_000


def test_every_end_and_success_were_among_the_states(
    flown: tuple[Oracle, dict[str, int]],
) -> None:
    ends = {f"failed.{name}" for name in ("tilt", "heading", "bound", "collision", "ground")}
    assert set(flown[1]) == {*ends, "success"}
    assert min(flown[1].values()) >= 10
