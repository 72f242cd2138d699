"""Gymnasium spaces from the channels that a scenario's task and controllers declare."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict
from numpy.typing import NDArray

from ._native import CompiledScenario, ObservationColumn
from .observations import Observations, key_of


def observation_bounds(
    compiled: CompiledScenario,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Lowest and highest value of each entry of an observation row, (observation_size,) each.

    Units are those of the channels (SI); an entry without a bound has -inf or inf.
    """
    low = np.empty(compiled.observation_size, np.float32)
    high = np.empty(compiled.observation_size, np.float32)
    for channel in compiled.observation_channels:
        low[channel.first : channel.first + channel.count] = channel.low
        high[channel.first : channel.first + channel.count] = channel.high
    return low, high


def observation_space(compiled: CompiledScenario) -> Box[np.float32]:
    """Observations of one environment: Box (observation_size,), float32."""
    return Box(*observation_bounds(compiled), dtype=np.float32)


def column_space(column: ObservationColumn) -> Box[Any]:
    """Space of one column: Box of its shape, dtype and bounds."""
    return Box(column.low, column.high, column.shape, np.dtype(column.dtype).type)


def dict_space(columns: Iterable[ObservationColumn]) -> Dict:
    """A Box for each column, under its key."""
    return Dict({key_of(column): column_space(column) for column in columns})


def space_of(compiled: CompiledScenario, observations: Observations) -> Box[np.float32] | Dict:
    """Observations of one environment: a Box, or a Dict with a Box for each column's key."""
    if observations.columns is None:
        return observation_space(compiled)
    return dict_space(observations.columns)


def batched(space: Box[np.float32] | Dict, count: int) -> Box[np.float32] | Dict:
    """The space of `count` observations: each Box is (count, *shape)."""
    if isinstance(space, Dict):
        boxes = {key: box for key, box in space.items() if isinstance(box, Box)}
        return Dict({key: batch(box, count) for key, box in boxes.items()})
    return batch(space, count)


def action_space(compiled: CompiledScenario) -> Box[np.float32]:
    """Actions of one environment: Box [-1, 1] (action_size,), float32.

    The values of -1 and 1 in SI units are `compiled.action_channels[k].low` and `.high`.
    """
    return Box(-1.0, 1.0, (compiled.action_size,), np.float32)


def select(space: Box[np.float32], entries: Sequence[int] | NDArray[np.intp]) -> Box[np.float32]:
    """The space of some entries of a flat space, in the given order."""
    return Box(space.low[entries], space.high[entries], dtype=np.float32)


def batch(space: Box[Any], count: int) -> Box[Any]:
    """The space of `count` rows, (count, *space.shape)."""
    repeats = (count,) + (1,) * len(space.shape)
    low, high = np.tile(space.low, repeats), np.tile(space.high, repeats)
    return Box(low, high, dtype=space.dtype.type)


def reshape(space: Box[np.float32], shape: tuple[int, ...]) -> Box[np.float32]:
    """The same bounds in another shape."""
    return Box(space.low.reshape(shape), space.high.reshape(shape), dtype=np.float32)
