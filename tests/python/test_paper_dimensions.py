"""Scenarios of the paper's tasks have the paper's dimensions and rates.

paper_dimensions.csv is their only table. Columns for each robot: observed values, values for the
critic only, actions, physics steps of 1 ms per action, actions per episode.
"""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from skybody import CompiledScenario

TABLE = Path(__file__).with_name("paper_dimensions.csv")
ROWS = list(csv.DictReader(TABLE.read_text().splitlines()))


@pytest.mark.parametrize("row", ROWS, ids=[row["scenario"] for row in ROWS])
def test_a_paper_task_has_the_papers_dimensions(row: dict[str, str]) -> None:
    compiled = CompiledScenario(row["scenario"])
    columns = [c for c in compiled.observation_columns if c.robot in (-1, 0)]
    sizes = {
        "observations": sum(c.shape[0] for c in columns if not c.privileged),
        "privileged": sum(c.shape[0] for c in columns if c.privileged),
        "actions": compiled.action_size // len(compiled.robots),
        "action_repeat": compiled.action_repeat,
        "horizon": compiled.horizon,
    }
    assert {name: str(size) for name, size in sizes.items()} == {
        name: size for name, size in row.items() if name != "scenario"
    }
    assert compiled.dt == 1e-3
