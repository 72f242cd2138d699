"""Flies an exported policy in lockstep with the engine's own evaluator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skybody import FlightPolicy, Simulation

from .interface import Interface
from .source import PolicySource

SEED = 0


class Different(Exception):
    """An action of the exported policy differs from the engine's."""


class Evaluator(Protocol):
    """An exported policy, of one robot."""

    def reset(self) -> None:
        """Begins an episode."""

    def act(self, values: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """Actions in [-1, 1] of inputs by name."""


def check(
    source: PolicySource, make: Callable[[int], Evaluator], episodes: int, largest: float
) -> str:
    """Flies episodes by the engine's evaluator and compares every action.

    Args:
        make: makes the evaluator of a robot, by its place among those that share the policy.
        largest: allowed difference of an action; 0: none, also in bits.

    Returns:
        A line about the flights.

    Raises:
        Different: an action differs by more.
    """
    simulation = Simulation(source.compiled, seed=SEED)
    engine = FlightPolicy(source.compiled, str(source.file))
    evaluators = [make(robot) for robot in range(max(1, len(source.interface.robots)))]
    steps, found = 0, 0.0
    for episode in range(1, episodes + 1):
        simulation.reset()
        for evaluator in evaluators:
            evaluator.reset()
        while not (simulation.terminated or simulation.truncated):
            expected = engine.act(simulation)
            given = _actions(source, simulation, evaluators)
            found = max(found, _difference(expected, given, largest, episode, simulation.steps))
            simulation.step(expected)
            steps += 1
    difference = "equal in all bits" if largest == 0.0 else f"equal within {found:.1e}"
    return f"{episodes} episodes, {steps} steps: every action {difference}"


def _difference(
    expected: NDArray[np.float32],
    given: NDArray[np.float32],
    largest: float,
    episode: int,
    step: int,
) -> float:
    """The largest difference. Raises Different if it is not allowed."""
    differs = expected.view(np.uint32) != given.view(np.uint32)
    far = np.abs(expected.astype(np.float64) - given)
    bad = differs if largest == 0.0 else ~(far <= largest)
    if bad.any():
        k = int(np.flatnonzero(bad)[0])
        raise Different(
            f"episode {episode}, step {step}: action {k} is {given[k]:.9g}, the engine's "
            f"{expected[k]:.9g}: not equal, nothing written"
        )
    return float(far.max(initial=0.0))


def _actions(
    source: PolicySource, simulation: Simulation, evaluators: list[Evaluator]
) -> NDArray[np.float32]:
    """The action row of the exported policy."""
    row = simulation.observation
    images = {image.name: simulation.image(image.column) for image in source.interface.images}
    agents = source.policy.agents
    if not agents:
        return evaluators[0].act(inputs_by_name(source.interface, row) | images)
    actions = np.zeros(source.compiled.action_size, np.float32)
    for agent, evaluator in zip(agents, evaluators, strict=True):
        values = inputs_by_name(source.interface, row[agent.observation])
        actions[agent.action] = evaluator.act(values)
    return actions


def inputs_by_name(
    interface: Interface, inputs: NDArray[np.float32]
) -> dict[str, NDArray[np.float32]]:
    """The network's inputs (I,) by name, without past actions."""
    return {s.name: inputs[s.first : s.first + s.count] for s in interface.inputs}
