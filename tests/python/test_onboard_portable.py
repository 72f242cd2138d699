"""The program onboard, built for aarch64 and run by QEMU, flies the engine's bits.

`./dev portable` builds it and runs these tests; others skip them.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from skybody.exports.__main__ import main
from skybody.onboard.program import find_program

PROGRAM = Path(__file__).resolve().parents[2] / "build/onboard-aarch64/bin/skybody_onboard"

pytestmark = pytest.mark.skipif(
    os.environ.get("SKYBODY_PORTABLE") != "1",
    reason="a compiler and an emulator of another processor: ./dev portable runs these tests",
)


@pytest.mark.parametrize("scenario", ["trajectory_ctbr", "racing", "obstacles", "landing"])
def test_the_program_for_aarch64_flies_the_bits_of_the_engine(
    scenario: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setenv("SKYBODY_ONBOARD", f"qemu-aarch64 {PROGRAM}")
    assert find_program()[0] == "qemu-aarch64"
    out = tmp_path / "m"
    short = ["--set", "stepping.horizon=300", "--scenario", scenario]
    words = ["shipped", *short, "--to", "onboard", "-o", str(out), "--check", "1"]
    assert main(words) == 0, capsys.readouterr().err
    assert "every action equal in all bits" in capsys.readouterr().out
