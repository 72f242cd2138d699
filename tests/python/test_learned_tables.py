"""The result tables in the READMEs of tasks match those of the page on learning."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from measurements import module

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def script() -> Any:
    return module("learned_tables")


def test_readmes_of_tasks_have_the_figures_of_the_page_on_learning(script: Any) -> None:
    for readme in script.pages():
        text = readme.read_text()
        assert script.page(text) == text, f"{readme}: learned_tables writes it anew"


def test_every_scenario_that_was_learned_is_in_one_readme(script: Any) -> None:
    runs = json.loads((ROOT / "docs/results/data/learning.json").read_text())["runs"]
    named = [name for readme in script.pages() for name in script.named(readme.read_text())]
    assert sorted(named) == sorted({run["scenario"] for run in runs})
