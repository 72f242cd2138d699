"""Geometry of a scenario's camera: intrinsics, poses, and pixels of points.

    envs = skybody.make_vec("hover_camera", 128)
    camera = Camera(envs.compiled, "front")
    position, axes = camera.pose(envs)
    pixels, depth = camera.project(points, position, axes)

Camera axes are right, down, forward (along the optical axis). Pixel coordinates are column and row;
the centre of the first pixel is (0.5, 0.5). Equations: sensors/camera/README.md.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._native import CompiledScenario

Reals = NDArray[np.float64]

_CAMERAS = ("camera", "stereo")  # plugins
_BODY_FROM_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


class _HasState(Protocol):
    def state(self, path: str) -> Reals: ...


def _matrices(quaternions: Reals) -> Reals:
    """Rotation matrices (n, 3, 3) of quaternions w x y z (n, 4)."""
    w, x, y, z = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def _of_rpy(roll: float, pitch: float, yaw: float) -> Reals:
    half = 0.5 * np.array([roll, pitch, yaw])
    (cr, cp, cy), (sr, sp, sy) = np.cos(half), np.sin(half)
    quaternion = [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
    return np.asarray(_matrices(np.array([quaternion]))[0])


class Camera:
    """A camera of a scenario, with the mount and lens that the scenario gives it.

    Of a stereo camera it is the left eye. A mount that is drawn per episode is not known here.

    Attributes:
        width, height: of the image [pixels].
        field_of_view: horizontal, without distortion [rad].
        projection: pinhole, fisheye or panorama.
        distortion: coefficients of the lens, as in the scenario.
        focal: focal length [pixels]; of a fisheye and a panorama [pixels per rad].
    """

    def __init__(self, compiled: CompiledScenario, name: str) -> None:
        """Reads the camera called `name`.

        Raises:
            ValueError: no sensor is called so, or it is no camera.
        """
        plugin = compiled.sensors.get(name)
        if plugin not in _CAMERAS:
            cameras = [sensor for sensor, kind in compiled.sensors.items() if kind in _CAMERAS]
            kind = f"is a {plugin}" if plugin else "is no sensor"
            raise ValueError(f"`{name}` {kind}; cameras of the scenario: {cameras}")
        given: dict[str, Any] = compiled.sensor_parameters(name)
        self.width, self.height = int(given["width"][0]), int(given["height"][0])
        self.field_of_view = float(given["field_of_view"][0])
        self.projection = str(given.get("projection", ["pinhole"])[0])
        self.distortion = [float(k) for k in given.get("distortion", [])]
        robot = str(given["robot"][0]) or compiled.robots[0]
        link = str(given["link"][0])
        self._link = f"robots.{robot}." + (f"links.{link}" if link else "base")
        self._position = np.array(given["position"], dtype=float)
        self._axes = _of_rpy(*given["orientation"]) @ _BODY_FROM_CAMERA
        is_pinhole = self.projection == "pinhole"
        half = 0.5 * self.field_of_view
        self.focal = 0.5 * self.width / (np.tan(half) if is_pinhole else half)

    @property
    def intrinsics(self) -> Reals:
        """The matrix K (3, 3) of a pinhole: pixels are K (x / z, y / z, 1), without distortion.

        Raises:
            ValueError: the camera is a fisheye or a panorama.
        """
        if self.projection != "pinhole":
            raise ValueError(f"a {self.projection} has no matrix of intrinsics: use project()")
        center = 0.5 * self.width, 0.5 * self.height
        return np.array([[self.focal, 0.0, center[0]], [0.0, self.focal, center[1]], [0, 0, 1.0]])

    def pose(self, envs: _HasState) -> tuple[Reals, Reals]:
        """Position (n, 3) [m] and axes (n, 3, 3) of the camera, W from camera axes, now.

        Args:
            envs: environments of this scenario: a vector environment, a pool.
        """
        turn = _matrices(envs.state(f"{self._link}.rotation"))
        position = envs.state(f"{self._link}.position")
        return position + turn @ self._position, turn @ self._axes

    def project(self, points: ArrayLike, position: Reals, axes: Reals) -> tuple[Reals, Reals]:
        """Pixel coordinates (..., 2) of points (..., 3) in W [m], and their depths (...) [m].

        Points that no pixel can see have the coordinates NaN: behind a pinhole (depth 0 or less),
        beyond the fold of a distorted one, and exactly behind a fisheye.

        Args:
            points: of one camera.
            position: of that camera (3,), from pose().
            axes: its axes (3, 3), from pose().
        """
        local = (np.asarray(points, dtype=float) - position) @ axes
        x, y, z = np.moveaxis(local, -1, 0)
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.projection == "pinhole":
                u, v = self._distorted(x / z, y / z)
                is_seen = (z > 0) & (self._radial_slope((x * x + y * y) / (z * z)) > 0)
                u, v = np.where(is_seen, u, np.nan), np.where(is_seen, v, np.nan)
            elif self.projection == "fisheye":
                u, v = self._fisheye(x, y, z)
            else:
                u, v = np.arctan2(x, z), np.arctan2(y, np.hypot(x, z))
        pixels = self.focal * np.stack([u, v], axis=-1)
        return pixels + 0.5 * np.array([self.width, self.height]), z

    def _distorted(self, x: Reals, y: Reals) -> tuple[Reals, Reals]:
        """Brown and Conrady's model."""
        k1, k2, p1, p2, k3 = [*self.distortion, 0.0, 0.0, 0.0, 0.0, 0.0][:5]
        s = x * x + y * y
        radial = 1 + s * (k1 + s * (k2 + s * k3))
        return (
            x * radial + 2 * p1 * x * y + p2 * (s + 2 * x * x),
            y * radial + p1 * (s + 2 * y * y) + 2 * p2 * x * y,
        )

    def _radial_slope(self, s: Reals) -> Reals:
        """The slope of a distorted radius, at its square s: above 0 up to the fold."""
        k1, k2, _, _, k3 = [*self.distortion, 0.0, 0.0, 0.0, 0.0, 0.0][:5]
        return np.asarray(1 + s * (3 * k1 + s * (5 * k2 + s * 7 * k3)))

    def _fisheye(self, x: Reals, y: Reals, z: Reals) -> tuple[Reals, Reals]:
        """Kannala and Brandt's model."""
        k = [*self.distortion, 0.0, 0.0, 0.0, 0.0][:4]
        aside = np.hypot(x, y)
        angle = np.arctan2(aside, z)
        s = angle * angle
        radius = angle * (1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))))
        middle = np.where(z > 0, 0.0, np.nan)
        share = np.where(aside > 0, radius / np.where(aside > 0, aside, 1.0), middle)
        return x * share, y * share
