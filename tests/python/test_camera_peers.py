"""research/peers/camera_peers: the scene that peers get, their images of it, and the page."""

from __future__ import annotations

import importlib
import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from measurements import ENVIRONMENT

FOLDER = Path(__file__).resolve().parents[2] / "research/peers"
SHORT = ("--seconds", "0.01", "--trials", "1", "--quick")
peers: Any = importlib.import_module("research.peers.camera_peers")


def run(script: str, scene: dict[str, Any], folder: Path) -> list[dict[str, Any]]:
    """Rows of a peer's script on a scene."""
    file = folder / "scene.json"
    file.write_text(json.dumps(scene))
    command = [sys.executable, str(FOLDER / script), "--scene", str(file), *SHORT]
    done = subprocess.run(
        command, env=ENVIRONMENT, capture_output=True, text=True, timeout=100.0, check=False
    )
    assert done.returncode == 0, done.stderr
    rows = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    if any("OpenGL" in row.get("skipped", "") or "EGL" in done.stderr for row in rows):
        pytest.skip("no OpenGL here")
    return rows


@pytest.mark.parametrize(
    ("script", "package"), [("camera_mujoco.py", "mujoco"), ("camera_pybullet.py", "pybullet")]
)
def test_a_peer_sees_the_same(script: str, package: str, tmp_path: Path) -> None:
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"no package {package}")
    scene, views = peers.scene_and_views(8)
    rows = run(script, scene, tmp_path)
    assert len(rows) == 2
    for row in rows:
        assert row["rate"] > 0.0
        assert row["seen"] == pytest.approx(views["seen"], rel=0.1)
        assert row["depth"] == pytest.approx(views["depth"], rel=0.05)


def test_the_scene_has_gates_as_bars() -> None:
    scene, views = peers.scene_and_views(2)
    kinds = [shape["kind"] for shape in scene["shapes"]]
    assert len(kinds) == 13
    assert kinds.count("box") == 9
    assert len({shape["instance"] for shape in scene["shapes"]}) == 7
    assert len(scene["poses"]) == 2
    assert 0.0 < views["seen"] < 0.2


def row(peer: str, task: str, rate: float) -> dict[str, Any]:
    facts = {"peer": peer, "version": "1", "mode": "m", "task": task, "by_processor": rate}
    if task == peers.FROM_PYTHON:
        facts |= {"rate": rate, "seen": 0.02, "depth": 4.0}
    return facts


def test_goals_compare_the_best_rows() -> None:
    rows = [
        row(peers.OURS, peers.ALONE, 100.0),
        row(peers.OURS, peers.FROM_PYTHON, 100.0),
        row("Embree", peers.ALONE, 10.0),
        row("Embree", peers.ALONE, 50.0),
        row("MuJoCo", peers.FROM_PYTHON, 2.0),
    ]
    lines = peers.goals(rows).splitlines()
    assert "| Embree | 2.0 | 2.5 | missed |" in lines
    assert "| MuJoCo | 50.0 | 30 | met |" in lines
    assert "| PyBullet |  | 300 | not measured |" in lines
    assert "| Embree 1 | m | 10 | 10.0 |" in peers.table(rows, peers.ALONE)
