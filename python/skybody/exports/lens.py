"""Matrices of a lens without distortion, as ROS and Foxglove have them."""

from __future__ import annotations


def camera_matrix(focal: float, x: float, y: float) -> list[float]:
    """K: pixels from directions, 3 x 3, row by row.

    Args:
        focal: focal length [pixels].
        x, y: principal point, from the upper left corner of the image [pixels].
    """
    return [focal, 0.0, x, 0.0, focal, y, 0.0, 0.0, 1.0]


def projection_matrix(focal: float, x: float, y: float) -> list[float]:
    """P: pixels from points of a single camera, 3 x 4, row by row; arguments as of K."""
    return [focal, 0.0, x, 0.0, 0.0, focal, y, 0.0, 0.0, 0.0, 1.0, 0.0]


# R: the image is not rectified, 3 x 3, row by row.
NOT_TURNED = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
