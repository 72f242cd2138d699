"""Lines, flashes, rows and distances of films (skybody.look)."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest
from numpy.typing import NDArray
from skybody.look import rows
from skybody.look.contacts import LASTS, Contacts, beginnings
from skybody.look.distances import surface_distances
from skybody.look.film import Film, Panel, Size
from skybody.look.flight import Flight
from skybody.look.lines import Lines
from skybody.look.rows import Rows
from skybody.look.scene import Scene, Style
from skybody.look.shapes import BOX, CAPSULE, CYLINDER, GROUND, MESH, SPHERE, Block, tubes
from skybody.look.trails import Paths, Trails, add_goals, breaks, moves

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
FULL = 1080  # rows of the picture whose pixels the widths of lines are given in
SMALL = Size(width=160, height=96)


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A landing that touches its deck, and a flight along a path."""
    found = {}
    for name, options in (("landing", ["--policy", "shipped"]), ("trajectory", ["--steps", "80"])):
        folder = tmp_path_factory.mktemp(name)
        command = [str(PROGRAM), "run", name, "--no-picture", "--out", str(folder), *options]
        subprocess.run(command, capture_output=True, timeout=100, check=True)
        found[name] = folder / "flight.h5"
    return found


def drawn(lines: Lines) -> tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.uint8]]:
    """Points, opacities and beginnings of lines."""
    points, _, colors, firsts = lines.arrays(FULL)
    return points, colors[:, 3], firsts


# --- lines --------------------------------------------------------------------------------------


def test_a_line_is_broken_at_points_that_are_no_numbers() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [np.nan, 0, 0], [3, 0, 0], [4, 0, 0]])
    lines = Lines()
    lines.add(points, 2.0, (1.0, 0.0, 0.0))
    lines.add_pairs(points[:1], points[1:2], 2.0, (0.0, 1.0, 0.0), 0.5)
    found, opacity, firsts = drawn(lines)
    np.testing.assert_array_equal(found[:, 0], [0, 1, 3, 4, 0, 1])
    assert firsts.tolist() == [1, 0, 1, 0, 1, 0]
    assert opacity.tolist() == [1.0] * 4 + [0.5] * 2


def test_a_trail_ends_at_the_robot_and_keeps_its_points_from_frame_to_frame(
    logs: dict[str, Path],
) -> None:
    flight = Flight(logs["landing"])
    trails = Trails(flight, [0], 0.5, "speed", [(0.0, 0.0, 0.0)])
    frames = []
    for time in (0.81, 0.83):
        lines = Lines()
        trails.add(lines, time)
        points, opacity, firsts = drawn(lines)
        np.testing.assert_allclose(points[-1], flight.at(time)[0][0], atol=1e-12)
        assert firsts.tolist() == [1] + [0] * (len(points) - 1)
        assert (np.diff(opacity) > 0.0).all()  # it fades
        frames.append({tuple(point) for point in points[:-1]})
    assert len(frames[0] & frames[1]) >= len(frames[0]) - 2
    assert frames[0] == {tuple(row) for row in flight.bodies[16:41, 0, :3]}  # 0.32 s to 0.8 s


def test_the_path_of_a_goal_that_moves_is_drawn(logs: dict[str, Path]) -> None:
    lines = Lines()
    flight = Flight(logs["trajectory"])
    Paths(flight).add(lines, 0.0)
    points, _, firsts = drawn(lines)
    (goal,) = flight.goals.values()
    np.testing.assert_allclose(points, goal[:, :3], atol=1e-12)
    assert firsts.sum() == 1


def test_goals_that_stand_or_jump_have_no_path() -> None:
    still = np.zeros((50, 3))
    assert not moves(still)
    assert not moves(still[:1])
    assert not moves(np.full((50, 3), np.nan))
    way = np.linspace(0.0, 1.0, 50)[:, None] * [1.0, 2.0, 0.0]
    assert moves(way)
    assert breaks(way).tolist() == [1] + [0] * 49
    jumping = way + np.repeat([0.0, 5.0], 25)[:, None]
    assert np.flatnonzero(breaks(jumping)).tolist() == [0, 25]
    strayed = way.copy()
    strayed[30] += 5.0  # for a row: away and back
    assert np.flatnonzero(breaks(strayed)).tolist() == [0, 30, 31]


def test_goals_are_crosses_and_unknown_ones_nothing() -> None:
    lines = Lines()
    add_goals(lines, {"a": np.array([1.0, 2, 3, 0]), "b": np.full(4, np.nan)}, 1.0)
    points, _, _ = drawn(lines)
    assert len(points) == 6
    np.testing.assert_allclose(points.mean(axis=0), [1.0, 2.0, 3.0])


# --- contacts -----------------------------------------------------------------------------------


def test_a_flash_is_where_and_when_something_begins_to_touch(logs: dict[str, Path]) -> None:
    flight = Flight(logs["landing"])
    scene = Scene(flight)
    contacts = Contacts(flight, scene.bodies, scene.obstacles, scene.size())
    (row,) = beginnings(flight)
    assert flight.touching[row] and not flight.touching[row - 1]
    time = float(flight.time[row])
    for late, count in ((-0.001, 0), (0.0, 32), (0.9 * LASTS, 32), (1.01 * LASTS, 0)):
        lines = Lines()
        contacts.add(lines, time + late)
        assert len(drawn(lines)[0]) == count
    place = contacts._place(row)
    deck = next(s for s in scene.bodies if flight.body_names[s.body] == "pad.deck")
    at, axes = flight.at(time)
    local = axes[deck.body].T @ (place - at[deck.body]) - deck.position
    assert abs(local[2] - deck.half[2]) < 0.02  # a foot, on the deck
    assert (np.abs(local[:2]) < deck.half[:2]).all()


def test_distances_from_surfaces() -> None:
    kinds = [BOX, SPHERE, CYLINDER, CAPSULE, GROUND, MESH]
    half = np.array([1.0, 0.5, 0.25])
    shapes = Block.of(kinds, np.tile([1.0, 0, 0], (6, 1)), np.eye(3), half, (0.0, 0.0, 0.0))
    points = np.array([[1.0, 0, 0], [1, 0, 2], [4, 0, 0], [1, 0, -0.5]])
    expected = [
        [-0.25, 1.75, 2.0, 0.25],  # edges 2, 1, 0.5
        [-1.0, 1.0, 2.0, -0.5],  # radius 1
        [-0.25, 1.75, 2.0, 0.25],  # half the length 0.25
        [-1.0, 0.75, 2.0, -0.75],  # of a capsule between its ends
        [0.0, 2.0, 0.0, -0.5],
        [np.inf] * 4,
    ]
    for k, distances in enumerate(expected):
        np.testing.assert_allclose(surface_distances(shapes, k, points), distances, atol=1e-12)


def test_tubes_lie_between_their_ends() -> None:
    ends = np.array([[0.0, 0, 0], [0, 0, 1], [1, 2, 3], [1, 2, 3]])
    block = tubes(ends[[0, 1, 2]], ends[[1, 2, 3]], 0.1, (0.0, 0.0, 0.0))
    for k, (a, b) in enumerate(((0, 1), (1, 2))):
        tip = block.positions[k] + block.axes[k] @ [0.0, 0.0, block.halves[k, 2]]
        np.testing.assert_allclose(tip, ends[b], atol=1e-12)
        np.testing.assert_allclose(2 * block.positions[k] - tip, ends[a], atol=1e-12)
    assert block.halves[2, 2] == 0.0
    np.testing.assert_allclose(block.axes @ block.axes.swapaxes(1, 2), [np.eye(3)] * 3, atol=1e-12)


# --- long logs ----------------------------------------------------------------------------------


@pytest.fixture
def narrow(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """As if small datasets were large ones."""
    monkeypatch.setattr(rows, "WHOLE", 0)
    monkeypatch.setattr(rows, "BLOCK", 1000)
    monkeypatch.setattr(rows, "KEPT", 3)
    yield


@pytest.mark.usefixtures("narrow")
def test_rows_of_a_large_dataset_are_read_by_blocks(tmp_path: Path) -> None:
    values = np.random.default_rng(1).random((1000, 4, 2))
    with h5py.File(tmp_path / "rows.h5", "w") as file:
        found = Rows(file.create_dataset("rows", data=values, chunks=(7, 4, 2)))
        for wanted in ([3, 2, 999, 3], list(range(0, 1000, 13)), [500]):
            np.testing.assert_array_equal(found[wanted], values[wanted])
            assert len(found._blocks) <= 3
            assert sum(block.nbytes for block in found._blocks.values()) <= 3 * (1000 + 7 * 64)
        assert found[[]].shape == (0, 4, 2)


@pytest.mark.parametrize("view", ["orbit", "chase", "fixed"])
def test_a_long_log_is_drawn_from_the_rows_near_a_frame(
    logs: dict[str, Path], view: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def frame() -> NDArray[np.uint8]:
        flight = Flight(logs["landing"])
        film = Film([Panel((Scene(flight, Style()),), view, 0, 0, 160, 96)], SMALL)
        drawn = film.frame(0.9)
        assert not {"bodies", "rotor_speed", "goals"} & set(vars(flight))  # whole datasets
        return drawn

    whole = frame()
    for name, value in (("WHOLE", 0), ("BLOCK", 1000), ("KEPT", 3)):
        monkeypatch.setattr(rows, name, value)
    np.testing.assert_array_equal(frame(), whole)
