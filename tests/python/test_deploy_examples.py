"""The Crazyflie app and the PX4 module compile, and fly a policy in their own frames and units.

Both are compiled against stubs (tests/stubs) that have the names and types of the real interfaces.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from skybody.exports.policy.c_evaluator import CEvaluator
from skybody.exports.policy.c_files import write_sources
from skybody.exports.policy.source import PolicySource
from test_export_policy import opened

from research.deploy.network_drafts import write_draft

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES, STUBS = ROOT / "examples/deploy", ROOT / "tests/stubs"
SCENARIO = EXAMPLES / "crazyflie/crazyflie_ctbr.yaml"
WARNINGS = ("-Wall", "-Wextra", "-Werror", "-O2")
FLIP = np.array([1.0, -1.0, -1.0])  # between x forward, y left, z up and x forward, y right, z down
STEPS = 20
MOST_THRUST = 0.6  # N, of the Crazyflie's stub

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> PolicySource:
    """A policy with memory, in the folder `c` beside it."""
    folder = tmp_path_factory.mktemp("policy")
    draft = write_draft(folder / "policy.h5", str(SCENARIO), "with_memory")
    found = opened(draft, str(SCENARIO), "policy")
    write_sources(found, folder / "c")
    return found


def states() -> list[dict[str, Array]]:
    """Random motions in Skybody's axes, with goals; the quaternions have both signs."""
    random = np.random.default_rng(8)
    made = []
    for _ in range(STEPS):
        quaternion = random.normal(size=4)
        made.append(
            {
                "goal": random.normal(size=3),
                "goal_yaw": random.uniform(-3, 3, 1),
                "position": random.normal(size=3),
                "velocity": random.normal(size=3),
                "quaternion": quaternion / np.linalg.norm(quaternion),
                "rate": random.normal(size=3),
                "yaw": random.uniform(-3, 3, 1),
            }
        )
    return made


def expected(source: PolicySource, moving: list[dict[str, Array]]) -> list[Array]:
    """Commands: thrust [N] and rates [rad/s] in Skybody's axes."""
    evaluator = CEvaluator(source, source.file.parent / "c")
    commands = []
    for state in moving:
        yaw = state["goal_yaw"] - state["yaw"]
        evaluator.act(
            {
                "position_error": state["goal"] - state["position"],
                "yaw_error": (yaw + np.pi) % (2.0 * np.pi) - np.pi,
                "velocity": state["velocity"],
                "attitude": state["quaternion"] * np.sign(state["quaternion"][0]),
                "angular_velocity": state["rate"],
            }
        )
        commands.append(evaluator.command.astype(float))
    return commands


def run(program: Path, lines: list[str]) -> list[str]:
    done = subprocess.run(
        [program], input="\n".join(lines) + "\n", capture_output=True, text=True, check=True
    )
    return done.stdout.splitlines()


def words(*values: Array | float) -> str:
    return " ".join(f"{v:.9g}" for value in values for v in np.atleast_1d(value))


@pytest.fixture(scope="module")
def crazyflie(source: PolicySource) -> Path:
    c = source.file.parent / "c"
    program = c / "crazyflie"
    command = ["gcc", "-std=gnu11", *WARNINGS, f"-I{c}", f"-I{STUBS / 'crazyflie'}"]
    command += [str(EXAMPLES / "crazyflie/src/app_main.c"), str(STUBS / "crazyflie/fly.c")]
    subprocess.run([*command, str(c / "policy.c"), "-o", str(program)], check=True)
    return program


def crazyflie_line(state: dict[str, Array], flies: int = 1) -> str:
    """Rates and yaw in degrees."""
    return f"{flies} " + words(
        state["goal"],
        state["goal_yaw"],
        state["position"],
        state["velocity"],
        state["quaternion"],
        np.degrees(state["rate"]),
        np.degrees(state["yaw"]),
    )


def test_the_crazyflie_app_commands_rates_in_degrees_with_pitch_reversed(
    source: PolicySource, crazyflie: Path
) -> None:
    moving = states()
    first, *given = run(crazyflie, [crazyflie_line(state) for state in moving])
    assert first == "period 20"
    for line, command in zip(given, expected(source, moving), strict=True):
        thrust, roll, pitch, yaw, *modes = (float(word) for word in line.split())
        # Floats, and inputs converted to degrees and back: 1e-5 of the ranges.
        assert thrust / 65535.0 * MOST_THRUST == pytest.approx(command[0], abs=5e-6)
        rates = np.radians([roll, -pitch, yaw])
        assert rates == pytest.approx(command[1:], abs=2e-4)
        assert modes == [2.0, 2.0, 2.0, 0.0]  # rates of all axes, thrust not controlled


def test_the_crazyflie_app_is_silent_unless_it_shall_fly_and_has_numbers(
    source: PolicySource, crazyflie: Path
) -> None:
    moving = states()
    bad = dict(moving[1], velocity=np.array([0.0, np.nan, 0.0]))
    lines = [crazyflie_line(moving[0], 0), crazyflie_line(bad), crazyflie_line(moving[0])]
    given = run(crazyflie, lines)[1:]
    assert given[:2] == ["none", "none"]
    # The first step of an episode, as if the others had not been.
    (first,) = expected(source, moving[:1])
    assert float(given[2].split()[0]) / 65535.0 * MOST_THRUST == pytest.approx(first[0], abs=5e-6)


@pytest.fixture(scope="module")
def px4(source: PolicySource) -> Path:
    c, module = source.file.parent / "c", EXAMPLES / "px4/skybody_policy"
    program = c / "px4"
    subprocess.run(["gcc", *WARNINGS, "-c", str(c / "policy.c"), "-o", str(c / "o")], check=True)
    command = ["g++", "-std=c++17", *WARNINGS, f"-I{c}", f"-I{module}", f"-I{STUBS / 'px4'}"]
    command += [str(module / "SkybodyPolicy.cpp"), str(STUBS / "px4/fly.cpp"), str(c / "o")]
    subprocess.run([*command, "-o", str(program)], check=True)
    return program


def px4_line(state: dict[str, Array], flies: int = 1, age: int = 0) -> str:
    """In NED and FRD."""
    w, *vector = state["quaternion"]
    return f"{flies} {age} " + words(
        state["goal"] * FLIP,
        -state["goal_yaw"],
        state["position"] * FLIP,
        state["velocity"] * FLIP,
        w,
        vector * FLIP,
        state["rate"] * FLIP,
        -state["yaw"],
    )


def test_the_px4_module_commands_rates_in_frd_and_thrust_as_a_share(
    source: PolicySource, px4: Path
) -> None:
    moving = states()
    first, *given = run(px4, [px4_line(state) for state in moving])
    assert first == "period 20000"
    most = source.interface.outputs[0].high[0]
    for line, command in zip(given, expected(source, moving), strict=True):
        thrust, roll, pitch, yaw, announced = (float(word) for word in line.split())
        assert -thrust * most == pytest.approx(command[0], abs=1e-6)
        assert FLIP * [roll, pitch, yaw] == pytest.approx(command[1:], abs=2e-5)
        assert announced == 1.0


def test_the_px4_module_publishes_nothing_from_old_messages_and_no_rates_outside_offboard(
    px4: Path,
) -> None:
    state = states()[0]
    given = run(px4, [px4_line(state, age=300_000), px4_line(state, flies=0), px4_line(state)])
    assert given[1:3] == ["none 0", "none 1"]
    assert given[3].endswith(" 1")
    assert not given[3].startswith("none")
