"""Shipped scenarios: each in the folder of its task, with its presets and its policy."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from skybody import CompiledScenario
from skybody._native import scenario_file, shipped_policies, shipped_scenarios

from research.documents import scenario_index

ROOT = Path(__file__).resolve().parents[2]


def test_every_file_of_a_folder_is_a_scenarios_its_presets_or_its_policy() -> None:
    folders = {Path(scenario_file(name)).parent for name in shipped_scenarios()}
    files = {file for folder in folders for file in folder.rglob("*") if file.is_file()}
    expected = set()
    for name in shipped_scenarios():
        folder = Path(scenario_file(name)).parent
        expected |= {folder / f"{name}.yaml", folder / f"training/{name}.yaml"}
        expected |= {folder / f"policies/{name}.h5"} if name in shipped_policies() else set()
    assert files <= expected
    assert {folder.name for folder in (ROOT / "scenarios").iterdir() if folder.is_dir()} == {
        *(folder.name for folder in folders),
        "models",
        "references",
    }


@pytest.mark.parametrize("name", shipped_scenarios())
def test_the_folder_has_the_name_of_the_task(name: str) -> None:
    compiled = CompiledScenario(name)
    assert compiled.name == name
    assert (
        yaml.safe_load(compiled.scenario_text)["task"]["plugin"] == Path(compiled.file).parent.name
    )


def test_a_copy_elsewhere_finds_its_model_and_includes(tmp_path: Path) -> None:
    copy = tmp_path / "mine.yaml"
    copy.write_text(Path(scenario_file("hover_crazyflie")).read_text())
    assert (
        CompiledScenario(str(copy)).scenario_hash
        == CompiledScenario("hover_crazyflie").scenario_hash
    )


def test_an_include_by_name_is_the_scenario_beside_a_folder_of_its_name(tmp_path: Path) -> None:
    (tmp_path / "hover").mkdir()
    mine = tmp_path / "mine.yaml"
    mine.write_text("include: hover\n")
    assert CompiledScenario(str(mine)).name == "hover"


def test_the_page_lists_the_scenarios_of_today() -> None:
    written = scenario_index.TARGET.read_text(encoding="utf-8")
    assert scenario_index.page() == written, "python -m research run scenario_index"
