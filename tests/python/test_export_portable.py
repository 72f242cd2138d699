"""Exported C gives the engine's bits on aarch64 and on Cortex-M processors, under emulators.

`./dev portable` installs the compilers and emulators and runs these tests; others skip them.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from skybody._native import shipped_policies
from skybody.exports.policy.c_files import write_sources
from skybody.exports.policy.self_test import actions_of, hash_of
from test_export_policy import opened

from research.deploy.network_drafts import NETWORKS, write_draft
from research.deploy.targets import TARGETS, run_self_test, size_of

STEPS, IMAGE_STEPS = 200, 3  # under emulation an evaluation with images takes 20 ms


pytestmark = pytest.mark.skipif(
    os.environ.get("SKYBODY_PORTABLE") != "1",
    reason="compilers and emulators for other processors: ./dev portable runs these tests",
)


@pytest.mark.parametrize("processor", ["clang", "aarch64", "cortex-m4", "cortex-m7"])
@pytest.mark.parametrize("policy", [*shipped_policies(), *(f"draft_{n}" for n in NETWORKS)])
def test_a_policy_gives_the_same_bits_on_other_processors(
    policy: str, processor: str, tmp_path: Path
) -> None:
    if policy.startswith("draft_"):
        file = tmp_path / "policy.h5"
        write_draft(file, "hover_camera", policy.removeprefix("draft_"))
        source = opened(file)
    else:
        source = opened("shipped", policy)
    folder = tmp_path / "c"
    write_sources(source, folder)
    steps = IMAGE_STEPS if source.interface.images else STEPS
    result = run_self_test(TARGETS[processor], source, folder, steps)
    assert result.hash == hash_of(actions_of(source, steps))


def test_a_race_fits_a_small_processor(tmp_path: Path) -> None:
    target = TARGETS["cortex-m4"]
    source = opened("shipped", "racing")
    write_sources(source, tmp_path)
    size = size_of(target, source, tmp_path)
    assert size.flash < 32 << 10  # 6,000 weights of 4 bytes, and code
    assert size.ram < 1 << 10
    # 6,000 products of two instructions and half a load each, and 132 tanh.
    assert run_self_test(target, source, tmp_path, 1).instructions < 50_000
