"""Lidars: ranges in closed form, the same as cameras' and range finders', points, noise, losses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import skybody
from numpy.typing import NDArray
from reference import actions
from scipy.spatial.transform import Rotation
from skybody.vector import SkybodyVectorEnv

N = 4
COLUMNS = 48
RINGS = np.radians([-40.0, -10.0, 0.0, 25.0])
FARTHEST = 30.0
PLACE = np.array([0.05, -0.02, 0.08])  # in the base
HALF = np.array([6.0, 4.0, 3.0])  # of the room, whose middle is at (0, 0, 3)
# The room's walls, floor and ceiling, as planes with normals inwards.
WALLS = (
    "{name: east, plane: true, position: [6, 0, 3], rpy: [0, -1.5707963267948966, 0]}",
    "{name: west, plane: true, position: [-6, 0, 3], rpy: [0, 1.5707963267948966, 0]}",
    "{name: north, plane: true, position: [0, 4, 3], rpy: [1.5707963267948966, 0, 0]}",
    "{name: south, plane: true, position: [0, -4, 3], rpy: [-1.5707963267948966, 0, 0]}",
    "{name: ceiling, box: [20, 20, 1], position: [0, 0, 6.5]}",
)
THINGS = (
    "{name: ball, sphere: 0.6, position: [3, 0.5, 1.5]}",
    "{name: crate, box: [1, 0.8, 1], position: [-2, 2, 0.5], rpy: [0, 0, 0.6]}",
    "{name: tree, capsule: [0.2, 3], position: [1, -3, 1.7]}",
)
STEPPING = "stepping={dt: 0.001, action_repeat: 10, horizon: 12}"


def sensor(plugin: str, name: str, **parameters: Any) -> str:
    given = {"position": PLACE.tolist(), "max_range": FARTHEST, **parameters}
    words = ", ".join(f"{key}: {value}" for key, value in given.items())
    return f"{{plugin: {plugin}, name: {name}, parameters: {{{words}}}}}"


def lidar(outputs: str = "range", **parameters: Any) -> str:
    rings = {"columns": COLUMNS, "elevations": RINGS.tolist(), "outputs": f"[{outputs}]"}
    return sensor("lidar", "scan", **{**rings, **parameters})


def envs_of(
    sensors: list[str], observe: str, obstacles: tuple[str, ...] = WALLS, **options: Any
) -> SkybodyVectorEnv:
    overrides = [
        STEPPING,
        f"sensors=[{', '.join(sensors)}]",
        f"observe=[{observe}]",
        f"obstacles=[{', '.join(obstacles)}]",
    ]
    return skybody.make_vec("hover", N, seed=3, overrides=overrides, **options)


def directions() -> NDArray[np.float64]:
    """Unit vectors (rings, columns, 3) in the sensor's axes."""
    turn = 2 * np.pi * np.arange(COLUMNS) / COLUMNS
    rise, turn = np.broadcast_arrays(RINGS[:, None], turn[None, :])
    return np.stack([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)], -1)


def rays_of(envs: SkybodyVectorEnv) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Origins (n, 3) and directions (n, rings, columns, 3) in W."""
    position = envs.state("robots.quad.base.position")
    rotation = envs.state("robots.quad.base.rotation")
    turn = Rotation.from_quat(rotation[:, [1, 2, 3, 0]]).as_matrix()
    return (
        position + np.einsum("nij,j->ni", turn, PLACE),
        np.einsum("nij,rcj->nrci", turn, directions()),
    )


def in_room(envs: SkybodyVectorEnv) -> NDArray[np.float64]:
    """Ranges to the walls of the room."""
    origin, along = rays_of(envs)
    origin = (origin - [0, 0, 3])[:, None, None, :]
    with np.errstate(divide="ignore"):
        return np.min((np.sign(along) * HALF - origin) / along, axis=-1)


def test_ranges_in_a_room_are_the_distances_to_its_walls() -> None:
    envs = envs_of([lidar()], "scan.range")
    observation, _ = envs.reset()
    for step in range(5):
        np.testing.assert_allclose(observation["scan_range"], in_room(envs), rtol=1e-5)
        observation = envs.step(actions(step, N))[0]


def test_a_lidar_and_a_range_finder_agree_ray_by_ray() -> None:
    finder = sensor("range_finder", "finder", rays=COLUMNS, elevations=RINGS.tolist())
    envs = envs_of([lidar(), finder], "scan.range, finder.range", THINGS)
    observation, _ = envs.reset()
    for step in range(5):
        fast = observation["scan_range"].reshape(N, -1)
        exact = observation["finder_range"].reshape(N, -1)
        agree = np.isclose(fast, exact, rtol=2e-5)
        assert np.mean(agree) > 0.995, "all but rays at edges"
        observation = envs.step(actions(step, N))[0]


@pytest.mark.parametrize("axes", ["sensor", "world"])
def test_points_are_along_their_rays(axes: str) -> None:
    envs = envs_of([lidar("range, points", axes=axes)], "scan.range, scan.points")
    observation, _ = envs.reset()
    ranges = observation["scan_range"][..., None].astype(float)
    origin, along = rays_of(envs)
    expected = directions() * ranges
    if axes == "world":
        expected = origin[:, None, None, :] + along * ranges
    np.testing.assert_allclose(observation["scan_points"], expected, atol=2e-5)


def test_points_do_not_need_ranges_as_an_output() -> None:
    both = envs_of([lidar("range, points")], "scan.points")
    alone = envs_of([lidar("points")], "scan.points")
    np.testing.assert_array_equal(both.reset()[0]["scan_points"], alone.reset()[0]["scan_points"])


def test_intensity_falls_with_the_cosine_of_incidence() -> None:
    """A wall of one colour: the ratio of intensities is that of cosines."""
    wall = ("{name: wall, box: [1, 40, 40], position: [6.5, 0, 3]}",)
    envs = envs_of([lidar("intensity, instance")], "scan.intensity, scan.instance", wall)
    observation, _ = envs.reset()
    cosine = np.abs(rays_of(envs)[1][..., 0])
    east = observation["scan_instance"] == 3  # behind the ground and the robot
    assert np.sum(east) > 20
    ratio = observation["scan_intensity"][east] / cosine[east]
    np.testing.assert_allclose(ratio, np.median(ratio), rtol=1e-4)


@pytest.mark.parametrize("farthest", [30.0, 12.7])  # 12.7 is less in float32
def test_noise_has_its_standard_deviation_and_spares_rays_without_a_return(
    farthest: float,
) -> None:
    noise = {"noise": 0.02, "noise_share": 0.01, "max_range": farthest}
    noisy = envs_of([lidar(**noise)], "scan.range", ())
    clean = envs_of([lidar(max_range=farthest)], "scan.range", ())
    nothing = np.float64(np.float32(farthest))
    errors = []
    noisy.reset(), clean.reset()
    for step in range(8):
        a = noisy.step(actions(step, N))[0]["scan_range"].astype(float)
        b = clean.step(actions(step, N))[0]["scan_range"].astype(float)
        np.testing.assert_array_equal(a[b == nothing], nothing)
        hit = (b < 0.8 * farthest) & (b > 1.0)
        errors.append(((a - b) / (0.02 + 0.01 * b))[hit])
    sample = np.concatenate(errors)
    # 800 draws or more: the deviation is known to 2.5 %, the mean to 0.035.
    assert sample.size > 800
    assert abs(np.std(sample) - 1.0) < 0.09
    assert abs(np.mean(sample)) < 0.13


def test_lost_rays_read_the_farthest_range_and_nothing() -> None:
    envs = envs_of([lidar("range, instance", ray_dropout=0.3)], "scan.range, scan.instance")
    observation, _ = envs.reset()
    lost = observation["scan_range"] == FARTHEST
    np.testing.assert_array_equal(lost, observation["scan_instance"] == 0)
    assert 0.2 < np.mean(lost) < 0.4  # of 768 rays: five standard deviations


def test_scans_are_the_same_on_any_number_of_threads() -> None:
    settings = lidar("range, points, intensity", noise=0.01, ray_dropout=0.1, latency=13, period=5)
    one, two = (
        envs_of([settings], "scan.range, scan.points, scan.intensity", THINGS, num_threads=threads)
        for threads in (1, 2)
    )
    one.reset(), two.reset()
    for step in range(10):
        first, second = one.step(actions(step, N))[0], two.step(actions(step, N))[0]
        for key, values in first.items():
            np.testing.assert_array_equal(values, second[key])


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"outputs": "rang"}, "unknown image rang: choose from range, points"),
        ({"outputs": ""}, "`outputs` is empty: name one or more"),
        ({"angles": "[0.1, 0.2, 0.3]"}, "`angles` has 3 values; needed: pairs"),
        ({"elevations": "[]"}, "`elevations` is empty: give one or more"),
        ({"columns": 65536, "elevations": [0.0] * 17}, "has 1114112 rays; allowed"),
    ],
)
def test_a_scan_that_cannot_be_is_refused(parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(skybody.InputError, match=message.replace("(", r"\(")):
        envs_of([lidar(**parameters)], "scan.range")
