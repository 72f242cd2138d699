"""A camera, a ball and the ground: depths in closed form, for tests of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import skybody
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from skybody.vector import SkybodyVectorEnv

Reals = NDArray[np.float64]
Frames = dict[str, NDArray[Any]]

N = 6
K = 10  # physics steps per action
SIZE = 24
BALL = np.array([9.0, 0.5, 1.5])
RADIUS = 0.6
EYE = np.array([0.1, 0.0, 0.05])  # in the base
BODY_FROM_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
GROUND, QUAD, BALL_ID = 1, 2, 3  # instances
FARTHEST = 100.0

BALL_OBSTACLE = f"obstacles=[{{name: ball, sphere: {RADIUS}, position: {BALL.tolist()}}}]"
SCENE = (f"stepping={{dt: 0.001, action_repeat: {K}, horizon: 12}}", BALL_OBSTACLE)
# Each action is one physics step of 5 ms.
SINGLE_STEPS = ("stepping={dt: 0.005, action_repeat: 1, horizon: 1000}", BALL_OBSTACLE)


def sensor(plugin: str, name: str, **parameters: Any) -> str:
    words = ", ".join(f"{key}: {value}" for key, value in parameters.items())
    return f"{{plugin: {plugin}, name: {name}, parameters: {{{words}}}}}"


def camera(name: str = "eye", images: str = "depth, instance", **parameters: Any) -> str:
    given = {"width": SIZE, "height": SIZE, "position": EYE.tolist(), **parameters}
    return sensor("camera", name, outputs=f"[{images}]", **given)


def overrides(cameras: Sequence[str], observe: str, scene: Sequence[str] = SCENE) -> list[str]:
    return [*scene, f"sensors=[{', '.join(cameras)}]", f"observe=[{observe}]"]


def envs_of(
    cameras: Sequence[str] = (camera(),),
    observe: str = "eye.depth, eye.instance",
    num_envs: int = N,
    scene: Sequence[str] = SCENE,
    scenario: str = "hover",
    **options: Any,
) -> SkybodyVectorEnv:
    return skybody.make_vec(
        scenario, num_envs, seed=3, overrides=overrides(cameras, observe, scene), **options
    )


def copied(observation: Frames) -> Frames:
    return {key: values.copy() for key, values in observation.items()}


def matrices(rotation: Reals) -> Reals:
    """Rotation matrices (n, 3, 3) of quaternions w x y z (n, 4)."""
    return np.asarray(Rotation.from_quat(rotation[:, [1, 2, 3, 0]]).as_matrix())


def pixel_rays(size: int = SIZE) -> Reals:
    """Directions (rows, columns, 3) of a square image of 90 degrees, body axes, 1 along the optical
    axis."""
    across = (np.arange(size) + 0.5 - size / 2) / (size / 2)
    x, y = np.meshgrid(across, across)
    return np.stack([x, y, np.ones_like(x)], axis=-1) @ BODY_FROM_CAMERA.T


def pose_of(envs: Any, body: str = "robots.quad.base") -> tuple[Reals, Reals]:
    """Positions (n, 3) and quaternions (n, 4) of a body."""
    return envs.state(f"{body}.position"), envs.state(f"{body}.rotation")


def expected_depths(
    position: Reals, rotation: Reals, ball: Reals = BALL, radius: float = RADIUS
) -> tuple[Reals, NDArray[np.bool_]]:
    """Depths (n, rows, columns) of ground and ball from the pose of the camera's body, and which
    pixels see the ball.

    Args:
        ball: its place, of all (3,) or of each environment (n, 3).
    """
    turn = matrices(rotation)
    eyes = position + turn @ EYE
    along = np.einsum("nij,rcj->nrci", turn, pixel_rays())
    with np.errstate(divide="ignore", invalid="ignore"):
        ground = -eyes[:, None, None, 2] / along[..., 2]
        to_ball = eyes - ball
        a = np.sum(along**2, axis=-1)
        b = np.einsum("nrci,ni->nrc", along, to_ball)
        c = np.sum(to_ball**2, axis=-1)[:, None, None] - radius**2
        near = (-b - np.sqrt(b * b - a * c)) / a
    ground = np.where(ground > 0, ground, np.inf)
    near = np.where(near > 0, near, np.inf)
    return np.minimum(np.minimum(ground, near), FARTHEST), near < ground


def agreement(frames: Frames, depth: Reals, sees_ball: NDArray[np.bool_]) -> Reals:
    """The share of pixels (n,) of each environment with the expected depth and instance."""
    close = np.isclose(frames["eye_depth"], depth, rtol=2e-5)
    same = (frames["eye_instance"] == BALL_ID) == sees_ball
    return np.asarray(np.mean(close & same, axis=(1, 2)))


# All but pixels at the edge of the ball, where float and double may differ: 2 of 576.
AGREE = 0.996


def check_frame(observation: Frames, envs: Any, ball: Reals = BALL) -> None:
    """Checks the frames of all environments against the poses of now."""
    share = agreement(observation, *expected_depths(*pose_of(envs), ball))
    assert np.all(share > AGREE), share
