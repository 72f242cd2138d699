"""The rows of a flight in its page."""

from __future__ import annotations

from typing import Any

from skybody.look.motion import continuous

from .pack import Packer
from .samples import Samples


def track_of(samples: Samples, packer: Packer) -> dict[str, Any]:
    """Poses, rotor speeds, goals and series, packed."""
    poses = samples.poses.copy()
    poses[..., 3:] = continuous(poses[..., 3:])
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
