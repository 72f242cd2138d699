"""Requests for values of randomizable parameters, made from Python."""

from __future__ import annotations

import re
import subprocess
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import skybody
from skybody.requests import request_lines

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
GRAVITY = "gravity[2]"


def step(envs) -> None:
    envs.step(np.zeros(envs.action_space.shape, np.float32))


@pytest.fixture
def envs():
    with closing(skybody.make_vec("hover", num_envs=4, num_threads=2, seed=3)) as made:
        made.reset()
        yield made


def test_a_request_comes_with_the_next_step(envs):
    envs.request([1, 2], {GRAVITY: -5.0})
    assert envs.param(1, GRAVITY) == pytest.approx(-9.81)
    step(envs)
    assert [envs.param(k, GRAVITY) for k in range(4)] == pytest.approx([-9.81, -5.0, -5.0, -9.81])


def test_vectors_and_draws(envs):
    mass = "robots.quad.links.base_link.mass"
    nominal = envs.param(0, mass)
    envs.request(None, {"gravity": [0.0, 1.0, -9.0]})
    envs.request(None, {mass: {"range": [0.9, 1.1], "form": "scale"}})
    step(envs)
    assert [envs.param(2, f"gravity[{k}]") for k in range(3)] == [0.0, 1.0, -9.0]
    masses = [envs.param(k, mass) / nominal for k in range(4)]
    assert len(set(masses)) == 4 and 0.9 <= min(masses) <= max(masses) <= 1.1


def test_requests_at_a_reset(envs):
    envs.request(None, {GRAVITY: -5.0}, when="next_reset")
    step(envs)
    assert envs.param(0, GRAVITY) == pytest.approx(-9.81)
    envs.reset()
    assert envs.param(0, GRAVITY) == -5.0


def test_a_pool_takes_requests_in_flight():
    with closing(skybody.make_pool("hover", num_envs=4, batch_size=2, seed=3)) as pool:
        pool.async_reset()
        pool.request([0], {GRAVITY: -5.0})
        for _ in range(8):
            ids = pool.recv()[4]["env_id"].copy()
            pool.send(np.zeros((len(ids), 4), np.float32), ids)
        while pool.native.in_flight > 0:
            pool.recv()
        assert pool.param(0, GRAVITY) == -5.0


def test_a_simulation_takes_requests():
    sim = skybody.Simulation("hover", seed=1)
    sim.reset()
    sim.request({GRAVITY: -5.0})
    sim.request({GRAVITY: -6.0}, when="next_reset")
    assert sim.param(GRAVITY) == pytest.approx(-9.81)
    sim.advance(1)
    assert sim.param(GRAVITY) == -5.0
    sim.reset()
    assert sim.param(GRAVITY) == -6.0


def test_a_recording_of_requests_is_replayed(tmp_path: Path):
    file = tmp_path / "run.h5"
    with closing(skybody.make_vec("hover", num_envs=4, seed=3)) as envs:
        envs.record(file)
        envs.reset()
        for k in range(20):
            envs.request(
                [k % 4],
                {
                    GRAVITY: {
                        "distribution": "normal",
                        "mean": -9.81,
                        "deviation": 1.0,
                        "range": [-12.0, -8.0],
                    }
                },
            )
            envs.request(
                None,
                {"robots.quad.rotors[*].thrust_constant": {"range": [0.9, 1.1], "form": "scale"}},
                when="next_reset",
            )
            if k % 5 == 0:
                envs.randomize([1, 3])
            step(envs)
        envs.stop_recording()
    done = subprocess.run(
        [str(PROGRAM), "replay", str(file), "--threads", "3"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0 and done.stdout.startswith("identical"), done.stdout + done.stderr


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"gravty": 1.0}, "nothing randomizable is called `gravty`"),
        ({GRAVITY: {"range": [1.0, 0.0]}}, "runs backwards"),
        ({GRAVITY: {"range": [1.0]}}, "range of 1 numbers"),
        ({GRAVITY: {"low": 1.0}}, "has 'low'; there are distribution"),
        ({GRAVITY: {"distribution": "flat"}}, "has distribution 'flat'"),
        ({GRAVITY: {"distribution": "normal", "mean": 0.0}}, "needs 'deviation'"),
        ({GRAVITY: {"values": [1.0]}}, "which uniform does not know"),
        (
            {GRAVITY: {"distribution": "choice", "values": [-1, -2], "weights": [0.5, 0.4]}},
            "add up to",
        ),
        ({GRAVITY: float("nan")}, "must be finite"),
        ({"robots.quad.links.base_link.mass": -1.0}, "allowed is"),
        ({"gravity": [0.0, 0.0]}, "`gravity` has 3 values, and 2 are given: give all 3"),
        ({"gravity": [1.0, 2.0, 3.0, 4.0]}, "`gravity` has 3 values, and 4 are given"),
        ({"gravity": []}, "shape (0,)"),
        ({GRAVITY: [-9.0]}, "`gravity[2]` is one number, and a list of 1 is given"),
        (
            {"robots.quad.rotors[*].thrust_constant": [1.0, 1.0, 1.0, 1.0]},
            "`robots.quad.rotors[0].thrust_constant` is one number",
        ),
        ({"gravitty": [0.0, 0.0, -1.0]}, "did you mean `gravity`?"),
        (
            {GRAVITY: {"distribution": "choice", "values": [-1, -2], "weights": [0.5, 0.4, 0.1]}},
            "2 values and 3 weights",
        ),
    ],
)
def test_what_cannot_be_is_refused(envs, changes, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        envs.request(None, changes)
    with pytest.raises(ValueError, match="next_step"):
        envs.request(None, {GRAVITY: -9.0}, when="now")


@pytest.mark.parametrize(
    "change",
    [
        None,
        "x",
        True,
        [None, 1.0, 2.0],
        [[1.0], [1.0, 2.0]],
        {"range": ["a", "b"]},
        {"range": None},
    ],
)
def test_what_is_no_number_is_refused_by_its_path(envs, change):
    with pytest.raises(TypeError, match=r"gravity is given .*must be"):
        envs.request(None, {"gravity": change})


def test_vectors_of_all_robots_and_by_alias_have_their_sizes(envs):
    envs.request(None, {"robots.quad.rotors[*].position": [0.1, 0.2, 0.3]})
    envs.request(None, {"robot.links.base_link.com": [0.0, 0.0, 0.01]})
    step(envs)
    assert envs.param(0, "robots.quad.rotors[3].position[1]") == 0.2
    with pytest.raises(ValueError, match="has 6 values, and 3 are given"):
        envs.request(None, {"robots.quad.links.base_link.inertia": [0.01, 0.01, 0.01]})


def test_single_values_have_no_vectors(envs):
    for call in (lambda: envs.param(0, "gravity"), lambda: envs.set_param(0, "gravity", 7.0)):
        with pytest.raises(ValueError, match=re.escape("such as `gravity[0]`")):
            call()


def test_lines_are_exact(envs):
    compiled = envs.compiled
    assert request_lines(compiled, {GRAVITY: 0.1, "gravity": [1, 2e-300, 0]}) == [
        "gravity[2] value each constant 0.1",
        "gravity[0] value each constant 1.0",
        "gravity[1] value each constant 2e-300",
        "gravity[2] value each constant 0.0",
    ]


def test_an_inertia_that_cannot_be_is_a_fault_until_it_is_nominal_again(envs):
    inertia = "robots.quad.links.base_link.inertia[0]"
    idle = np.zeros(envs.action_space.shape, np.float32)
    nominal = envs.param(0, inertia)

    def faults() -> list[bool]:
        return [bool(envs.step(idle)[4]["fault"][0]) for _ in range(4)]

    envs.request([0], {inertia: 10.0})
    assert any(faults()) and any(faults()), "in every episode that follows"
    envs.request([0], {inertia: {"range": [1.0, 1.0], "form": "scale"}})
    faults()
    assert not any(faults())
    assert envs.param(0, inertia) == nominal
    envs.request([0], {inertia: 10.0})
    assert any(faults())
    envs.reset(seed=5)
    assert envs.param(0, inertia) == nominal
    assert not any(faults())
