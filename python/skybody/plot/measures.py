"""Values of tasks that a flight's poses give: distances between robots, swing, height."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from skybody.look.flight import Array, rotation_of
from skybody.look.scene import half_of
from skybody.look.shapes import BOX, SPHERE

from .subject import Subject, Track

TOUCHED = 0.01  # height over a deck at which a contact is with it [m]


def separation(subject: Subject) -> Array | None:
    """Smallest distance between the bases of two robots with rotors [m]; None: one robot."""
    bases = [subject.base(name)[:, :3] for name in subject.flown]
    pairs = [np.linalg.norm(a - b, axis=1) for a, b in combinations(bases, 2)]
    return np.asarray(np.min(pairs, axis=0)) if pairs else None


def swing(subject: Subject) -> list[tuple[Track, Array]]:
    """Bodies with a goal that hang from their robot, with the angle from straight down [deg]."""
    found = []
    for track in subject.tracks:
        if track.angles is None:
            below = track.position - subject.base(track.name.split(".")[0])[:, :3]
            length = np.linalg.norm(below, axis=1)
            cosine = -below[:, 2] / np.maximum(length, 1e-9)
            found.append((track, np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))))
    return found


def unpowered(subject: Subject) -> list[str]:
    """Robots without rotors, such as decks and loads, in a flight of others."""
    return [name for name in subject.robots if name not in subject.flown] if subject.flown else []


def carried(subject: Subject) -> list[str]:
    """Robots without rotors that a coupling joins to something."""
    if subject.problem:
        return []
    joined = {body for coupling in subject.flight.compiled.couplings for body in coupling.bodies}
    places = {name: range(first, first + n) for name, (first, n) in subject.robots.items()}
    return [name for name in unpowered(subject) if joined & set(places[name])]


def tilt(subject: Subject) -> list[tuple[str, Array]]:
    """Carried loads, with the angle of their z axis from the vertical [deg]."""
    found = []
    for name in carried(subject):
        up = rotation_of(subject.base(name)[:, 3:7])[:, 2, 2]
        found.append((name, np.degrees(np.arccos(np.clip(up, -1.0, 1.0)))))
    return found


def decks(subject: Subject) -> list[str]:
    """Robots without rotors that nobody carries."""
    if subject.problem:
        return []
    held = carried(subject)
    return [name for name in unpowered(subject) if name not in held]


def extent(subject: Subject, robot: str) -> tuple[float, float]:
    """Lowest and highest z of a base's collision shapes in its frame [m]."""
    body = subject.robots[robot][0]
    low, high = [], []
    for shape in subject.flight.compiled.shapes:
        if shape.body != body:
            continue
        kind = {"box": BOX, "sphere": SPHERE}.get(shape.kind)
        half = half_of(kind, shape.size)[2] if kind is not None else 0.0
        low.append(shape.position[2] - half)
        high.append(shape.position[2] + half)
    return (min(low), max(high)) if low else (0.0, 0.0)


def height_over_deck(subject: Subject) -> list[tuple[str, Array]]:
    """Robots with rotors, with the height of their lowest point over the deck's top [m], level."""
    found = []
    for deck in decks(subject)[:1]:
        top = subject.base(deck)[:, 2] + extent(subject, deck)[1]
        for name in subject.flown:
            found.append((name, subject.base(name)[:, 2] + extent(subject, name)[0] - top))
    return found


def touch_down(subject: Subject) -> list[tuple[float, str]]:
    """Time and vertical speed, relative to the deck, of the first contact on it."""
    found = []
    for name, height in height_over_deck(subject):
        rows = np.flatnonzero(subject.contact & (height < TOUCHED))
        if len(rows) and rows[0] > 0:
            deck = subject.base(decks(subject)[0])
            before = rows[0] - 1
            speed = abs(subject.base(name)[before, 9] - deck[before, 9])
            found.append((float(subject.time[rows[0]]), f"touch-down {speed:.2f} m/s"))
    return found
