"""A mission of `skybody onboard`: a policy with all that its observation needs, in one file."""

from __future__ import annotations

import argparse
import contextlib
import math
from pathlib import Path

import numpy as np

from skybody import FlightPolicy, InputError, Simulation
from skybody._native import Error, mission_bytes
from skybody.onboard.lockstep import Vehicle, fly
from skybody.onboard.program import about, running

from .lockstep import SEED, Different
from .source import PolicySource


def write(source: PolicySource, path: Path, options: argparse.Namespace) -> None:
    """Writes the file, which the program onboard must accept; with --check also flies it."""
    agent = agent_of(source, options.robot)
    try:
        content = mission_bytes(
            source.compiled, str(source.file), agent, limits_of(options.limit or ())
        )
    except Error as error:
        raise InputError(str(error)) from None
    path.write_bytes(content)
    print(about(path), end="")
    if options.check:
        print(check(source, path, agent, options.check))


def agent_of(source: PolicySource, robot: str | None) -> int:
    """The place of a robot among those that share the policy.

    Raises:
        InputError: it does not share it.
    """
    robots = source.interface.robots
    if robot is None:
        return 0
    if robot in robots:
        return robots.index(robot)
    raise InputError(f"--robot {robot}: the policy is shared by {', '.join(robots) or 'no robots'}")


def limits_of(words: tuple[str, ...] | list[str]) -> dict[str, list[float]]:
    """Limits from words NAME=VALUE,...

    Raises:
        InputError: a value is no finite number.
    """
    limits = {}
    for word in words:
        name, _, text = word.partition("=")
        try:
            values = [float(value) for value in text.split(",")]
        except ValueError:
            values = []
        if not values or not all(map(math.isfinite, values)):
            raise InputError(f"--limit {word}; allowed: NAME=NUMBER, several with commas")
        limits[name] = values
    return limits


def check(source: PolicySource, mission: Path, agent: int, episodes: int) -> str:
    """Flies episodes by the program in lockstep and compares every action with the engine's.

    Returns:
        A line about the flights.

    Raises:
        Different: an action differs in a bit.
        InputError: robots that share the policy fly as a team: one vehicle cannot.
    """
    if source.policy.agents:
        raise InputError("--check is for policies of one robot; this one is shared by a team")
    simulation = Simulation(source.compiled, seed=SEED)
    twin = Simulation(source.compiled, seed=SEED)
    engine = FlightPolicy(source.compiled, str(source.file))
    steps = 0
    far = ",".join(["-1e9"] * 3 + ["1e9"] * 3)
    options = ["--lockstep", "--limit", "tilt=4", "--limit", f"fence={far}"]
    with (
        running(mission, options) as (port, _),
        contextlib.closing(Vehicle(simulation, port)) as vehicle,
    ):
        for episode in range(1, episodes + 1):
            simulation.reset()
            twin.reset()
            for answer in fly(simulation, vehicle):
                expected = engine.act(twin)
                if expected.tobytes() != answer.action.tobytes():
                    reason = f" ({', '.join(answer.reasons)})" if answer.reasons else ""
                    raise Different(
                        f"episode {episode}, step {twin.steps}: the program gives {answer.action}"
                        f"{reason}, the engine {np.asarray(expected)}: not equal, nothing written"
                    )
                twin.step(expected)
                steps += 1
    return f"{episodes} episodes, {steps} steps: every action equal in all bits"
