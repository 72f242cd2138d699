"""`nmpc` in the engine: state words hold all its memory; every processor gives its bits."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
import skybody

CONTROL = "[{plugin: nmpc}, {plugin: srt}]"
# A reference whose steps saturate rotors, and moving air.
OVERRIDES = [
    "effects=[{plugin: dryden, parameters: {airspeed: 5}}, "
    "{plugin: body_drag, parameters: {linear: [0.2, 0.2, 0.2]}}]"
]


def has_nmpc() -> bool:
    try:
        skybody.Simulation("hover", control=CONTROL)
    except skybody.InputError as error:
        if "unknown controller `nmpc`" not in str(error):
            raise
        return False
    return True


pytestmark = pytest.mark.skipif(not has_nmpc(), reason="built without DAQP")


def fly(sim: skybody.Simulation, first: int, last: int) -> None:
    """Positions from tenth of a second `first` to `last`."""
    for k in range(first, last):
        place = [np.sin(1.7 * k), np.cos(2.3 * k), 1.5 + 0.5 * np.sin(k)]
        sim.command(np.concatenate([place, np.zeros(14)]))
        assert sim.advance(100)


def test_goes_on_from_a_snapshot_in_mid_flight_with_the_same_bits() -> None:
    sim = skybody.Simulation("hover", control=CONTROL, overrides=OVERRIDES)
    sim.reset()
    fly(sim, 0, 7)
    sim.advance(5)  # between two calls of the controller
    snapshot = sim.save()
    copy = sim.fork()
    fly(sim, 7, 12)
    end = sim.hash()
    fly(copy, 7, 12)
    assert copy.hash() == end
    sim.restore(snapshot)
    fly(sim, 7, 12)
    assert sim.hash() == end


def test_bits_are_the_same_on_every_instruction_set() -> None:
    script = (
        "import skybody, test_nmpc as t\n"
        "sim = skybody.Simulation('hover', control=t.CONTROL, overrides=t.OVERRIDES)\n"
        "sim.reset()\n"
        "t.fly(sim, 0, 10)\n"
        "print(sim.hash())\n"
    )
    hashes = set()
    for isa in ("v2", "v3", "v4"):
        done = subprocess.run(
            [sys.executable, "-c", script],
            capture_output=True,
            text=True,
            env={**os.environ, "SKYBODY_ISA": isa},
            cwd=os.path.dirname(__file__),
            check=False,
        )
        if done.returncode != 0 and "SKYBODY_ISA" in done.stderr:
            continue  # not available on this machine
        assert done.returncode == 0, done.stderr
        hashes.add(done.stdout)
    assert len(hashes) == 1
