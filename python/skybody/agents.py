"""Which entries of a row belong to which agent, where a scenario has several robots."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._native import Environment


def observed_by(environment: Environment, robot: int) -> NDArray[np.intp]:
    """Entries of the observation row that an agent sees: its own channels, and those of nobody."""
    entries = [
        np.arange(channel.first, channel.first + channel.count)
        for channel in environment.observation_channels
        if channel.robot in (robot, -1)
    ]
    return np.concatenate(entries) if entries else np.empty(0, np.intp)


def commanded_by(environment: Environment, robot: int) -> NDArray[np.intp]:
    """Entries of the action row that an agent decides."""
    return np.concatenate(
        [
            np.arange(channel.first, channel.first + channel.count)
            for channel in environment.action_channels
            if channel.robot == robot
        ]
    )


class JointLayout:
    """Shapes in which rows of alike agents are the paper's joint arrays, without a copy.

    `observation_shape` is (agents, width), such as (N, 18 + 16 (N - 1)) for the formation task;
    `action_shape` is (agents, width).

    Raises:
        ValueError: the agents' channels do not stand one agent after the other, or differ in
            number.
    """

    def __init__(self, environment: Environment) -> None:
        seen = [observed_by(environment, robot) for robot in environment.agents]
        commanded = [commanded_by(environment, robot) for robot in environment.agents]
        self.observation_shape = self._shape(environment, "observation", seen)
        self.action_shape = self._shape(environment, "action", commanded)

    @staticmethod
    def _shape(
        environment: Environment, kind: str, entries: list[NDArray[np.intp]]
    ) -> tuple[int, int]:
        size = environment.observation_size if kind == "observation" else environment.action_size
        widths = sorted({len(e) for e in entries})
        if len(widths) != 1 or not np.array_equal(np.concatenate(entries), np.arange(size)):
            raise ValueError(
                f"`{environment.name}` has no joint {kind} array: its agents have "
                f"{', '.join(map(str, widths))} of {size} values, and joint=True needs equally "
                "many, one agent's after the other's; use joint=False"
            )
        return len(entries), widths[0]
