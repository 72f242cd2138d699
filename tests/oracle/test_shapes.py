"""Contacts of random pairs of shapes against MuJoCo's signed distances, in shallow overlap.

The test compares the deepest contact where it is well defined: the overlap is far from the next
feature of either shape, so the shortest way apart is unique. A cylinder is turned about its axis
until one of its eight rim points is the deepest one; between rim points docs/contact.md promises
less.
"""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shape_pairs import KINDS, Mujoco, Pair, Solid, Touch, draw

SIZES, POSES = 6, 25  # random sizes of each ordered pair of shapes; poses of each
# MuJoCo's EPA stops at 1e-6 m, and on curved surfaces ends on a facet that is off by up to a
# degree. A rim point turned aside by half a degree for that is 0.2 m (1 - cos 0.5 deg) = 8 um
# higher.
DEPTH, SHARE, ANGLE = 1e-5, 0.02, math.radians(1.5)
# The overlap of two shapes is wider than deep; the deepest point may lie anywhere in it.
WIDTH = 8.0  # in depths
MARGIN = 5.0  # from the next feature, in depths
# Lower limit of the compared share. Between two rims Skybody has no contact point. Two sides near
# an end are not compared, because the end has less depth (docs/contact.md).
LEAST_COMPARED = {("cylinder", "cylinder"): 0.25}


@pytest.fixture(scope="module")
def mujoco() -> Mujoco:
    return Mujoco()


def margin(solid: Solid, feature: str, point: np.ndarray) -> float:
    """Distance of a point of a feature from the next feature [m]."""
    p = np.abs(solid.rotation.inv().apply(point - solid.position))
    if solid.kind == "box":
        ways = np.sort(np.abs(0.5 * solid.size - p))
        return float(ways[{"face": 1, "edge": 2, "corner": 2}[feature]])
    if feature == "side":
        return float(0.5 * solid.size[1] - p[2])
    if feature == "end":
        return float(solid.size[0] - math.hypot(p[0], p[1]))
    return math.inf


def turned_to(solid: Solid, normal: np.ndarray) -> Solid:
    """A cylinder, rotated about its axis until its x axis faces a direction."""
    if solid.kind != "cylinder":
        return solid
    n = solid.rotation.inv().apply(normal)
    turn = Rotation.from_euler("z", math.atan2(n[1], n[0]))
    return Solid(solid.kind, solid.size, solid.position, solid.rotation * turn)


def ends_are_apart(first: Solid, second: Solid) -> bool:
    """Tests if the ends of the first's axis are farther from the second's axis than the sum of both
    radii.
    """
    axis = second.rotation.apply([0.0, 0.0, 1.0])
    for side in (-0.5, 0.5):
        end = first.position + first.rotation.apply([0.0, 0.0, side * first.size[1]])
        arm = end - second.position
        along = np.clip(arm @ axis, -0.5 * second.size[1], 0.5 * second.size[1])
        if np.linalg.norm(arm - along * axis) < first.size[0] + second.size[0]:
            return False
    return True


def is_well_defined(first: Solid, second: Solid, exact: Touch) -> bool:
    pairs = [(s, s.feature(exact.normal)) for s in (first, second)]
    least = min(margin(s, feature, exact.point) for s, feature in pairs)
    if least < MARGIN * exact.depth:
        return False
    kinds = {feature for _, feature in pairs}
    if "cylinder" in (first.kind, second.kind) and kinds == {"side"}:  # they cross like rods
        return ends_are_apart(first, second)
    if first.kind == second.kind == "cylinder":
        return kinds != {"rim"}
    return True


def expect_agreement(
    found: list[Touch], exact: Touch, features: set[str], kinds: set[str], words: str
) -> None:
    assert found, f"{words}: no contact, {exact.depth} m deep"
    deepest = max(found, key=lambda touch: touch.depth)
    depth = deepest.depth
    shares = features == {"edge", "side"} or (features == {"side"} and "capsule" in kinds)
    if shares:
        # The ends of an edge or a side have contacts of their own; the sum of the depths counts.
        deepest = min(found, key=lambda touch: float(np.linalg.norm(touch.point - exact.point)))
        depth = sum(touch.depth for touch in found)
        if "capsule" in kinds and kinds != {"capsule"}:
            # There a cap has its own contact, as deep as the whole overlap, and so has a corner in
            # the capsule (docs/contact.md).
            depth = min(deepest.depth, depth, key=lambda d: abs(d - exact.depth))
    assert depth == pytest.approx(exact.depth, rel=SHARE, abs=DEPTH), words
    angle = math.acos(min(1.0, float(deepest.normal @ exact.normal)))
    assert angle < ANGLE, f"{words}: normals {math.degrees(angle)} degrees apart"
    aside = float(np.linalg.norm(deepest.point - exact.point))
    assert aside < WIDTH * exact.depth, f"{words}: {aside} m aside, {exact.depth} m deep"


@pytest.mark.parametrize("kinds", list(itertools.product(KINDS, KINDS)), ids="-".join)
@pytest.mark.parametrize("is_obstacle", [True, False], ids=["on_obstacle", "on_robot"])
def test_the_deepest_contact_is_mujocos(
    mujoco: Mujoco, tmp_path: Path, kinds: tuple[str, str], is_obstacle: bool
) -> None:
    random = np.random.default_rng([KINDS.index(kinds[0]), KINDS.index(kinds[1]), is_obstacle])
    compared = 0
    for _ in range(SIZES // 2):
        sizes = [draw(random, kind).size for kind in kinds]
        solids = [draw(random, k, s) for k, s in zip(kinds, sizes, strict=True)]
        pair = Pair(tmp_path, solids[0], solids[1], is_obstacle)
        for pose in range(POSES):
            first, second = (draw(random, s.kind, s.size) for s in solids)
            second = second.moved(random.uniform(-1.0, 1.0, 3))
            way = random.normal(size=3)
            way /= np.linalg.norm(way)
            first = first.moved(second.position)
            first = mujoco.overlapping(first, second, way, 10.0 ** random.uniform(-4.0, -3.0))
            about = mujoco.touch(first, second).normal
            first, second = turned_to(first, about), turned_to(second, about)
            exact = mujoco.touch(first, second)
            if not is_well_defined(first, second, exact):
                continue
            compared += 1
            features = {s.feature(exact.normal) for s in (first, second)}
            words = f"{sizes}, {features}, {pose}"
            expect_agreement(pair.contacts(first, second), exact, features, set(kinds), words)
    least = LEAST_COMPARED.get(kinds, 0.5)
    assert compared >= least * (SIZES // 2) * POSES, "too few are well defined"


@pytest.mark.parametrize("kind", ["box", "cylinder"])
def test_crossed_rods_touch_where_they_cross(mujoco: Mujoco, tmp_path: Path, kind: str) -> None:
    """Rods of 1 m and 2 cm, edge on edge or side on side, crossing at any angle."""
    size = np.array([0.02, 0.02, 1.0]) if kind == "box" else np.array([0.01, 1.0])
    random = np.random.default_rng(5)
    lying = Rotation.from_euler("x", 90.0, degrees=True)
    pair = Pair(tmp_path, draw(random, kind, size), draw(random, kind, size), False)
    for _ in range(40):
        crossing = Rotation.from_euler("z", random.uniform(20.0, 160.0), degrees=True)
        edge = Rotation.from_euler("z", 45.0, degrees=True)  # one edge up, one edge down
        tilt = Rotation.from_rotvec(random.normal(0.0, 0.05, 3))
        first = Solid(kind, size, np.zeros(3), tilt * crossing * lying * edge)
        second = Solid(kind, size, random.uniform(-0.2, 0.2, 3) * [1, 1, 0], lying * edge)
        first = mujoco.overlapping(first, second, np.array([0.0, 0.0, 1.0]), 5e-4)
        first, second = (turned_to(s, np.array([0.0, 0.0, 1.0])) for s in (first, second))
        exact = mujoco.touch(first, second)
        expected = "edge" if kind == "box" else "side"
        assert [s.feature(exact.normal) for s in (first, second)] == [expected] * 2
        expect_agreement(pair.contacts(first, second), exact, {expected}, {kind}, kind)
