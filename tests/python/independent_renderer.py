"""Pictures of triangles by Embree (through trimesh): a reference that shares no code with ours.

Round shapes are meshes so fine that their depths are right to 2e-5. Every shape is a mesh of unit
size; rays are brought into its frame and size, which leaves their parameter as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import trimesh
from numpy.typing import NDArray

Reals = NDArray[np.float64]
Ids = NDArray[np.int64]


@cache
def unit(kind: str) -> trimesh.Trimesh:
    """A cube of edge 1; a sphere, and a cylinder of length 1, of radius 1; 4 km^2 of ground."""
    makers: dict[str, Callable[[], trimesh.Trimesh]] = {
        "cube": lambda: trimesh.creation.box([1.0, 1.0, 1.0]),
        # Edges of 0.5 degrees: triangles are at most 1.3e-5 of the radius below the surface.
        "sphere": lambda: trimesh.creation.icosphere(subdivisions=7),
        "cylinder": lambda: trimesh.creation.cylinder(1.0, 1.0, sections=1024),
        "ground": lambda: trimesh.Trimesh(
            [[-1e3, -1e3, 0], [1e3, -1e3, 0], [1e3, 1e3, 0], [-1e3, 1e3, 0]],
            [[0, 1, 2], [0, 2, 3]],
        ),
    }
    return makers[kind]()


@dataclass
class Part:
    """A mesh at a pose and scale in each of n environments."""

    mesh: trimesh.Trimesh
    instance: int
    position: Reals  # (n, 3)
    turn: Reals  # (n, 3, 3), W from the part's axes
    scale: Reals  # (n, 3)
    present: NDArray[np.bool_]  # (n,)

    def shifted(self, offset: Reals, scale: Reals, mesh: trimesh.Trimesh) -> Part:
        """Another part at an offset (n, 3) in this one's axes."""
        place = self.position + np.einsum("nij,nj->ni", self.turn, offset)
        return Part(mesh, self.instance, place, self.turn, scale, self.present)


def parts_of_gate(frame: Part, size: Reals) -> list[Part]:
    """Four bars about an opening: width along y, height along z, thickness of the bars."""
    width, height, thick = size.T
    zero = np.zeros_like(width)
    upright = np.stack([thick, thick, height + 2 * thick], axis=-1)
    level = np.stack([thick, width, thick], axis=-1)
    cube = unit("cube")
    parts = []
    for side in (-0.5, 0.5):
        beside = np.stack([zero, side * (width + thick), zero], axis=-1)
        above = np.stack([zero, zero, side * (height + thick)], axis=-1)
        parts += [frame.shifted(beside, upright, cube), frame.shifted(above, level, cube)]
    return parts


def parts_of(kind: str, frame: Part, size: Reals) -> list[Part]:
    """The meshes of an obstacle. `size` (n, ...) has the meaning of docs/scenarios.md."""
    none = np.zeros((len(size), 3))
    if kind == "box":
        return [frame.shifted(none, size, unit("cube"))]
    if kind == "sphere":
        return [frame.shifted(none, np.repeat(size, 3, axis=1), unit("sphere"))]
    if kind == "gate":
        return parts_of_gate(frame, size)
    radius, length = size.T
    tube = frame.shifted(none, np.stack([radius, radius, length], axis=-1), unit("cylinder"))
    if kind == "cylinder":
        return [tube]
    ends = [np.stack([0 * length, 0 * length, side * length], axis=-1) for side in (-0.5, 0.5)]
    ball = np.repeat(radius[:, None], 3, axis=1)
    return [tube, *(frame.shifted(end, ball, unit("sphere")) for end in ends)]


def nearest_of(part: Part, which: Ids, eyes: Reals, along: Reals) -> Reals:
    """Parameters of the first hits of rays eye + t along; inf: none.

    Args:
        which: the environment of each ray.
    """
    found = np.full(len(which), np.inf)
    # Rays that pass the part's bounding sphere are left out.
    reach = np.max(np.linalg.norm(part.mesh.vertices, axis=1)) * np.max(part.scale, axis=1)
    to_middle = part.position[which] - eyes
    crossing = np.cross(to_middle, along)
    inside = np.sum(crossing**2, axis=1) <= (1.01 * reach[which]) ** 2 * np.sum(along**2, axis=1)
    chosen = np.flatnonzero(inside & part.present[which])
    if chosen.size == 0:
        return found
    env = which[chosen]
    turn, scale = part.turn[env], part.scale[env]
    origin = -np.einsum("nji,nj->ni", turn, to_middle[chosen]) / scale
    direction = np.einsum("nji,nj->ni", turn, along[chosen]) / scale
    _, hits, places = part.mesh.ray.intersects_id(
        origin, direction, multiple_hits=False, return_locations=True
    )
    run = np.sum((places - origin[hits]) * direction[hits], axis=1)
    found[chosen[hits]] = run / np.sum(direction[hits] ** 2, axis=1)
    return found


def cast(
    parts: list[Part], which: Ids, eyes: Reals, along: Reals, farthest: float
) -> tuple[Reals, Ids]:
    """Parameters and instances of what rays see first, up to `farthest`; 0: nothing."""
    depth, ids = np.full(len(which), farthest), np.zeros(len(which), dtype=np.int64)
    for part in parts:
        found = nearest_of(part, which, eyes, along)
        nearer = found < depth
        depth[nearer], ids[nearer] = found[nearer], part.instance
    return depth, ids
