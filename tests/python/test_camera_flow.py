"""Optical flow of cameras against differences of projected points."""

from __future__ import annotations

import numpy as np
import skybody
from numpy.typing import NDArray
from reference import actions
from scipy.spatial.transform import Rotation
from skybody.vector import SkybodyVectorEnv

N = 3
SIZE = 32
EYE = np.array([0.1, 0.02, 0.05])  # in the base
BODY_FROM_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
FOCAL = SIZE / 2  # a field of view of 90 degrees
OTHER = 3  # instance of the second robot
EPSILON = 1e-5  # s; differences have errors of 1e-5 and less

Reals = NDArray[np.float64]


def envs() -> SkybodyVectorEnv:
    """Two robots; the first one's camera looks at the second, which is 1 m ahead."""
    camera = (
        "{plugin: camera, name: eye, parameters: {robot: quad1, outputs: [flow, depth, instance], "
        f"width: {SIZE}, height: {SIZE}, position: {EYE.tolist()}}}}}"
    )
    return skybody.make_vec(
        "formation_2",
        N,
        seed=5,
        overrides=[
            "stepping={dt: 0.001, action_repeat: 10, horizon: 40}",
            "randomization=[]",
            "robots.quad1.pose.position=[0,0,2]",
            "robots.quad2.pose.position=[1,0.1,2.1]",
            f"sensors=[{camera}]",
            "observe=[eye.flow, eye.depth, eye.instance]",
        ],
    )


class Body:
    """Poses and velocities of a robot's base in environment k."""

    def __init__(self, envs: SkybodyVectorEnv, robot: str, k: int) -> None:
        base = f"robots.{robot}.base"
        self.position = envs.state(f"{base}.position")[k]
        self.turn = Rotation.from_quat(envs.state(f"{base}.rotation")[k][[1, 2, 3, 0]])
        self.velocity = envs.state(f"{base}.velocity")[k]
        self.rate = self.turn.apply(envs.state(f"{base}.angular_velocity")[k])

    def after(self, time: float) -> tuple[Reals, Rotation]:
        return (
            self.position + self.velocity * time,
            Rotation.from_rotvec(self.rate * time) * self.turn,
        )

    def moved(self, points: Reals, time: float) -> Reals:
        """Points of the body after a time."""
        position, turn = self.after(time)
        return position + turn.apply((self.turn.inv()).apply(points - self.position))


def project(camera: Body, points: Reals, time: float) -> Reals:
    position, turn = camera.after(time)
    local = turn.inv().apply(points - position) - EYE
    x, y, z = (local @ BODY_FROM_CAMERA).T
    return FOCAL * np.stack([x / z, y / z], axis=-1)


def expected_flow(envs: SkybodyVectorEnv, k: int, depth: Reals, instance: Reals) -> Reals:
    camera, other = Body(envs, "quad1", k), Body(envs, "quad2", k)
    across = (np.arange(SIZE) + 0.5 - SIZE / 2) / FOCAL
    x, y = np.meshgrid(across, across)
    local = np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3) * depth.reshape(-1, 1)
    points = camera.position + camera.turn.apply(local @ BODY_FROM_CAMERA.T + EYE)
    is_other = (instance == OTHER).reshape(-1, 1)
    before, after = (
        project(camera, np.where(is_other, other.moved(points, t), points), t)
        for t in (-EPSILON, EPSILON)
    )
    return ((after - before) / (2 * EPSILON)).reshape(SIZE, SIZE, 2)


def test_flow_is_the_velocity_of_projected_points() -> None:
    vector = envs()
    vector.reset()
    seen_other = 0
    for step in range(12):
        observation = vector.step(actions(step, N, 8))[0]
        for k in range(N):
            depth = observation["eye_depth"][k].astype(float)
            instance = observation["eye_instance"][k]
            seen_other += int(np.sum(instance == OTHER))
            flow = expected_flow(vector, k, depth, instance)
            is_seen = (instance > 0)[..., None]
            scale = np.abs(flow).max() + 1.0
            error = np.abs(observation["eye_flow"][k] - flow) * is_seen
            assert np.max(error) < 2e-4 * scale  # depths are float32: 1e-5 of them
    assert seen_other > 200


def test_the_skys_flow_is_the_cameras_turning_alone() -> None:
    vector = envs()
    vector.reset()
    observation = vector.step(actions(0, N, 8))[0]
    for k in range(N):
        camera = Body(vector, "quad1", k)
        sky = observation["eye_instance"][k] == 0
        assert np.any(sky)
        far = np.full((SIZE, SIZE), 1e7)
        flow = expected_flow(vector, k, far, np.zeros((SIZE, SIZE)))
        scale = np.linalg.norm(camera.rate) * FOCAL + 1.0
        error = np.abs(observation["eye_flow"][k] - flow)[sky]
        assert np.max(error) < 1e-3 * scale
