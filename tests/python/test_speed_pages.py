"""The measurement behind ray_speed.md: accepted and refused inputs."""

from __future__ import annotations

import pytest
from measurements import module
from skybody._native import versions
from skybody.ray.cluster import ClusterError

ray_speed = module("ray_speed")

MACHINE = {
    "processor": "some",
    "cores": 2,
    "system": "Linux",
    "date": "2026-01-01",
    "load": [0.0],
    "versions": {**versions(), "python": "3"},
}


def test_workers_that_learn_something_else_are_no_figure() -> None:
    work, names = ray_speed.WORKS[0], ray_speed.settings_of(2)
    same = [ray_speed.Turn(1000.0 * (k + 1), "ab") for k in range(len(names))]
    row = ray_speed.figures(work, names, [same, same])
    page = ray_speed.page({**MACHINE, "ray": "2", "turns": 2, "rows": [row]})
    assert "| as shipped | 1,000 (1.00) | 2,000 (2.00) | 3,000 (3.00) |" in page
    other = [*same[:-1], ray_speed.Turn(1.0, "cd")]
    with pytest.raises(ClusterError, match="as shipped: different parameters: ab, cd"):
        ray_speed.figures(work, names, [same, other])
