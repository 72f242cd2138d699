"""Each file of tests/unit has the name of the source file that it tests.

`tests/unit/AREA/NAME_test.cpp` tests a file `NAME.h` or `NAME.cpp` of the area's folders, at any
depth; `NAME_ASPECT_test.cpp` tests one aspect of it. NAME may also be a plugin's or another folder
of the area. EXCEPTIONS has the files that test several sources at once, with the reason.
"""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
UNIT = ROOT / "tests/unit"
TESTS = sorted(str(file.relative_to(UNIT)) for file in UNIT.rglob("*_test.cpp"))

# Folders of an area's sources; without a row, core/AREA.
SOURCES = {
    "batch": ["core/batch", "include/skybody"],
    "bench": ["research/bench"],
    "controllers": ["controllers", "plugins/reference"],
    "effects": ["effects"],
    "learn": ["learn"],
    "onboard": ["onboard"],
    "plugins": ["core/plugin_host", "plugins/api", "app"],
    "randomization": ["randomization"],
    "render": ["render"],
    "sensors": ["sensors"],
    "tasks": ["tasks", "plugins/task_kit", "plugins/obstacles"],
}

EXCEPTIONS = {
    "base/geometry_test.cpp": "vec3, quat, mat3 and inertia: their shared conventions",
    "base/same_bits_test.cpp": "every function of math, in packs",
    "controllers/cascade_test.cpp": "position, attitude and ctbr in closed loop",
    "controllers/derivatives_test.cpp": "a property of every controller",
    "controllers/laws_test.cpp": "properties of all control laws",
    "controllers/levels_test.cpp": "the controllers between a trajectory and an attitude",
    "controllers/modes_test.cpp": "a property of every control mode",
    "effects/derivatives_test.cpp": "a property of every effect",
    "env/checked_test.cpp": "checked mode, in all phases of a transition",
    "env/shapes_test.cpp": "shapes as plugins read them: setup tables and views",
    "io/advice_test.cpp": "missing_file, unit_hint and include_chain: advice in messages",
    "io/bad_input_test.cpp": "all readers, over the files of tests/bad_input",
    "io/guard_test.cpp": "all readers, over untrusted files",
    "io/shapes_test.cpp": "shapes in scenarios, URDFs and height fields",
    "learn/public_layouts_test.cpp": "sizes of the structures of <skybody/skybody.h> and learn.h",
    "physics/constants_test.cpp": "each physical constant, wherever a force reads it",
    "physics/flight_test.cpp": "bodies and rotors in whole flights, against closed forms",
    "physics/lanes_test.cpp": "kinematics and forces in packs",
    "physics/packs_test.cpp": "whole steps of lane groups in packs",
    "physics/rotor_place_test.cpp": "a drawn rotor position in all terms of the motion",
    "physics/shape_distance_test.cpp": "overlap, surface_distance and height_field together",
    "plugins/api_test.cpp": "compile-time properties of all headers",
    "plugins/codegen_test.cpp": "machine code of every plugin",
    "plugins/derivatives_test.cpp": "a property of plugins as authors write them",
    "plugins/same_bits_test.cpp": "a property of every plugin",
    "randomization/randomization_test.cpp": "rules of all randomizers",
    "simulation/drawn_bodies_test.cpp": "a reset of a whole environment",
    "simulation/drawn_vehicles_test.cpp": "flights of randomizer `vehicle` by the baseline",
    "simulation/fault_cause_test.cpp": "core/env/fault_cause in whole environments",
    "simulation/navigation_test.cpp": "sensor `ekf` in whole environments",
    "simulation/ropes_test.cpp": "couplings in whole environments",
    "simulation/sensed_loads_test.cpp": "sensors in whole environments, against known loads",
    "simulation/start_overlap_test.cpp": "core/env/start_overlaps in whole environments",
    "simulation/state_values_test.cpp": "core/env/state_values in whole environments",
    "tasks/derivatives_test.cpp": "a property of every task",
    "tasks/task_kit_test.cpp": "the parts of the task kit together",
    "tasks/tasks_test.cpp": "hover and payload, by hand",
}


def names_of(area: str) -> set[str]:
    """Names of the sources and folders of an area."""
    names = set()
    for folder in SOURCES.get(area, [f"core/{area}"]):
        for path in (ROOT / folder).rglob("*"):
            if path.is_dir() or path.suffix in (".h", ".cpp"):
                names.add(path.stem)
    return names


def mirrors(test: str) -> bool:
    """Whether a test has the name of a source of its area, alone or with an aspect."""
    path = Path(test)
    words = path.stem.removesuffix("_test").split("_")
    names = names_of(path.parent.name)
    return any("_".join(words[:count]) in names for count in range(1, len(words) + 1))


@pytest.mark.parametrize("test", TESTS)
def test_a_unit_test_has_the_name_of_its_source(test: str) -> None:
    assert mirrors(test) != (test in EXCEPTIONS), (
        "name it after its source, or give the reason in EXCEPTIONS; a test that mirrors a source "
        "is no exception"
    )


def test_exceptions_exist() -> None:
    assert set(EXCEPTIONS) <= set(TESTS)


def test_a_name_of_no_source_is_found() -> None:
    assert mirrors("physics/contact_rest_test.cpp")
    assert not mirrors("physics/nonsense_test.cpp")
    assert not mirrors("io/contact_test.cpp")
