"""The task's info values: from columns of a batch to the dictionaries that learners expect."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._native import Batch, CompiledScenario

RESERVED = (
    "env_id",
    "was_reset",
    "fault",
    "fault_reason",
    "agent_reward",
    "privileged",
    "final_obs",
    "final_info",
    "terminal_observation",  # Stable-Baselines3's
)


def add_fault_reasons(infos: dict[str, Any], batch: Batch) -> None:
    """`fault_reason`, text per row, only where some row is a fault; the mask is `fault`."""
    reasons = batch.fault_reasons
    if reasons is not None:
        infos["fault_reason"] = np.array(reasons, dtype=object)
        infos["_fault_reason"] = batch.fault


class InfoChannels:
    """Where each of a task's info values lies in a row of `Batch.info`.

    Beside them an info has `privileged` where the scenario has privileged columns.

    Args:
        present: whether rows carry them at all; else there are none.

    Raises:
        ValueError: a task declares an info value under a name that Skybody uses itself.
    """

    def __init__(self, compiled: CompiledScenario, present: bool = True) -> None:
        self._has_privileged = compiled.privileged_size > 0
        self._columns: list[tuple[str, str, int | slice]] = []
        for channel in compiled.info_channels if present else ():
            if channel.name in RESERVED:
                raise ValueError(
                    f"the task of `{compiled.name}` declares an info value `{channel.name}`, "
                    f"but Skybody itself uses the names {', '.join(RESERVED)}: rename it"
                )
            end = channel.first + channel.count
            where = channel.first if channel.count == 1 else slice(channel.first, end)
            self._columns.append((channel.name, "_" + channel.name, where))

    def columns(
        self, rows: NDArray[np.float32], privileged: NDArray[np.float32]
    ) -> dict[str, NDArray[Any]]:
        """One array per info value, (n,) or (n, count): views of `rows`, (n, info_size)."""
        infos: dict[str, NDArray[Any]] = {name: rows[:, where] for name, _, where in self._columns}
        if self._has_privileged:
            infos["privileged"] = privileged
        return infos

    def masked(
        self,
        rows: NDArray[np.float32],
        privileged: NDArray[np.float32],
        mask: NDArray[np.bool_],
    ) -> dict[str, NDArray[Any]]:
        """The same with Gymnasium's `_name` masks, which say for which rows a value is given."""
        infos: dict[str, NDArray[Any]] = {}
        for name, mask_name, where in self._columns:
            infos[name] = rows[:, where]
            infos[mask_name] = mask
        if self._has_privileged:
            infos["privileged"], infos["_privileged"] = privileged, mask
        return infos

    def of_row(self, row: NDArray[np.float32], privileged: NDArray[np.float32]) -> dict[str, Any]:
        """Values of one row, (info_size,): np.float32 each, or a copy (count,)."""
        info: dict[str, Any] = {
            name: row[where].copy() if isinstance(where, slice) else row[where]
            for name, _, where in self._columns
        }
        if self._has_privileged:
            info["privileged"] = privileged.copy()
        return info
