"""Entries of observation and action rows by agent, for scenarios with several robots."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ._native import CompiledScenario


def observed_by(compiled: CompiledScenario, robot: int) -> NDArray[np.intp]:
    """Entries of the observation row of an agent: its own channels and the global ones."""
    entries = [
        np.arange(channel.first, channel.first + channel.count)
        for channel in compiled.observation_channels
        if channel.robot in (robot, -1)
    ]
    return np.concatenate(entries) if entries else np.empty(0, np.intp)


def commanded_by(compiled: CompiledScenario, robot: int) -> NDArray[np.intp]:
    """Entries of the action row that belong to an agent."""
    return np.concatenate(
        [
            np.arange(channel.first, channel.first + channel.count)
            for channel in compiled.action_channels
            if channel.robot == robot
        ]
    )


class JointLayout:
    """Shapes of joint arrays of identical agents; rows are reshaped without a copy.

    `observation_shape` is (agents, width), such as (N, 18 + 16 (N - 1)) for the formation task;
    `action_shape` is (agents, width).

    Raises:
        ValueError: the agents' channels are not contiguous, in the order of the agents, or the
            agents have different numbers of values.
    """

    def __init__(self, compiled: CompiledScenario) -> None:
        seen = [observed_by(compiled, robot) for robot in compiled.agents]
        commanded = [commanded_by(compiled, robot) for robot in compiled.agents]
        self.observation_shape = self._shape(compiled, "observation", seen)
        self.action_shape = self._shape(compiled, "action", commanded)

    @staticmethod
    def _shape(
        compiled: CompiledScenario, kind: str, entries: list[NDArray[np.intp]]
    ) -> tuple[int, int]:
        size = compiled.observation_size if kind == "observation" else compiled.action_size
        widths = sorted({len(e) for e in entries})
        if len(widths) != 1 or not np.array_equal(np.concatenate(entries), np.arange(size)):
            raise ValueError(
                f"`{compiled.name}` has no joint {kind} array: its agents have "
                f"{', '.join(map(str, widths))} of {size} values, and joint=True needs equally "
                "many, one agent's after the other's; use joint=False"
            )
        return len(entries), widths[0]
