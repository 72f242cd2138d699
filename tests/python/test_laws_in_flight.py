"""Control laws in the engine: forks in mid-flight, references that break in one environment."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from skybody import Simulation, SimulationPool

PLUGINS = [Path(__file__).resolve().parents[2] / "build/release/tests/plugins/good"]
PLAIN = ["contact.ground=false", "randomization=[]"]
GAINS = "kp: [6, 6, 9], kd: [4, 4, 5.4], ki: [1, 1, 1]"
RATES = "{plugin: attitude, parameters: {feed_forward: true}}, {plugin: ctbr}"
FOLLOWERS = {
    "geometric": "{plugin: geometric}, {plugin: ctbt}",
    "geometric_integral": "{plugin: geometric, parameters: {ki: [1, 1, 1]}}, {plugin: ctbt}",
    "geometric_rates": "{plugin: geometric, parameters: {output: ctbr}}, {plugin: ctbr}",
    "lqr": "{plugin: lqr}, {plugin: ctbt}",
    "sliding_mode": "{plugin: sliding_mode}, {plugin: ctbt}",
    "position": f"{{plugin: position, parameters: {{signal: trajectory}}}}, {RATES}",
    "flatness": f"{{plugin: flatness, parameters: {{{GAINS}}}}}, {RATES}",
    "levels": f"{{plugin: flatness, parameters: {{output: acceleration, {GAINS}}}}},"
    " {plugin: acceleration}, {plugin: force}, {plugin: attitude}, {plugin: ctbr}",
}
VELOCITY = (
    "[{plugin: velocity_tracking, parameters: {ki: [1, 1, 1]}}, {plugin: acceleration},"
    " {plugin: force}, {plugin: attitude}, {plugin: ctbr}]"
)


def command_of(size: int, t: float) -> np.ndarray:
    """A velocity and a yaw rate, or a circle as a trajectory."""
    if size == 4:
        return np.array([np.sin(t), np.cos(t), 0.2, 0.5])
    c, s = np.cos(t), np.sin(t)
    plane = [(c, s), (-s, c), (-c, -s), (s, -c), (c, s)]
    return np.array([*(v for x, y in plane for v in (x, y, 0.0)), 0.3 * t, 0.3]) + np.eye(17)[2]


def flight(chain: str) -> Simulation:
    simulation = Simulation("hover", chain, overrides=PLAIN)
    simulation.reset()
    return simulation


def fly(simulation: Simulation, first: int, last: int) -> None:
    size = simulation.command_size()
    for n in range(first, last):
        simulation.command(command_of(size, 1e-3 * n))
        assert simulation.advance(1)


@pytest.mark.parametrize("chain", [*(f"[{c}]" for c in FOLLOWERS.values()), VELOCITY])
def test_a_fork_in_mid_flight_has_the_same_future(chain: str):
    simulation = flight(chain)
    fly(simulation, 0, 300)
    copy = simulation.fork()
    fly(simulation, 300, 600)
    fly(copy, 300, 600)
    assert simulation.hash() == copy.hash()


@pytest.mark.parametrize("law", FOLLOWERS)
def test_a_reference_that_is_no_number_ends_that_environment_alone(law: str):
    def pool(env: int) -> SimulationPool:
        chain = f"[{{plugin: spoilt_reference, parameters: {{env: {env}}}}}, {FOLLOWERS[law]}]"
        pool = SimulationPool("hover", 12, chain, overrides=PLAIN, plugin_path=PLUGINS)
        pool.reset(seed=1)
        pool.command(2.0 * np.eye(17)[2])  # up by one metre
        pool.advance(100)
        return pool

    spoilt, sound = pool(5), pool(1000)
    assert np.flatnonzero(spoilt.faults).tolist() == [5]
    assert not sound.faults.any()
    rest = np.arange(12) != 5
    for path in ("robots.quad.base.position", "robots.quad.base.angular_velocity"):
        np.testing.assert_array_equal(spoilt.state(path)[rest], sound.state(path)[rest])
