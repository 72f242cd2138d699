"""Lenses and errors of cameras: distortion, fisheyes, panoramas, noise of depth, holes, colours."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import skybody
from numpy.typing import NDArray
from reference import actions
from scipy.spatial.transform import Rotation
from skybody.camera import Camera
from skybody.vector import SkybodyVectorEnv

N = 3
WIDTH, HEIGHT = 40, 30
BODY_FROM_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
FARTHEST = 50.0
BALL = "{name: ball, sphere: 0.6, position: [9, 0.5, 1.5]}"


def envs_of(outputs: str = "range", **parameters: Any) -> SkybodyVectorEnv:
    given = {"width": WIDTH, "height": HEIGHT, "max_range": FARTHEST, **parameters}
    words = ", ".join(f"{key}: {value}" for key, value in given.items())
    names = ", ".join(f"eye.{name.strip()}" for name in outputs.split(","))
    overrides = [
        "stepping={dt: 0.001, action_repeat: 10, horizon: 12}",
        f"sensors=[{{plugin: camera, name: eye, parameters: {{outputs: [{outputs}], {words}}}}}]",
        f"observe=[{names}]",
        f"obstacles=[{BALL}]",
    ]
    return skybody.make_vec("hover", N, seed=3, overrides=overrides)


def pixel_grid(focal: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Image coordinates of pixels' centres, in focal lengths."""
    u = (np.arange(WIDTH) + 0.5 - WIDTH / 2) / focal
    v = (np.arange(HEIGHT) + 0.5 - HEIGHT / 2) / focal
    return tuple(np.meshgrid(u, v))  # type: ignore[return-value]


def ground_ranges(envs: SkybodyVectorEnv, rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ranges to the ground along rays (rows, columns, 3) in camera axes."""
    rays = rays / np.linalg.norm(rays, axis=-1, keepdims=True) @ BODY_FROM_CAMERA.T
    position = envs.state("robots.quad.base.position")
    rotation = envs.state("robots.quad.base.rotation")
    turn = Rotation.from_quat(rotation[:, [1, 2, 3, 0]]).as_matrix()
    along = np.einsum("nij,rcj->nrci", turn, rays)
    with np.errstate(divide="ignore"):
        ranges = -position[:, None, None, 2] / along[..., 2]
    return np.minimum(np.where(ranges > 0, ranges, FARTHEST), FARTHEST)


def check_ground(envs: SkybodyVectorEnv, rays: NDArray[np.float64]) -> None:
    """Compares ranges where the camera sees ground or nothing."""
    observation, _ = envs.reset()
    for step in range(4):
        is_ball = observation["eye_instance"] == 3
        close = np.isclose(observation["eye_range"], ground_ranges(envs, rays), rtol=1e-4)
        assert np.mean(close | is_ball) > 0.998, "all but pixels at the horizon"
        observation = envs.step(actions(step, N))[0]


def distorted(x: Any, y: Any, k: list[float]) -> tuple[Any, Any]:
    """The model of Brown and Conrady, as OpenCV documents it (calib3d, `projectPoints`)."""
    k1, k2, p1, p2, k3 = k
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    return (
        x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
        y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
    )


def undistorted(u: Any, v: Any, k: list[float]) -> tuple[Any, Any]:
    """By Newton's method with a numeric Jacobian."""
    x, y, h = u.copy(), v.copy(), 1e-6
    for _ in range(30):
        a, b = distorted(x, y, k)
        ax, bx = (
            (p - q) / (2 * h)
            for p, q in zip(distorted(x + h, y, k), distorted(x - h, y, k), strict=True)
        )
        ay, by = (
            (p - q) / (2 * h)
            for p, q in zip(distorted(x, y + h, k), distorted(x, y - h, k), strict=True)
        )
        det = ax * by - ay * bx
        x -= (by * (a - u) - ay * (b - v)) / det
        y -= (ax * (b - v) - bx * (a - u)) / det
    return x, y


def test_distortion_is_that_of_brown_and_conrady() -> None:
    k = [-0.28, 0.07, 0.001, -0.0005, 0.002]
    envs = envs_of("range, instance", distortion=k, field_of_view=1.2)
    u, v = pixel_grid(WIDTH / 2 / np.tan(0.6))
    x, y = undistorted(u, v, k)
    check_ground(envs, np.stack([x, y, np.ones_like(x)], axis=-1))


@pytest.mark.parametrize("k", [[], [-0.02, 0.003, 0.0, 0.0]])
def test_a_fisheye_is_that_of_kannala_and_brandt(k: list[float]) -> None:
    envs = envs_of("range, instance", projection="fisheye", distortion=k, field_of_view=3.6)
    u, v = pixel_grid(WIDTH / 3.6)
    radius = np.hypot(u, v)
    angles = np.linspace(0.0, np.pi, 200001)
    k4 = [*k, 0.0, 0.0, 0.0, 0.0][:4]
    radii = angles * (1 + sum(c * angles ** (2 * i + 2) for i, c in enumerate(k4)))
    angle = np.interp(radius, radii, angles)
    rays = np.stack(
        [np.sin(angle) * u / radius, np.sin(angle) * v / radius, np.cos(angle)], axis=-1
    )
    check_ground(envs, rays)


def test_a_panorama_has_equal_angles_between_pixels() -> None:
    envs = envs_of("range, instance", projection="panorama", field_of_view=4.0)
    u, v = pixel_grid(WIDTH / 4.0)
    check_ground(envs, np.stack([np.cos(v) * np.sin(u), np.sin(v), np.cos(v) * np.cos(u)], -1))


def check_projection(envs: SkybodyVectorEnv, rays: NDArray[np.float64]) -> None:
    """Points along the rays of pixels are projected to the pixels' centres."""
    envs.reset()
    camera = Camera(envs.compiled, "eye")
    positions, axes = camera.pose(envs)
    column, row = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
    for position, turn in zip(positions, axes, strict=True):
        points = position + 7.0 * rays @ turn.T
        pixels, depth = camera.project(points, position, turn)
        np.testing.assert_allclose(pixels[..., 0], column, atol=1e-3)
        np.testing.assert_allclose(pixels[..., 1], row, atol=1e-3)
        np.testing.assert_allclose(depth, 7.0 * rays[..., 2], atol=1e-9)


def test_projected_points_are_in_their_pixels() -> None:
    u, v = pixel_grid(WIDTH / 2 / np.tan(0.6))
    check_projection(envs_of(field_of_view=1.2), np.stack([u, v, np.ones_like(u)], axis=-1))
    k = [-0.28, 0.07, 0.001, -0.0005, 0.002]
    x, y = undistorted(u, v, k)
    rays = np.stack([x, y, np.ones_like(x)], axis=-1)
    check_projection(envs_of(field_of_view=1.2, distortion=k), rays)
    u, v = pixel_grid(WIDTH / 3.6)
    angle = np.hypot(u, v)
    rays = np.stack([np.sin(angle) * u / angle, np.sin(angle) * v / angle, np.cos(angle)], axis=-1)
    check_projection(envs_of(projection="fisheye", field_of_view=3.6), rays)


def test_a_camera_that_is_none_is_named() -> None:
    envs = envs_of()
    with pytest.raises(ValueError, match=r"`nose` is no sensor; cameras .*: \['eye'\]"):
        Camera(envs.compiled, "nose")


def test_depth_noise_has_its_standard_deviation() -> None:
    noisy, clean = envs_of("depth", depth_noise=[0.01, 0.02, 0.003]), envs_of("depth")
    noisy.reset(), clean.reset()
    samples = []
    for step in range(6):
        a = noisy.step(actions(step, N))[0]["eye_depth"].astype(float)
        b = clean.step(actions(step, N))[0]["eye_depth"].astype(float)
        np.testing.assert_array_equal(a[b == FARTHEST], FARTHEST)
        seen = b < 10.0
        samples.append(((a - b) / (0.01 + 0.02 * b + 0.003 * b * b))[seen])
    sample = np.concatenate(samples)
    assert sample.size > 2000
    assert abs(np.std(sample) - 1.0) < 0.07  # four standard errors of 2,000 draws
    assert abs(np.mean(sample)) < 0.09


def test_depths_behind_a_fisheye_keep_their_sign_with_noise() -> None:
    lens = {"projection": "fisheye", "field_of_view": 6.0}
    noisy = envs_of("depth", depth_noise=[0.001, 0.0, 0.0], **lens).reset()[0]["eye_depth"]
    clean = envs_of("depth", **lens).reset()[0]["eye_depth"]
    behind = clean < -0.1
    assert np.sum(behind) > 50
    np.testing.assert_allclose(noisy[behind], clean[behind], atol=0.006)
    assert np.any(noisy[behind] != clean[behind])


def test_a_lens_that_spreads_strongly_is_not_folded() -> None:
    k = [5.0, 0.0]
    envs = envs_of("range, instance", distortion=k, field_of_view=1.8)
    u, v = pixel_grid(WIDTH / 2 / np.tan(0.9))
    radius = np.hypot(u, v)
    radii = np.linspace(0.0, 2.0, 400001)
    inner = np.interp(radius, radii * (1 + 5.0 * radii**2), radii)
    check_ground(envs, np.stack([u * inner / radius, v * inner / radius, np.ones_like(u)], -1))


def test_depth_has_its_resolution_if_asked_for() -> None:
    observation, _ = envs_of("depth", depth_resolution=0.25).reset()
    depth = observation["eye_depth"][observation["eye_depth"] < FARTHEST]
    np.testing.assert_array_equal(depth % 0.25, 0.0)


def test_holes_are_at_edges_only() -> None:
    holed, clean = envs_of("depth, instance", edge_holes=1.0), envs_of("depth, instance")
    a, b = holed.reset()[0], clean.reset()[0]
    new = (a["eye_depth"] == FARTHEST) & (b["eye_depth"] < FARTHEST)
    assert np.sum(new) > 10
    padded = np.pad(b["eye_depth"], ((0, 0), (1, 1), (1, 1)), mode="edge")
    beside = [
        padded[:, 1 + r : 1 + r + HEIGHT, 1 + c : 1 + c + WIDTH]
        for r, c in ((1, 0), (-1, 0), (0, 1), (0, -1))
    ]
    jump = np.max([np.abs(o - b["eye_depth"]) / np.minimum(o, b["eye_depth"]) for o in beside], 0)
    np.testing.assert_array_equal(new, (jump > 0.05) & (b["eye_depth"] < FARTHEST))


def test_noise_of_colours_has_its_standard_deviation() -> None:
    noisy, clean = envs_of("rgb", rgb_noise=0.02), envs_of("rgb")
    a, b = noisy.reset()[0]["eye_rgb"].astype(float), clean.reset()[0]["eye_rgb"].astype(float)
    middle = (b > 40) & (b < 215)  # nothing is cut there
    deviation = np.std((a - b)[middle]) / 255.0
    # A rounded normal variable: the variance of rounding, 1 / 12, is on top.
    assert abs(deviation - np.hypot(0.02, np.sqrt(1 / 12) / 255)) < 0.001


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"field_of_view": 3.5}, "allowed: 0.01 to 3 rad for `projection: pinhole`"),
        ({"distortion": [0.0] * 6}, "`distortion` has 6 values; allowed for `projection: pinhole`"),
        ({"distortion": [-2.0, 0.0]}, "folds the image: no direction has pixel"),
        ({"projection": "panorama", "field_of_view": 6.28}, "a panorama ends at the zenith"),
        (
            {"projection": "panorama", "outputs": "depth", "field_of_view": 2.0},
            "a panorama has no optical axis: name range",
        ),
        ({"edge_holes": 0.5, "outputs": "rgb"}, "`edge_holes` needs depth or range"),
    ],
)
def test_a_camera_that_cannot_be_is_refused(parameters: dict[str, Any], message: str) -> None:
    given = {"outputs": "range", **parameters}
    with pytest.raises(skybody.InputError, match=message):
        envs_of(**given)
