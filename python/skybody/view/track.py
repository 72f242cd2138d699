"""The rows of a flight in its page."""

from __future__ import annotations

from typing import Any

import numpy as np

from skybody.look.motion import Array

from .pack import Packer
from .samples import Samples


def track_of(samples: Samples, packer: Packer) -> dict[str, Any]:
    """Poses, rotor speeds, goals and series, packed."""
    poses = steady(samples.poses)
    return {
        "time": packer.add(samples.time),
        "poses": packer.add(poses.reshape(len(poses), -1)),
        "rotor_speed": packer.add(samples.rotor_speed) if samples.rotor_speed.size > 0 else None,
        "goals": {name: packer.add(goal) for name, goal in samples.goals.items()},
        "series": [
            {"name": one.name, "unit": one.unit, "values": packer.add(one.values)}
            for one in samples.series
        ],
        "touching": packer.add(samples.touching),
    }


def steady(poses: Array) -> Array:
    """Poses whose quaternions do not jump between the two signs of a rotation.

    Args:
        poses: rows x bodies x 7.
    """
    turned = np.sum(poses[1:, :, 3:] * poses[:-1, :, 3:], axis=-1) < 0.0
    signs = np.where(np.cumsum(turned, axis=0) % 2 == 1, -1.0, 1.0)
    found = poses.copy()
    found[1:, :, 3:] *= signs[..., None]
    return found
