"""research/learning/vision_comparison: policies of one scenario that observe different columns."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from measurements import module
from skybody import CompiledScenario

comparison: Any = module("vision_comparison")
SCENARIO = "obstacles_vision"
# A scenario in which the task's velocity is for the critic alone.
HIDDEN = """\
include: obstacles_vision.yaml
name: hidden
observe:
  - front.depth
  - {channel: rays.range, privileged: true}
  - {channel: task.velocity, privileged: true}
"""


def columns(scenario: str, kind: str) -> dict[str, Any]:
    """Columns of the observation by name: whether each is privileged."""
    compiled = CompiledScenario(scenario, overrides=list(comparison.overrides_of(scenario, kind)))
    return {column.name: column.privileged for column in compiled.observation_columns}


@pytest.mark.parametrize("kind", [comparison.BLIND, comparison.STATE])
def test_without_images_everything_else_stays(kind: str) -> None:
    seen, whole = columns(SCENARIO, kind), columns(SCENARIO, comparison.IMAGES)
    assert "front.depth" in whole
    assert set(whole) - {"front.depth"} <= set(seen)
    assert "front.depth" not in seen
    assert seen["rays.range"] == (kind == comparison.BLIND)


def test_the_state_has_the_nearest_obstacles() -> None:
    assert "nearest_5.way" in columns(SCENARIO, comparison.STATE)
    assert "nearest_1.way" not in columns(SCENARIO, comparison.BLIND)


def test_hidden_columns_of_the_task_are_seen_with_the_state_alone(tmp_path: Path) -> None:
    file = tmp_path / "hidden.yaml"
    file.write_text(HIDDEN)
    assert columns(str(file), comparison.BLIND)["velocity"]
    assert not columns(str(file), comparison.STATE)["velocity"]


def test_the_page_has_a_line_for_each_policy(tmp_path: Path) -> None:
    rows = [
        {
            "scenario": SCENARIO,
            "kind": kind,
            "seed": 1,
            "steps": 1000,
            "succeeded": 0.97,
            "figures": ["97 %", "5.9 m/s"],
            "learned": kind != comparison.BLIND,
            "speed": None if kind == comparison.BLIND else 5.9,
            "seconds": 100.0,
            "curve": [[0.0, 1.0], [1000.0, 2.0]],
            "versions": {"git": "1"},
        }
        for kind in comparison.KINDS
    ]
    machine = {"processor": "p", "cores": 2, "system": "s"}
    content = {"command": "c", "machine": machine, "episodes": 100, "runs": rows}
    text = comparison.markdown(content)
    assert f"| `{SCENARIO}` | images | 97 % | 97 %; 5.9 m/s | 1 of 1 | 5.90 | 100 |" in text
    assert f"| `{SCENARIO}` | blind | 97 % | 97 %; 5.9 m/s | 0 of 1 |  | 100 |" in text
    comparison.draw(rows, tmp_path / "curves.png")
    assert (tmp_path / "curves.png").stat().st_size > 5_000
