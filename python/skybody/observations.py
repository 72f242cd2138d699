"""How a learner sees the columns of the observation: one flat row, or a dictionary by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._native import Batch, Environment, ObservationColumn, Pool


def key_of(column: ObservationColumn) -> str:
    """The key of a column in a dictionary: its name, with `_` for dots, which PyTorch refuses."""
    return column.name.replace(".", "_")


def policy_columns(environment: Environment) -> list[ObservationColumn]:
    """The columns that a policy sees, in order.

    Raises:
        ValueError: two of them would have the same key.
    """
    columns = [column for column in environment.observation_columns if not column.privileged]
    keys = [key_of(column) for column in columns]
    for key in keys:
        if keys.count(key) > 1:
            raise ValueError(
                f"two columns of `{environment.name}` would have the key `{key}`: give one of them "
                "another `name` in `observe`"
            )
    return columns


class Observations:
    """From batches to what `reset` and `step` return, without a copy.

    `columns` are those of a dictionary; None: observations are rows.
    """

    def __init__(self, environment: Environment, as_dict: bool) -> None:
        self.columns = policy_columns(environment) if as_dict else None

    def of_rows(self, rows: NDArray[np.float32]) -> Any:
        """Rows (n, observation_size) as an array, or as a dictionary of views of it."""
        if self.columns is None:
            return rows
        return {key_of(c): rows[:, c.first : c.first + c.shape[0]] for c in self.columns}

    def of(self, batch: Batch) -> Any:
        """Observations after the transition."""
        return self.of_rows(batch.observation)

    def final_of(self, batch: Batch) -> Any:
        """Observations before the reset, with same-step autoreset."""
        return self.of_rows(batch.final_observation)

    def now(self, pool: Pool) -> Any:
        """The last observation of every environment, in new arrays."""
        return self.of_rows(pool.observations())


def apply(change: Callable[[NDArray[Any]], NDArray[Any]], observation: Any) -> Any:
    """`change` of an observation, or of each column of a dictionary."""
    if isinstance(observation, dict):
        return {key: change(values) for key, values in observation.items()}
    return change(observation)


def row_of(observation: Any, i: int) -> Any:
    """A copy of row `i`."""
    return apply(lambda values: values[i].copy(), observation)


def copy_of(observation: Any) -> Any:
    """A copy of all rows."""
    return apply(lambda values: values.copy(), observation)
