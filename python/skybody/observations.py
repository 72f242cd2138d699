"""Observations for a learner: one flat row, or a dictionary of columns by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._native import Batch, CompiledScenario, ObservationColumn, Pool
from .arguments import flag


def key_of(column: ObservationColumn) -> str:
    """Key of a column in a dictionary: its name with `_` for dots, which PyTorch does not allow."""
    return column.name.replace(".", "_")


def policy_columns(compiled: CompiledScenario) -> list[ObservationColumn]:
    """The columns of the policy's observation, in order.

    Raises:
        ValueError: two columns would have the same key.
    """
    columns = [column for column in compiled.observation_columns if not column.privileged]
    keys = [key_of(column) for column in columns]
    for key in keys:
        if keys.count(key) > 1:
            raise ValueError(
                f"two columns of `{compiled.name}` would have the key `{key}`: give one of them "
                "another `name` in `observe`"
            )
    return columns


class Observations:
    """Converts batches to the observations of `reset` and `step`, without a copy.

    `columns` are those of a dictionary; None: observations are rows (n, observation_size). With an
    image column, observations are always dictionaries.

    Args:
        as_dict: dictionaries, with or without images.
        row_shape: another shape of each row, with the same number of values.

    Raises:
        ValueError: two columns would have the same key, or dictionaries together with a `row_shape`
            (the option `joint`).
    """

    def __init__(
        self,
        compiled: CompiledScenario,
        as_dict: bool,
        row_shape: tuple[int, ...] | None = None,
    ) -> None:
        as_dict = flag("dict_observations", as_dict)
        self._arguments = (compiled, as_dict, row_shape)
        images = [column.name for column in compiled.observation_columns if column.image >= 0]
        if images and row_shape is not None:
            raise ValueError(
                f"`{compiled.name}` observes {', '.join(images)}; observations with images are "
                "dictionaries, and those of joint=True are one array: use joint=False"
            )
        if as_dict and row_shape is not None:
            raise ValueError("joint and dict_observations exclude one another: leave one out")
        self.columns = policy_columns(compiled) if as_dict or images else None
        self._row_shape = row_shape
        self._are_rows = self.columns is None and row_shape is None

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), self._arguments

    def of(self, batch: Batch) -> Any:
        """Observations after the transition."""
        if self._are_rows:
            return batch.observation
        return self._arranged(batch.observation, batch.image)

    def final_of(self, batch: Batch) -> Any:
        """Observations before the reset, with same-step autoreset."""
        return self._arranged(batch.final_observation, batch.final_image)

    def now(self, pool: Pool) -> Any:
        """The last observation of every environment, in new arrays."""
        return self._arranged(pool.observations(), pool.image)

    def _arranged(
        self, rows: NDArray[np.float32], image: Callable[[int], NDArray[np.uint8]]
    ) -> Any:
        if self._row_shape is not None:
            return rows.reshape(len(rows), *self._row_shape)
        if self.columns is None:
            return rows
        return {key_of(c): values_of(c, rows, image) for c in self.columns}


def values_of(
    column: ObservationColumn, rows: NDArray[np.float32], image: Callable[[int], NDArray[np.uint8]]
) -> NDArray[Any]:
    """A column's values (n, *shape), a view."""
    if column.image < 0:
        return rows[:, column.first : column.first + column.shape[0]]
    pixels: NDArray[Any] = image(column.image).view(column.dtype)
    return pixels.reshape(len(pixels), *column.shape)


def apply(change: Callable[[NDArray[Any]], NDArray[Any]], observation: Any) -> Any:
    """Applies `change` to an observation, or to each column of a dictionary."""
    if isinstance(observation, dict):
        return {key: change(values) for key, values in observation.items()}
    return change(observation)


def row_of(observation: Any, i: int) -> Any:
    """A copy of row `i`."""
    return apply(lambda values: values[i].copy(), observation)


def copy_of(observation: Any) -> Any:
    """A copy of all rows."""
    return apply(lambda values: values.copy(), observation)
