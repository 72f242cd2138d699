""".github/workflows: the hosted checks call commands of ./dev that exist."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted((ROOT / ".github/workflows").glob("*.yml"))


def commands(workflow: dict[str, Any]) -> list[str]:
    """Commands of all jobs, those of matrices too."""
    found: list[str] = []
    for job in workflow["jobs"].values():
        found += job.get("strategy", {}).get("matrix", {}).get("command", [])
        found += [step["run"] for step in job["steps"] if "run" in step]
    return found


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_a_workflow_calls_commands_of_dev_that_exist(file: Path) -> None:
    workflow = yaml.safe_load(file.read_text())
    assert workflow["permissions"] == {"contents": "read"}
    assert all(
        job["timeout-minutes"] <= 150 for name, job in workflow["jobs"].items() if name != "publish"
    )
    called = re.findall(r"\./dev (\w+)", "\n".join(commands(workflow)))
    known = re.findall(r"^\./dev (\w+)", (ROOT / "dev").read_text(), re.MULTILINE)
    assert called
    assert set(called) <= set(known)


def test_hosted_checks_have_every_part_of_the_local_ones() -> None:
    local = set(re.findall(r"^part \./dev (\w+)", (ROOT / ".ci/run").read_text(), re.MULTILINE))
    hosted = "\n".join(c for f in FILES for c in commands(yaml.safe_load(f.read_text())))
    assert local <= set(re.findall(r"\./dev (\w+)", hosted))


def test_hosted_checks_cover_all_that_a_release_needs() -> None:
    assert {file.stem for file in FILES} == {
        "build", "determinism", "docs", "sanitizers", "test", "wheels",
    }  # fmt: skip
    nightly = commands(yaml.safe_load((ROOT / ".github/workflows/sanitizers.yml").read_text()))
    assert any(re.search(r"fuzz .*--inputs 1000000\b", command) for command in nightly)
    assert re.search(r"fuzz .*--inputs 100000\b", (ROOT / ".ci/run").read_text())


def test_the_citation_names_this_version() -> None:
    """PyPI's `cffconvert --validate` checks the whole file; here: required keys and the version."""
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    found = re.search(r"project\(Skybody VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())
    assert found is not None
    assert str(cited["version"]) == found[1]
    assert {"cff-version", "message", "title", "authors"} <= set(cited)
