"""The shapes of a flight's world, for formats that draw it."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from skybody import InputError
from skybody.look.flight import Array, Flight, rotation_of
from skybody.look.scene import (
    BLADE,
    Fixed,
    blade_radii,
    fixed_to_body,
    lines_of_couplings,
    standing,
)
from skybody.look.shapes import CAPSULE, CYLINDER, GROUND, SPHERE, towards

from .frames import WORLD, frame_of
from .table import Block, Table

LINES_RATE = 30.0  # of the lines of couplings, per second


@dataclass(frozen=True)
class Part:
    """Shapes that are fixed to a frame."""

    name: str  # distinct
    frame: str
    shapes: tuple[Fixed, ...]  # of kinds BOX, SPHERE, CYLINDER and MESH


class World:
    """Bodies with their rotors, obstacles as the episode has them, and couplings.

    Without the scenario's files there are none, and a line on stderr says so.
    """

    def __init__(self, table: Table) -> None:
        self.parts: list[Part] = []
        self.has_lines = False
        self._flight = table.flight
        self._due = -np.inf  # time of the next lines [s]
        if "bodies" not in table.series:
            return
        try:
            self.parts = list(parts_of(table.flight, table.series["bodies"].items))
            self.has_lines = bool(table.flight.compiled.couplings)
        except InputError as error:
            print(f"note: without shapes: {str(error).splitlines()[0]}", file=sys.stderr)

    def lines(self, block: Block) -> Iterator[dict[str, list[Array]] | None]:
        """Points of each coupling by its name, W [m], in each row; None: they are not due."""
        for time, bodies in zip(block.time.tolist(), block.real("bodies"), strict=True):
            if time < self._due or not np.isfinite(bodies).all():
                yield None
                continue
            self._due = time + 1.0 / LINES_RATE
            yield lines_of_couplings(self._flight, bodies[:, :3], rotation_of(bodies[:, 3:7]))


def parts_of(flight: Flight, bodies: Iterable[str]) -> Iterator[Part]:
    """The shapes of each body and the obstacles. Raises InputError without the scenario's files."""
    fixed = [*map(fixed_to_body, flight.compiled.visuals), *discs(flight)]
    for k, body in enumerate(bodies):
        if shapes := simple(shape for shape in fixed if shape.body == k):
            yield Part(body, frame_of(body), shapes)
    if obstacles := simple(standing(flight.compiled, flight.drawn)):
        yield Part("obstacles", WORLD, obstacles)


def discs(flight: Flight) -> Iterator[Fixed]:
    """A thin disc for each rotor."""
    rotors = flight.compiled.rotors
    radii = blade_radii(rotors)
    for rotor in rotors:
        half = (radii[rotor.name], radii[rotor.name], 0.001)
        axes = towards(np.array(rotor.axis))
        yield Fixed(CYLINDER, rotor.body, np.array(rotor.position), axes, half, BLADE)


def simple(shapes: Iterable[Fixed]) -> tuple[Fixed, ...]:
    """The shapes without planes, and with capsules in three parts."""
    found = []
    for shape in shapes:
        if shape.kind == CAPSULE:
            radius, _, half = shape.half
            found.append(replace(shape, kind=CYLINDER))
            for side in (-half, half):
                place = shape.position + side * shape.axes[:, 2]
                ball = (radius, radius, radius)
                found.append(replace(shape, kind=SPHERE, position=place, half=ball))
        elif shape.kind != GROUND:
            found.append(shape)
    return tuple(found)
