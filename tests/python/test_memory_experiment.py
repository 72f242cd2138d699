"""The experiment on memory, in small; it must detect growth."""

from __future__ import annotations

import pytest
from measurements import module, run


def test_steps_random_resets_and_closed_pools_leave_memory_and_handles_as_they_were():
    done = run("memory", "--steps", "2e5", "--cycles", "30")
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    assert done.stdout.count(": flat\n") == 4
    assert done.stdout.count(": the same\n") == 1


@pytest.mark.parametrize("leak, flat", [(0.1, True), (1.0, False)])
def test_a_leak_of_one_byte_a_step_is_growth(
    monkeypatch: pytest.MonkeyPatch, leak: float, flat: bool
):
    memory = module("memory")
    steps = 0
    monkeypatch.setattr(memory, "resident", lambda: 60 * memory.MIB + int(leak * steps))
    measured = memory.Memory(memory.STEPS, "steps")
    for steps in range(0, memory.STEPS + 1, 100_000):
        measured.report(steps)
    assert len(measured.values) == memory.REPORTS
    assert measured.flat() is flat
