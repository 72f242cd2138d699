"""Every shipped scenario matches its pinned hash on each dynamics, integrator, instruction set."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import skybody
from skybody._native import shipped_scenarios

FOLDER = Path(__file__).resolve().parents[1] / "golden"
SCRIPT = FOLDER / "golden.py"
FLIGHTS = sorted(file.stem for file in FOLDER.glob("*.json"))

TIMEOUT = 600  # s; a flight has up to 30 processes

pytestmark = [
    pytest.mark.timeout(TIMEOUT),
    # The pinned bits of Simbody are those of the distribution's build (docs/determinism.md).
    pytest.mark.skipif(
        skybody.versions()["simbody asserts"] == "off",
        reason="Simbody of our own gives other last bits than the distribution's",
    ),
]


def golden(script: Path, *options: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(script), *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False)


def copy_script(project: Path) -> Path:
    """The script with its list in another project; returns the folder of its hashes."""
    for file in (SCRIPT, FOLDER.parents[1] / "core/base/simd/isa_sets.h"):
        place = project / file.relative_to(FOLDER.parents[1])
        place.parent.mkdir(parents=True)
        shutil.copy(file, place)
    return project / "tests/golden"


def test_every_shipped_scenario_is_pinned():
    flown = {json.loads((FOLDER / f"{name}.json").read_text())["flight"] for name in FLIGHTS}
    scenarios = {command.split()[3] for command in flown}
    own = {scenario for scenario in scenarios if scenario.endswith(".yaml")}
    assert own == {f"tests/golden/{file.name}" for file in FOLDER.glob("*.yaml")}
    assert scenarios - own == set(shipped_scenarios())


@pytest.mark.parametrize("flight", FLIGHTS)
def test_a_scenario_flies_as_it_was_pinned(flight: str):
    done = golden(SCRIPT, "--flights", flight)
    assert (done.stdout, done.stderr, done.returncode) == ("nothing moved\n", "", 0)


def fly_hover(project: Path, **changed: str) -> subprocess.CompletedProcess[str]:
    """The comparison of `hover` in another project, after changes of its pinned file.

    Args:
        changed: `system`, or a way whose pinned hash of the motion is replaced.
    """
    root = copy_script(project)
    pinned = json.loads((FOLDER / "hover.json").read_text())
    pinned["system"] = changed.pop("system", pinned["system"])
    for way, value in changed.items():
        pinned["hashes"][way]["motion"] = value
    (root / "hover.json").write_text(json.dumps(pinned))
    program = FOLDER.parents[1] / "build/release/bin/skybody"
    return golden(root / "golden.py", "--flights", "hover", "--program", str(program))


def moved_line(way: str) -> str:
    before = json.loads((FOLDER / "hover.json").read_text())["hashes"][way]["motion"]
    return f"hover, {way}: motion 00000000deadbeef -> {before}\n"


@pytest.mark.parametrize("way", ["tree, rk4", "simbody, rk4"])
def test_a_hash_that_moved_is_named_with_its_way(tmp_path: Path, way: str):
    done = fly_hover(tmp_path, **{way: "00000000deadbeef"})
    assert (done.stdout, done.returncode) == (moved_line(way), 1)


def test_on_another_system_simbody_is_not_compared(tmp_path: Path):
    done = fly_hover(tmp_path, system="another", **{"simbody, rk4": "00000000deadbeef"})
    assert (done.stdout, done.returncode) == ("nothing moved\n", 0)


def test_on_another_system_the_tree_engine_is_compared(tmp_path: Path):
    done = fly_hover(tmp_path, system="another", **{"tree, rk4": "00000000deadbeef"})
    assert (done.stdout, done.returncode) == (moved_line("tree, rk4"), 1)


def test_a_random_world_that_moved_is_named(tmp_path: Path):
    root = copy_script(tmp_path)
    pinned = (FOLDER / "trees.txt").read_text()
    before = next(line for line in pinned.splitlines() if line.startswith("tree_3 ")).split()[1]
    (root / "trees.txt").write_text(pinned.replace(before, "00000000deadbeef"))
    program = FOLDER.parents[1] / "build/release/bin/skybody"
    done = golden(root / "golden.py", "--flights", "trees", "--program", str(program))
    assert done.stdout == f"trees, tree_3: 00000000deadbeef -> {before}\n"
    assert done.returncode == 1


def test_a_program_that_is_not_built_is_one_message(tmp_path: Path):
    done = golden(SCRIPT, "--flights", "hover", "--program", str(tmp_path / "skybody"))
    assert done.stderr == (
        f"golden: {tmp_path}/skybody: No such file or directory; build it, or give --program\n"
    )
    assert done.returncode == 2
