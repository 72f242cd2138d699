"""The world of a flight for the page: shapes of bodies, rotors, couplings and obstacles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from skybody import CompiledScenario
from skybody.look.scene import (
    ARROW,
    BLADES_SHOWN,
    Fixed,
    blade_radii,
    fixed_to_body,
    standing,
)
from skybody.look.shapes import BOX, CAPSULE, CYLINDER, GROUND, MESH, SPHERE

from .pack import Packer, rounded
from .samples import bases_of

NAMES = {
    BOX: "box",
    SPHERE: "sphere",
    CYLINDER: "cylinder",
    CAPSULE: "capsule",
    GROUND: "plane",
    MESH: "mesh",
}


def world_of(
    compiled: CompiledScenario, drawn: Mapping[str, float], body_names: list[str], packer: Packer
) -> dict[str, Any]:
    """The parts of a flight that its page draws; lengths in metres, axes of the body or W.

    Args:
        drawn: values of the episode's parameters by path.
        body_names: ROBOT.LINK of each body.
    """
    return {
        "bodies": body_names,
        "robots": [{"name": name, "first": first} for name, first in bases_of(body_names).items()],
        "shapes": [shape_of(fixed_to_body(v), packer) for v in compiled.visuals],
        "obstacles": [shape_of(fixed, packer) for fixed in standing(compiled, drawn)],
        "rotors": rotors_of(compiled),
        "couplings": couplings_of(compiled, drawn),
        "arrow": ARROW,
        "blades_shown": BLADES_SHOWN,
    }


def shape_of(fixed: Fixed, packer: Packer) -> dict[str, Any]:
    """A shape fixed to a body, or to the world (body -1)."""
    shape: dict[str, Any] = {
        "kind": NAMES[fixed.kind],
        "body": fixed.body,
        "position": rounded(fixed.position),
        "axes": rounded(fixed.axes),
        "half": rounded(fixed.half),
        "color": rounded(fixed.color),
    }
    if fixed.corners is not None:
        shape["corners"] = packer.add(fixed.corners.reshape(-1, 3))
    return shape


def rotors_of(compiled: CompiledScenario) -> list[dict[str, Any]]:
    """Hubs, axes, and radii of the drawn blades."""
    radii = blade_radii(compiled.rotors)
    return [
        {
            "name": rotor.name,
            "body": rotor.body,
            "position": rounded(rotor.position),
            "axis": rounded(rotor.axis),
            "direction": rotor.direction,
            "radius": rounded(radii[rotor.name])[0],
            "thrust": float(rotor.thrust_constant),
        }
        for rotor in compiled.rotors
    ]


def couplings_of(compiled: CompiledScenario, drawn: Mapping[str, float]) -> list[dict[str, Any]]:
    """Rods, ropes and springs that are present in the episode."""
    found = []
    for coupling in compiled.couplings:
        path = f"couplings.{coupling.name}."
        if not drawn.get(path + "present", 1.0) or coupling.kind == "point":
            continue
        found.append(
            {
                "kind": coupling.kind,
                "bodies": list(coupling.bodies),
                "points": [rounded(point) for point in coupling.points],
                "length": drawn.get(path + "length", 0.0),
            }
        )
    return found
